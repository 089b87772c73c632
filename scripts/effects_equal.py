#!/usr/bin/env python3
"""Pruned and full renderer over folders: `python3 scripts/effects_equal.py KILN OUT FOLDER… [-- OPTIONS OF kiln batch]`.

Renders everything twice, as the scenes call for it and with `--effects all`, and compares the EXR files byte for byte (all layers; the
metadata, too, but for CPU seconds). Prints what differs, and the CPU seconds of both, asset by asset, as a Markdown table.
"""
import json
import statistics
import subprocess
import sys
from pathlib import Path


def batch(kiln, out, folders, options, effects):
    command = [kiln, "batch", *folders, "--out", out, "--effects", effects, "--format", "exr", "--quiet", *options]
    subprocess.run(command, check=False)
    lines = (out / "manifest.jsonl").read_text().splitlines()
    return {record["input"]: record for record in map(json.loads, lines) if "input" in record}


def main(kiln, out, *rest):
    cut = rest.index("--") if "--" in rest else len(rest)
    folders, options = rest[:cut], list(rest[cut + 1:])
    out = Path(out)
    sets = {effects: batch(kiln, out / effects, folders, options, effects) for effects in ("auto", "all")}
    equal, differ, gains = 0, [], []
    for name, pruned in sorted(sets["auto"].items()):
        full = sets["all"].get(name, {})
        if pruned.get("status") != full.get("status"):
            differ.append(f"{name}: {pruned.get('status')} and {full.get('status')}")
        for file in [o["path"] for o in pruned.get("outputs") or [] if o["path"].endswith(".exr")]:
            if (out / "auto" / file).read_bytes() == (out / "all" / file).read_bytes():
                equal += 1
            else:
                differ.append(f"{name}: {file}")
        seconds = [record.get("cpu_seconds", {}).get("render") for record in (pruned, full)]
        if all(seconds):
            gains.append((seconds[1] / seconds[0], name, seconds))
    print(f"{equal} EXR files are equal byte for byte, {len(differ)} are not" + "".join(f"\n- {d}" for d in differ))
    gains.sort(reverse=True)
    ratios = [gain for gain, _, _ in gains]
    quartiles = statistics.quantiles(ratios, n=4)
    print(f"\nCPU of rendering, full over pruned: best {ratios[0]:.2f}, quartiles {quartiles[2]:.2f}, {quartiles[1]:.2f}, {quartiles[0]:.2f}, worst {ratios[-1]:.2f}\n")
    print("| asset | pruned, s | full, s | gain |\n| --- | --- | --- | --- |")
    for gain, name, (pruned, full) in gains:
        print(f"| {Path(name).name} | {pruned:.2f} | {full:.2f} | {gain:.2f} |")
    return not differ


if __name__ == "__main__":
    sys.exit(0 if main(*sys.argv[1:]) else 1)
