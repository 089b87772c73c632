#!/usr/bin/env python3
"""CPU seconds to a given error on the bench scenes: Kiln, and peers in turn with it where they are installed.

    just bench convergence --scenes cornell,many_lights --spp 4,16,64
    just bench convergence --kiln "target/release/kiln" --kiln "other/kiln --light-samples 2" --mitsuba VENV/bin/python

Scenes, references and the peers' scripts lie in the folder that KILN_SHARED names. Needs numpy and OpenEXR (pip).
relMSE is the mean over pixels and channels of (x − ref)² / (ref² + 0.01), less the reference's own noise. Where material
models differ from renderer to renderer, each has its own: Kiln's is rendered on demand and kept in ~/.cache/kiln-bench.
CPU seconds are those of light transport alone; what a whole process takes from start to PNG is a table of its own.
"""

import argparse
import os
import statistics
import sys
from math import ceil
from pathlib import Path

from convergence_references import Reference, reference
from convergence_renderers import Cycles, Kiln, Mitsuba, Scene

SCENES = "cornell soft_shadow studio_lambert studio_knot studio_helmet cornell_glossy many_lights large_mesh".split()
TARGETS = (0.01, 0.001)


def seconds_to(target, points):
    """CPU seconds until the error falls to the target, on straight lines between the logarithms of (seconds, error),
    and whether that lies outside of what was measured. None where the error does not fall."""
    from math import exp, log

    points = [(log(s), log(e)) for s, e in points if e > 0]
    if len(points) < 2:
        return None
    goal = log(target)
    spans = list(zip(points, points[1:]))
    inside = [(a, b) for a, b in spans if a[1] >= goal >= b[1]]
    a, b = inside[0] if inside else (spans[0] if goal > points[0][1] else spans[-1])
    if a[1] <= b[1]:
        return None
    return exp(a[0] + (a[1] - goal) / (a[1] - b[1]) * (b[0] - a[0])), not inside


def shown(result):
    if result is None:
        return "–"
    seconds, outside = result
    return f"{seconds:.3f}{' (extrapolated)' if outside else ''}"


def measure(scene, contenders, args):
    """Renders the scene at each spp by each contender in turn; gives contender → [(CPU seconds, error, spp)]."""
    peers = {c.name: None if isinstance(c, Kiln) else c.name for c in contenders}
    refs: dict[str, Reference] = {c: reference(scene, contenders[0], args.reference_spp, peer) for c, peer in peers.items()}
    named = dict.fromkeys(f"{ref.source}, its noise {ref.noise:.1e}" for ref in refs.values())
    print(f"\n## {scene.name}\n\nReference: {'; '.join(named)}.\n")
    print("| renderer | spp | CPU s | wall s | M paths a CPU-s | relMSE | without the worst 0.1 % |\n|---|---|---|---|---|---|---|")
    points = {c.name: [] for c in contenders}
    for spp in args.spp:
        seeds = args.seeds if spp <= 64 else 1
        rows = {c.name: [] for c in contenders}
        for contender in contenders:
            before = points[contender.name]
            # Four times the samples cost four times as much.
            if before and before[-1][0] * 4 > args.limit:
                continue
            for shot in contender.shoot(scene, spp, seeds):
                rows[contender.name].append((shot, *refs[contender.name].errors(shot.pixels)))
        for name, found in rows.items():
            if not found:
                continue
            cpu = statistics.median(shot.cpu for shot, *_ in found)
            wall = statistics.median(shot.wall for shot, *_ in found)
            error, trimmed = (statistics.mean(f[k] for f in found) for k in (1, 2))
            paths = scene.width * scene.height * spp / cpu / 1e6
            print(f"| {name} | {spp} | {cpu:.3f} | {wall:.3f} | {paths:.2f} | {error:.5f} | {trimmed:.5f} |", flush=True)
            points[name].append((cpu, error, spp))
    return points


def samples_for(target, points):
    """Samples a pixel, a whole number, with which the error falls to the target; 1 at least. None where that is not known."""
    found = seconds_to(target, [(spp, error) for _, error, spp in points])
    return max(1, ceil(found[0] - 1e-6)) if found else None


def whole_processes(scenes, contenders, all_points):
    """From process start to the picture on disk: with 16 samples, and with as many as the first target takes each."""
    print(f"\n## Whole processes: start to picture on disk, with 16 samples and to {TARGETS[0]}\n")
    print("| scene | renderer | wall s, 16 spp | CPU s | samples to the error | wall s | CPU s |\n|---|---|---|---|---|---|---|")
    for scene in scenes:
        for contender in contenders:
            needed = samples_for(TARGETS[0], all_points[scene.name][contender.name])
            row = [scene.name, contender.name]
            for spp in (16, needed):
                runs = [contender.whole(scene, spp) for _ in range(3)] if spp else []
                row += [] if spp == 16 and len(row) == 2 else [str(spp or "–")]
                row += [f"{statistics.median(r[k] for r in runs):.3f}" if runs else "–" for k in (0, 1)]
            print(f"| {' | '.join(row)} |", flush=True)


def scaling(scenes, kiln):
    """What size and threads cost."""
    print("\n## Size and threads, 4 spp (wall seconds say little on a busy machine)\n")
    print("| scene | CPU of a pixel at 1024² over 256² | CPU of two threads over one | wall of one over two |\n|---|---|---|---|")
    for scene in scenes:
        small, large, one = ([], [], [])
        for seed in range(3):
            small.append(kiln.render(scene, 4, seed, ["--threads", "2"]))
            large.append(kiln.render(scene, 4, seed, ["--threads", "2", "--width", "1024", "--height", "1024"]))
            one.append(kiln.render(scene, 4, seed, ["--threads", "1"]))
        cpu, wall = (lambda shots: statistics.median(s.cpu for s in shots)), (lambda shots: min(s.wall for s in shots))
        pixel = cpu(large) / cpu(small) / (1024 * 1024 / scene.width / scene.height)
        print(f"| {scene.name} | {pixel:.3f} | {cpu(small) / cpu(one):.3f} | {wall(one) / wall(small):.2f} |", flush=True)


def summary(all_points, contenders):
    print("\n## CPU seconds to an error, and Kiln's share of the best peer's\n")
    print("| scene | renderer | " + " | ".join(f"to {t}" for t in TARGETS) + " | " + " | ".join(f"ratio at {t}" for t in TARGETS) + " |")
    print("|---" * (2 + 2 * len(TARGETS)) + "|")
    peers = [c.name for c in contenders if not isinstance(c, Kiln)] or [contenders[0].name]
    for scene, points in all_points.items():
        times = {name: [seconds_to(t, [p[:2] for p in points[name]]) for t in TARGETS] for name in points}
        best = [min((times[p][k][0] for p in peers if times[p][k]), default=None) for k in range(len(TARGETS))]
        for name, found in times.items():
            ratios = [f"{f[0] / b:.3f}" if f and b else "–" for f, b in zip(found, best)]
            print(f"| {scene} | {name} | " + " | ".join(map(shown, found)) + " | " + " | ".join(ratios) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    numbers = lambda text: [int(x) for x in text.split(",")]
    parser.add_argument("--scenes", type=lambda text: text.split(","), default=SCENES)
    parser.add_argument("--spp", type=numbers, default=[4, 16, 64, 256, 1024])
    parser.add_argument("--seeds", type=int, default=3, help="renders at up to 64 spp; one beyond")
    parser.add_argument("--limit", type=float, default=120, help="leave out renders of about more CPU seconds than this")
    parser.add_argument("--kiln", action="append", help="a kiln binary and options for it; several run in turn")
    parser.add_argument("--mitsuba", metavar="PYTHON", help="a Python with Mitsuba 3, to run it in turn")
    parser.add_argument("--cycles", metavar="PYTHON", help="a Python with bpy, to run Blender Cycles in turn")
    parser.add_argument("--reference-spp", type=int, default=16384, help="for scenes with a reference of our own")
    parser.add_argument("--no-whole", action="store_true", help="leave out whole processes, size and threads")
    args = parser.parse_args()
    if "KILN_SHARED" not in os.environ:
        sys.exit("KILN_SHARED is not set: it names the folder of bench scenes and references")
    shared = Path(os.environ["KILN_SHARED"])
    scenes = [Scene(shared, name) for name in args.scenes]
    commands = args.kiln or ["target/release/kiln"]
    contenders = [Kiln("kiln" if len(commands) == 1 else command, command, shared) for command in commands]
    if args.mitsuba:
        contenders.append(Mitsuba(args.mitsuba, shared))
    if args.cycles:
        contenders.append(Cycles(args.cycles, shared))
    points = {scene.name: measure(scene, contenders, args) for scene in scenes}
    summary(points, contenders)
    if not args.no_whole:
        whole_processes(scenes, contenders, points)
        scaling(scenes, contenders[0])


if __name__ == "__main__":
    main()
