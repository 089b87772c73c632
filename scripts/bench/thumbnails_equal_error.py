#!/usr/bin/env python3
"""Thumbnails at equal error: how many samples, and CPU seconds, Kiln takes for the noise of Mitsuba's 64 samples.

    scripts/bench/thumbnails_equal_error.py KILN SHARED PYTHON [--assets NAME,…] [--runs 3] [--json FILE]

SHARED is the folder with `assets/` and `peers/`, PYTHON one that has Mitsuba 3; this script itself needs numpy and OpenEXR. Mitsuba is run by
`peers/thumbs.py` as it stands, but for seeds and for keeping what it renders in linear light; Kiln with the same camera, environment and
number of scatterings.

Noise is half the squared difference of two pictures with different seeds, over the pixels that the object covers wholly: plain, and relative
to the square of the mean of all pictures of that renderer (+ 0.01, as `peers/metrics.py` has it), the 0.1 % of worst pixels left out or not. Each
renderer is compared with itself alone, since Mitsuba's side leaves materials out. Seconds are CPU seconds from reading the asset to the
picture on disk; Kiln's are those of its process as a whole, Mitsuba's without its start and, by a run before, with its kernels in the cache.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy

from convergence_renderers import timed
import OpenEXR

ASSETS = [
    "khronos/DamagedHelmet.glb", "bevy/FlightHelmet/FlightHelmet.gltf", "khronos/CesiumMilkTruck.glb",
    "khronos/MetalRoughSpheresNoTextures.glb", "khronos/TransmissionTest.glb", "khronos/ClearCoatTest.glb",
    "khronos/GlassVaseFlowers.glb", "khronos/IridescenceSuzanne.glb", "playcanvas/terrain.glb", "khronos/AlphaBlendModeTest.glb",
]
SAMPLES = [64, 8, 16, 32]

# How far beyond the measured samples is still told, as a logarithm: twice as many.
FURTHEST = numpy.log(2)

# Runs the peer's script with another seed, and keeps its pictures as numbers.
PEER = """
import os, runpy, sys
import numpy, mitsuba as mi
mi.set_variant("llvm_ad_rgb")
script, seed = sys.argv[1], int(sys.argv[2])
render = mi.render
mi.render = lambda scene, **options: render(scene, seed=seed, **options)
mi.util.write_bitmap = lambda path, image, **_: numpy.save(path[: -len(".png")], numpy.array(image))
sys.argv = [script, *sys.argv[3:]]
runpy.run_path(script, run_name="__main__")
"""

# Says where the peer's script has its camera.
CAMERA = """
import json, sys
sys.path.insert(0, sys.argv[1])
import numpy as np, scene_io
for file in sys.argv[2:]:
    meshes = scene_io.load_glb(file) if file.endswith(".glb") else scene_io.load_gltf(file)
    points = np.concatenate([mesh["P"] for mesh in meshes])
    low, high = points.min(0), points.max(0)
    back = np.array([.5, .45, 1.]); back /= np.linalg.norm(back)
    eye = (low + high) / 2 + back * np.linalg.norm(high - low) / 2 / np.sin(np.radians(19))
    right = np.cross([0, 1, 0], back); right /= np.linalg.norm(right)
    up = np.cross(back, right)
    rows = np.stack([right, up, back, eye], axis=1).tolist() + [[0, 0, 0, 1]]
    print(json.dumps(rows))
"""


def name(asset):
    return Path(asset).stem


def views(args, folder):
    """View files with the peer's cameras."""
    files = [str(args.shared / "assets/gltf" / asset) for asset in args.assets]
    done = subprocess.run([args.python, "-c", CAMERA, str(args.shared / "peers"), *files], check=True, capture_output=True, text=True)
    found = {}
    for asset, line in zip(args.assets, done.stdout.splitlines()):
        light = {"type": "hdr", "file": str(args.shared / "scenes/bench/studio.hdr"), "rotation_y_deg": 0, "intensity": 1.0}
        view = {"width": 256, "height": 256, "camera_to_world": json.loads(line), "vfov_deg": 38.0, "max_scatter": 8, "environment": light}
        found[asset] = folder / f"{name(asset)}.json"
        found[asset].write_text(json.dumps(view))
    return found


def mitsuba(args, folder, seed):
    """Pictures of all assets, and CPU seconds of each."""
    files = [str(args.shared / "assets/gltf" / asset) for asset in args.assets]
    command = [args.python, "-c", PEER, str(args.shared / "peers/thumbs.py"), str(seed), "mitsuba", str(folder), *files, "--spp", "64"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    rows = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    cpu = [row["cpu"] for row in rows if row["asset"] != "TOTAL"]
    whole = next(row["cpu"] for row in rows if row["asset"] == "TOTAL")
    pictures = [numpy.load(folder / f"{name(asset)}.mitsuba.npy")[..., :3].astype(float) for asset in args.assets]
    return pictures, cpu, whole


def kiln(args, asset, view, spp, seed, folder):
    """Colour and coverage, and CPU seconds of the process."""
    path = folder / "picture.exr"
    command = [args.kiln, "render", str(args.shared / "assets/gltf" / asset), "--view", str(view), "--root", "/", "-q", "-o", str(path)]
    command += ["--background", "transparent", "--spp", str(spp), "--seed", str(seed)]
    _, cpu, _ = timed(command, stderr=subprocess.DEVNULL)
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    r, g, b, a = (channels[c].pixels.astype(float) for c in "RGBA")
    return numpy.stack([r, g, b], -1), a, cpu


def noise(pictures, expected, inside):
    """Mean squared errors of a picture: plain, relative, and relative without the worst thousandth of the pixels."""
    differences = [(a - b)[inside] ** 2 / 2 for a, b in zip(pictures[::2], pictures[1::2])]
    plain = numpy.mean(differences)
    relative = numpy.mean(differences, 0) / (expected[inside] ** 2 + 0.01)
    sorted_ = numpy.sort(relative.mean(-1))
    return [plain, relative.mean(), sorted_[: len(sorted_) - max(1, len(sorted_) // 1000)].mean()]


def needed(curve, goal, value):
    """At which samples (or seconds) the noise has come down to `goal`: between measured points, and before and beyond them by the nearest
    slope; `None` where noise does not fall (a few fireflies decide) or not nearly far enough."""
    points = [(numpy.log(value(n, point)), numpy.log(point["noise"])) for n, point in sorted(curve.items())]
    pairs = list(zip(points, points[1:]))
    before, after = next((pair for pair in pairs if pair[1][1] <= numpy.log(goal)), pairs[-1])
    slope = (after[0] - before[0]) / (after[1] - before[1])
    if not slope < 0:
        return None
    found = before[0] + (numpy.log(goal) - before[1]) * slope
    return float(numpy.exp(found)) if found < points[-1][0] + FURTHEST else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kiln")
    parser.add_argument("shared", type=Path)
    parser.add_argument("python")
    parser.add_argument("--assets", type=lambda names: [a for a in ASSETS if name(a) in names.split(",")], default=ASSETS)
    parser.add_argument("--runs", type=int, default=3, help="pairs of seeds; of seconds, the least counts")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    args.shared = args.shared.resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        view_of = views(args, folder)
        mitsuba(args, folder, 0)
        peer = [mitsuba(args, folder, 1 + seed) for seed in range(2 * args.runs)]
        rows = []
        for k, asset in enumerate(args.assets):
            theirs = [pictures[k] for pictures, _, _ in peer]
            curves, own_mean = [{}, {}, {}], None
            for spp in SAMPLES:
                runs = [kiln(args, asset, view_of[asset], spp, 2 + seed, folder) for seed in range(2 * args.runs)]
                if own_mean is None:
                    own_mean = numpy.mean([run[0] for run in runs], 0)
                    inside = numpy.mean([run[1] for run in runs], 0) >= 0.9999
                    goal = noise(theirs, numpy.mean(theirs, 0), inside)
                found = noise([run[0] for run in runs], own_mean, inside)
                for curve, value in zip(curves, found):
                    curve[spp] = {"noise": value, "cpu": min(run[2] for run in runs)}
            row = {"asset": name(asset), "pixels": int(inside.sum()), "mitsuba": {"noise": goal, "cpu": min(cpu[k] for _, cpu, _ in peer)}, "kiln": curves}
            for way, curve, value in zip(["plain", "relative", "trimmed"], curves, goal):
                row[way] = {"samples": needed(curve, value, lambda n, _: n), "cpu": needed(curve, value, lambda _, point: point["cpu"])}
            rows.append(row)
            print(json.dumps({key: row[key] for key in ("asset", "plain", "relative", "trimmed")}), file=sys.stderr, flush=True)
    if args.json:
        args.json.write_text(json.dumps({"rows": rows, "mitsuba_whole": [whole for _, _, whole in peer]}, indent=1))
    table(rows, [whole for _, _, whole in peer])


def figures(found):
    return "–" if found["samples"] is None or found["cpu"] is None else f"{found['samples']:.0f}, {found['cpu']:.2f}"


def table(rows, whole):
    print("| asset | Mitsuba, 64: CPU s, relMSE | Kiln, 64: CPU s, relMSE | equal relMSE: samples, CPU s | trimmed | MSE |")
    print("|---|---|---|---|---|---|")
    for row in rows:
        at64, peer = row["kiln"][1][64], row["mitsuba"]
        ways = " | ".join(figures(row[way]) for way in ("relative", "trimmed", "plain"))
        print(f"| {row['asset']} | {peer['cpu']:.2f}, {peer['noise'][1]:.5f} | {at64['cpu']:.2f}, {at64['noise']:.5f} | {ways} |")
    mean = lambda values: sum(values) / len(rows)
    ways = [[row[way]["cpu"] for row in rows] for way in ("relative", "trimmed", "plain")]
    ways = " | ".join("–" if None in way else f"{mean(way):.2f}" for way in ways)
    theirs, ours = mean(row["mitsuba"]["cpu"] for row in rows), mean(row["kiln"][1][64]["cpu"] for row in rows)
    print(f"| **mean** | {theirs:.2f} ({min(whole) / len(rows):.2f} with its start) | {ours:.2f} | {ways} |")


if __name__ == "__main__":
    main()
