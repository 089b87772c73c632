#!/usr/bin/env python3
"""Import speed and peak memory of Kiln beside Blender's importers, and Mitsuba's for OBJ.

    cargo build --release -p kiln-formats --example import_speed
    pip install bpy mitsuba          # Blender as a module needs the Python that its wheel names
    scripts/bench/import_speed.py target/release/examples/import_speed FOLDER... [--count 10] [--runs 3]

Takes the largest assets below the folders (glTF with all that it refers to), imports each in a process of its own, and
prints a Markdown table: wall and CPU seconds (the least of the runs, each peer's start-up left out) and the peak of the
process's memory (start-up included) in MB. Kiln's first column opens assets (`kiln_formats::open`): all files and the geometry,
with the images of glTF files encoded still and no tangents made, as Blender's import leaves them; the second is a whole import.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
from urllib.parse import unquote

BLENDER = """
import sys, time, resource, bpy
path = sys.argv[1]
bpy.ops.wm.read_factory_settings(use_empty=True)
cpu = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
wall, before = time.perf_counter(), cpu()
if path.lower().endswith('.obj'):
    bpy.ops.wm.obj_import(filepath=path)
else:
    bpy.ops.import_scene.gltf(filepath=path)
wall, used = time.perf_counter() - wall, cpu() - before
print('RESULT', wall, used, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3)
"""

MITSUBA = """
import sys, time, resource
import mitsuba as mi
mi.set_variant('scalar_rgb')
cpu = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
wall, before = time.perf_counter(), cpu()
mi.load_dict({'type': 'obj', 'filename': sys.argv[1]})
wall, used = time.perf_counter() - wall, cpu() - before
print('RESULT', wall, used, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3)
"""


def size(path):
    """Bytes of an asset with all that it refers to."""
    total = os.path.getsize(path)
    if path.endswith(".gltf"):
        with open(path, encoding="utf-8-sig") as file:
            document = json.load(file)
        for item in document.get("buffers", []) + document.get("images", []):
            other = os.path.join(os.path.dirname(path), unquote(item.get("uri", "")))
            total += os.path.getsize(other) if os.path.isfile(other) else 0
    return total


def peer(program, path):
    out = subprocess.run([sys.executable, "-c", program, path], capture_output=True, text=True)
    line = next((l for l in out.stdout.splitlines() if l.startswith("RESULT")), None)
    return tuple(map(float, line.split()[1:])) if line else None


def kiln(binary, path, *flags):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = subprocess.run([binary, *flags, path], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = out.stdout.split()
    if len(words) < 4:
        return None
    cpu = (after.ru_utime + after.ru_stime) - (before.ru_utime + before.ru_stime)
    return float(words[0]), cpu, float(words[2])


def best(run, runs):
    results = [r for r in (run() for _ in range(runs)) if r]
    return tuple(min(r[i] for r in results) for i in range(3)) if results else None


def cell(result):
    return "–" if result is None else f"{result[0]:.2f} / {result[1]:.2f} / {result[2]:.0f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args()
    assets = []
    for folder in options.folders:
        if os.path.isfile(folder):
            assets.append((size(folder), folder))
        for base, _, files in os.walk(folder):
            paths = (os.path.join(base, f) for f in files if f.lower().endswith((".gltf", ".glb", ".obj")))
            assets += [(size(path), path) for path in paths]
    assets.sort(reverse=True)
    print("| asset | MB | Kiln, opened: wall s / CPU s / MB | Kiln, whole import | Blender | Mitsuba |\n|---|---|---|---|---|---|")
    for total, path in assets[: options.count]:
        packed = best(lambda: kiln(options.binary, path, "--packed"), options.runs)
        ours = best(lambda: kiln(options.binary, path), options.runs)
        blender = best(lambda: peer(BLENDER, path), options.runs)
        mitsuba = best(lambda: peer(MITSUBA, path), options.runs) if path.endswith(".obj") else None
        name = os.path.basename(path)
        print(f"| {name} | {total / 1e6:.1f} | {cell(packed)} | {cell(ours)} | {cell(blender)} | {cell(mitsuba)} |", flush=True)


if __name__ == "__main__":
    main()
