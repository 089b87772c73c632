#!/usr/bin/env python3
"""Runs `kiln batch` over many tiny assets and watches the process that hands them out, then runs it again with nothing to do.

    scripts/bench/many_assets.py KILN COUNT... [-- OPTION...]

For each count, a folder of OBJ files of three triangles, 1000 to a folder and each different, becomes PNG files of 8 × 8 pixels
with one sample. Prints one JSON object a count. Linux: figures are of /proc, looked at twenty times a second; memory is resident."""

import json, os, pathlib, subprocess, sys, tempfile, time

TICK = os.sysconf("SC_CLK_TCK")
OBJ = "v -0.5 0 0\nv 0.5 0 0\nv 0.5 1 0\nv -0.5 1 {z}\nv 0 0 1\nf 1 2 3 4\nf 1 2 5\n"


def make(folder, count):
    for i in range(count):
        path = folder / f"{i // 1000:03}" / f"{i:06}.obj"
        if i % 1000 == 0:
            path.parent.mkdir(parents=True)
        path.write_text(OBJ.format(z=i / count))


def run(kiln, folder, out, options):
    """Exit code, wall seconds, CPU seconds of the process alone and with its workers, memory over time and at its most."""
    command = [kiln, "batch", str(folder), "--out", str(out), "--format", "png", "--width", "8", "--spp", "1", "--quiet", *options]
    begin = time.monotonic()
    process = subprocess.Popen(command)
    proc = pathlib.Path(f"/proc/{process.pid}")
    own, seen, peak, manifest = 0.0, [], 0, out / "manifest.jsonl"
    while True:
        try:
            stat = (proc / "stat").read_text().rsplit(")", 1)[1].split()
            status = dict(l.split(":", 1) for l in (proc / "status").read_text().splitlines() if l.startswith("Vm"))
            own = (int(stat[11]) + int(stat[12])) / TICK
            peak = int(status["VmHWM"].split()[0]) / 1024
            seen.append((manifest.stat().st_size if manifest.exists() else 0, int(status["VmRSS"].split()[0]) / 1024))
        except (OSError, KeyError, IndexError):
            pass
        try:
            process.wait(0.05)
            break
        except subprocess.TimeoutExpired:
            pass
    wall = time.monotonic() - begin
    total = max((size for size, _ in seen), default=0)
    # What it holds when a tenth, a half and nine tenths of the manifest are there; at the end the gallery is made.
    held = {f"{part:.0%}": round(next((mb for size, mb in seen if size >= part * total), 0), 1) for part in (0.1, 0.5, 0.9)}
    return {"exit": process.returncode, "wall_s": round(wall, 2), "cpu_s": own, "held_mb": held, "peak_mb": round(peak, 1)}


def main():
    arguments = sys.argv[1:]
    cut = arguments.index("--") if "--" in arguments else len(arguments)
    kiln, counts, options = arguments[0], [int(n) for n in arguments[1:cut]], arguments[cut + 1 :]
    for count in counts:
        with tempfile.TemporaryDirectory() as top:
            top = pathlib.Path(top)
            make(top / "in", count)
            before = os.times()
            first = run(kiln, top / "in", top / "out", options)
            after = os.times()
            all_cpu = after.children_user + after.children_system - before.children_user - before.children_system
            stages = sum(json.loads(line)["cpu_seconds"]["total"] for line in (top / "out/manifest.jsonl").open())
            again = run(kiln, top / "in", top / "out", options)
            print(json.dumps({
                "assets": count, "first": first, "all_processes_cpu_ms_an_asset": round(1000 * all_cpu / count, 3),
                "stages_cpu_ms_an_asset": round(1000 * stages / count, 3),
                "driver_cpu_ms_an_asset": round(1000 * first["cpu_s"] / count, 3),
                "again": again, "again_assets_a_second": round(count / again["wall_s"]),
            }), flush=True)


if __name__ == "__main__":
    main()
