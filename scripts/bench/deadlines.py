#!/usr/bin/env python3
"""How far `kiln batch --time` overruns its deadline, asset by asset.

    scripts/bench/deadlines.py --kiln target/release/kiln --time 1 [--sample N] [--csv FILE] [FLAGS OF BATCH …] -- FOLDER…

Renders every asset below the folders (or N of them, drawn with a fixed seed), one at a time, and compares the asset's total seconds
with the time that it was given. Beside each overrun stands how long threads of Kiln that were ready to run waited for a
processor in the tenth of a second before the deadline and from there to the end (Linux: /proc/PID/task/*/schedstat): what other
work on the machine does to a deadline cannot be told from Kiln's own doing otherwise.
"""
import argparse
import json
import random
import subprocess
import tempfile
import time
from pathlib import Path

ENDINGS = {".gltf", ".glb", ".obj", ".ray"}
#: Seconds before the deadline from which on waiting counts.
BEFORE = 0.1


def waited(pid):
    """Seconds that each of a process's threads has waited for a processor so far."""
    result = {}
    for task in Path(f"/proc/{pid}/task").glob("*"):
        try:
            result[task.name] = int((task / "schedstat").read_text().split()[1]) * 1e-9
        except (OSError, IndexError):
            pass
    return result


def watch(command, manifest):
    """Runs a batch; gives (moment, waited, lines of the manifest) every 20 ms."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    log = []
    while process.poll() is None:
        lines = manifest.read_bytes().count(b"\n") if manifest.exists() else 0
        log.append((time.monotonic(), waited(process.pid), lines))
        time.sleep(0.02)
    return log


def starved(log, line, overrun):
    """The longest that any thread waited from shortly before the deadline of the asset of a manifest's line to its end."""
    end = next((k for k, (_, _, lines) in enumerate(log) if lines > line), len(log) - 1)
    begin = max((k for k in range(end + 1) if log[k][0] < log[end][0] - overrun - BEFORE), default=0)
    return max((w - log[begin][1].get(t, 0.0) for t, w in log[end][1].items()), default=0.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kiln", default="target/release/kiln")
    parser.add_argument("--time", type=float, required=True)
    parser.add_argument("--sample", type=int, help="so many assets instead of all")
    parser.add_argument("--largest", type=int, default=0, help="and so many of the largest files")
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--but", nargs="*", default=[], type=Path, help="leave out the assets of these earlier CSV files")
    parser.add_argument("--flags", default="--width 256")
    parser.add_argument("folders", nargs="+", type=Path)
    options = parser.parse_args()
    earlier = {line.split(",", 4)[4] for p in options.but for line in p.read_text().splitlines()[1:]}
    assets = sorted(
        p
        for f in options.folders
        for p in f.rglob("*")
        if p.suffix.lower() in ENDINGS and str(p.relative_to(f)) not in earlier
    )
    if options.sample:
        largest = sorted(assets, key=lambda p: p.stat().st_size)[-options.largest :] if options.largest else []
        random.seed(1)
        assets = sorted({*random.sample(assets, options.sample), *largest})
    rows = []
    for folder in options.folders:
        own = [p for p in assets if p.is_relative_to(folder)]
        includes = [w for p in own for w in ("--include", str(p.relative_to(folder)).replace("[", "[[]"))]
        if not own:
            continue
        with tempfile.TemporaryDirectory() as out:
            manifest = Path(out) / "manifest.jsonl"
            command = [options.kiln, "batch", str(folder), *includes, "--out", out, "--jobs", "1", "--time", str(options.time)]
            log = watch([*command, *options.flags.split(), "--quiet"], manifest)
            for number, line in enumerate(manifest.read_text().splitlines()):
                line = json.loads(line)
                overrun = line["seconds"]["total"] - options.time
                wait = starved(log, number, max(overrun, 0.0))
                rows.append((overrun, wait, line["status"], line.get("error_code") or "", line["input"]))
    rows.sort(reverse=True)
    if options.csv:
        text = "".join(f"{o:.4f},{w:.4f},{s},{c},{i}\n" for o, w, s, c, i in rows)
        options.csv.write_text("overrun,waited,status,error_code,input\n" + text)
    allowed = max(0.1 * options.time, 0.1)
    late = [r for r in rows if r[0] > allowed]
    rank = max(0, round(0.01 * len(rows)) - 1)
    print(f"T = {options.time} s: {len(rows)} assets, {len(late)} later than {allowed:.2f} s; worst {rows[0][0]:+.3f} s, "
          f"99th percentile {rows[rank][0]:+.3f} s; without the time that threads waited for a processor: "
          f"{sum(o - w > allowed for o, w, *_ in rows)} late, worst {max(o - w for o, w, *_ in rows):+.3f} s")
    print("statuses:", {s: sum(r[2] == s for r in rows) for s in {r[2] for r in rows}},
          "codes:", {c: sum(r[3] == c for r in rows) for c in {r[3] for r in rows} if c})
    for overrun, wait, status, code, name in rows[:8]:
        print(f"  {overrun:+.3f} s, waited {wait:.3f} s, {status} {code} {name}")


main()
