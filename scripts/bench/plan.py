#!/usr/bin/env python3
"""Holds the forecasts of `kiln plan` against what `kiln batch` then takes.

    scripts/bench/plan.py --kiln target/release/kiln --groups N --size N [FLAGS OF BATCH …] -- FOLDER…

Draws groups of assets from below the folders (fixed seed), plans and renders each, and prints a table with the CPU seconds and
the wall seconds foretold and taken, and whether these lie in the interval stated.
"""
import argparse
import json
import random
import subprocess
import tempfile
import time
from pathlib import Path

ENDINGS = {".gltf", ".glb", ".obj", ".ray"}


def group(paths, folders):
    """Globs that choose these assets, and only these."""
    globs = []
    for path in paths:
        folder = next(f for f in folders if path.is_relative_to(f))
        globs += ["--include", str(path.relative_to(folder)).replace("[", "[[]")]
    return globs


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kiln", default="target/release/kiln")
    parser.add_argument("--groups", type=int, default=10)
    parser.add_argument("--size", type=int, default=6, help="assets in a group")
    parser.add_argument("--draw", type=int, default=7, help="which groups are drawn")
    parser.add_argument("--flags", default="--width 128 --spp 32", help="flags of batch and plan")
    parser.add_argument("folders", nargs="+", type=Path)
    options = parser.parse_args()
    assets = sorted(p for f in options.folders for p in f.rglob("*") if p.suffix.lower() in ENDINGS)
    random.seed(options.draw)
    flags = options.flags.split()
    print("| group | assets | CPU foretold | CPU taken | inside | wall foretold | wall taken | inside | peak foretold | peak |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    held = {"cpu": 0, "wall": 0, "memory": 0}
    for number in range(options.groups):
        chosen = random.sample(assets, options.size)
        common = [*map(str, options.folders), *group(chosen, options.folders), *flags]
        plan = subprocess.run([options.kiln, "plan", *common, "--json"], capture_output=True, text=True)
        plan = json.loads(plan.stdout)
        with tempfile.TemporaryDirectory() as out:
            begin = time.monotonic()
            subprocess.run([options.kiln, "batch", *common, "--out", out, "--quiet"], capture_output=True)
            wall = time.monotonic() - begin
            lines = [json.loads(line) for line in (Path(out) / "manifest.jsonl").read_text().splitlines()]
        cpu = sum(line["cpu_seconds"]["total"] for line in lines)
        peak = max(line["peak_bytes"] or 0 for line in lines)
        inside = {}
        for key, figure, taken in (("cpu", plan["cpu_seconds"], cpu), ("wall", plan["seconds"], wall),
                                   ("memory", plan["peak_bytes"], peak)):
            inside[key] = figure["low"] <= taken <= figure["high"]
            held[key] += inside[key]

        def told(figure, scale=1.0, digits=1):
            return f"{figure['expected'] * scale:.{digits}f} ({figure['low'] * scale:.{digits}f}–{figure['high'] * scale:.{digits}f})"

        yes = {k: "yes" if v else "NO" for k, v in inside.items()}
        print(f"| {number + 1} | {len(lines)} | {told(plan['cpu_seconds'])} s | {cpu:.1f} s | {yes['cpu']} | {told(plan['seconds'])} s "
              f"| {wall:.1f} s | {yes['wall']} | {told(plan['peak_bytes'], 1e-6, 0)} MB | {peak * 1e-6:.0f} MB, {yes['memory']} |", flush=True)
    print(f"\nOf {options.groups} groups inside: CPU {held['cpu']}, wall {held['wall']}, memory {held['memory']}.")


main()
