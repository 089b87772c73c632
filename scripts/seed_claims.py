#!/usr/bin/env python3
"""Measures the claims of the student tracer of 2018 again and writes docs/seed-claims.md with its pictures.

    cargo build --release --bin kiln --example seed_claims
    scripts/seed_claims.py [--kiln target/release/kiln] [--out docs] [--work FOLDER] [--budget SECONDS]

Needs Pillow and a C compiler. Times are CPU seconds, so that other work on the machine matters little.
"""
import argparse
import datetime
import json
import subprocess
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw

SAMPLES = [1, 5, 10, 50]
LIGHTS = [1, 5, 10, 20]
SIDE = 112
TREES = ["chess.obj", "reading_corner.obj", "balloons.glb"]
DEPTHS = ["depth-1", "depth-2", "depth-4", "depth-8"]
ROULETTE = {"no-roulette": "never", "kiln": "from the third scattering on", "roulette-1": "from the first one on"}
ROOMS = ["cornell_box.glb", "reading_corner.obj", "tinted_glass.glb"]
SAMPLERS = ["kiln", "pcg", "lcg", "xorshift32"]


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        raise SystemExit(f"{' '.join(map(str, command))}: {done.stderr}")
    return done.stdout


class Bench:
    def __init__(self, options):
        self.kiln, self.budget = options.kiln, options.budget
        self.here = Path(__file__).resolve().parent.parent
        self.scenes = self.here / "scenes" / "samples"
        self.work = Path(options.work or tempfile.mkdtemp())
        self.pictures = Path(options.out) / "seed-claims"
        self.pictures.mkdir(parents=True, exist_ok=True)

    def study(self, name, assets, ways, *more):
        out = self.work / name
        run(self.kiln, "study", *[self.scenes / a for a in assets], "--out", out, "--ways", ways, "--budget", self.budget,
            "--quiet", *more)
        return json.loads((out / "study.json").read_text()), out

    def render(self, asset, *flags):
        return json.loads(run(self.kiln, "render", self.scenes / asset, "--json", "--quiet", *flags))


def curve(asset, way):
    return next(c for c in asset["analysis"]["curves"] if c["way"] == way)


def common(asset, ways):
    """The most samples that all ways were rendered with, and each way's point there."""
    points = {w: {p["spp"]: p for p in curve(asset, w)["points"]} for w in ways}
    spp = max(set.intersection(*[set(p) for p in points.values()]))
    return spp, {w: points[w][spp] for w in ways}


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, r)) + " |" for r in rows]) + "\n"


def times(factor):
    return f"{factor:.2f}×"


def random_numbers(bench, numbers):
    """Share of the time that random numbers take."""
    binary = bench.work / "system_random"
    run("cc", "-O2", "-o", binary, bench.here / "scripts" / "bench" / "system_random.c")
    each = {"the C library's rand()": float(run(binary)), **numbers}
    study, _ = bench.study("samplers", ["soft_shadows.ray"], ",".join(SAMPLERS))
    spp, points = common(study["assets"][0], SAMPLERS)
    line = bench.render("soft_shadows.ray", "--width", 128, "--spp", 16, "-o", bench.work / "numbers.png")
    paths = line["rays"]["camera"]
    drawn = (2 * paths + 6 * (paths + line["rays"]["bounce"])) / paths
    lcg = points["lcg"]["cpu_seconds"]["render"] / (128 * 128 * spp)
    rest = lcg - drawn * each["lcg"] * 1e-9
    rows = []
    for name, nanoseconds in each.items():
        way = {"sobol": "kiln"}.get(name, name)
        spent = drawn * nanoseconds * 1e-9
        measured = f"{points[way]['cpu_seconds']['render']:.3f} s, {points[way]['error']:.2f} levels" if way in points else "–"
        rows.append([name, f"{nanoseconds:.2f} ns", f"{100 * spent / (rest + spent):.1f} %", measured])
    return f"""## Random numbers

The tracer of 2018 drew its numbers from an xorshift32 of its own instead of the system's generator. What a number of each
generator takes, drawn one by one as a path draws them; the share of a render of `soft_shadows.ray` that this would be, with about
{drawn:.0f} numbers a path; and the render itself with that generator ({spp} samples per pixel, 128 × 128):

{table(["generator", "CPU time a number", "share of the render", "render: CPU seconds, error"], rows)}
What a generator costs matters less than how well its points are spread: compare the errors in the last column. (`sobol` is
Kiln's own; `sobol` and `pcg` are addressed by pixel, sample and purpose, the others run in sequence.)
"""


def soft_shadows(bench):
    """The matrix of 2018: samples × light samples."""
    reference = bench.work / "matrix-reference.exr"
    bench.render("soft_shadows.ray", "--width", SIDE, "--spp", 256, "--seed", 99, "-o", reference)
    label = 18
    sheet = Image.new("RGB", (4 * (SIDE + 6) + 6, 4 * (SIDE + label + 6) + 6), "white")
    draw = ImageDraw.Draw(sheet)
    rows = []
    for r, samples in enumerate(SAMPLES):
        cells = [f"**{samples}**"]
        for c, lights in enumerate(LIGHTS):
            path = bench.work / f"matrix-{samples}-{lights}.png"
            line = bench.render("soft_shadows.ray", "--width", SIDE, "--spp", samples, "--light-samples", lights, "-o", path)
            seconds = line["cpu_seconds"]["total"]
            error = json.loads(run(bench.kiln, "compare", path, reference, "--json"))["rmse"]
            cells.append(f"{error:.1f} in {seconds:.2f} s")
            at = (6 + c * (SIDE + 6), 6 + r * (SIDE + label + 6))
            picture = Image.open(path).convert("RGBA")
            sheet.paste(picture, at, picture)
            draw.text((at[0] + 2, at[1] + SIDE + 2), f"{samples} x {lights}: {error:.1f}, {seconds:.2f} s", fill="black")
        rows.append(cells)
    head = ["samples, light samples", *map(str, LIGHTS)]
    sheet.save(bench.pictures / "matrix.png", optimize=True)
    return f"""## Soft shadows

The seed's matrix: samples per pixel (rows) by light samples at each hit (columns), `soft_shadows.ray`. Below each picture its
error against 256 samples (levels as displayed) and its CPU seconds.

![Sixteen pictures: more samples downwards, more light samples to the right](seed-claims/matrix.png)

{table(head, rows)}
At the same time more samples per pixel do better than more light samples:
light samples smooth the shadows only, a sample also smooths edges, reflections and light that bounced.
"""


def depth(bench):
    """What deep paths cost, and what ending them by what they carry saves."""
    study, _ = bench.study("roulette", ROOMS, ",".join(ROULETTE))
    saved = []
    for asset in study["assets"]:
        spp, points = common(asset, list(ROULETTE))
        none = points["no-roulette"]
        for way, word in ROULETTE.items():
            p, bias = points[way], curve(asset, way)["bias"]
            time = p["cpu_seconds"]["render"] / none["cpu_seconds"]["render"]
            told = f"{100 * bias['relative']:+.1f} ± {100 * bias['half_width']:.1f} %" if bias else "–"
            saved.append([f"`{asset['asset']}`, {spp} samples", word, times(time), told, f"{p['error']:.2f}",
                          times(time * (p["error"] / none["error"]) ** 2)])
    study, _ = bench.study("depth", ["cornell_box.glb"], ",".join(["kiln", *DEPTHS]))
    asset = study["assets"][0]
    spp, points = common(asset, ["kiln", *DEPTHS])
    full = points["kiln"]["cpu_seconds"]["render"]
    rows = []
    for way in [*DEPTHS, "kiln"]:
        c, p = curve(asset, way), points[way]
        bias = c["bias"]
        told = f"{100 * bias['relative']:+.1f} ± {100 * bias['half_width']:.1f} %" if bias else "–"
        rows.append([way.replace("kiln", "16, Russian roulette from 3"), times(p["cpu_seconds"]["render"] / full), told,
                     f"{p['error']:.1f}"])
    return f"""## Fewer samples where the contribution is lower

The tracer of 2018 shot N/k rays at depth k and still divided by N: a bias. What is left of the idea once it is unbiased is
Russian roulette (`--roulette`): a path that carries less than a quarter of what it began with goes on with a probability of four times
what it still carries, and weighs more for it. (The carried share itself as the probability ends paths that would have found a lamp through
glass, and makes the rest specks.) Kiln does so from the third scattering on. The last column is the time for the same error, taking errors to fall with the root of the
time:

{table(["asset", "Russian roulette", "time", "brightness", "error, levels", "time for the same error"], saved)}
What cutting all paths short saves instead, and what it does to the brightness of `cornell_box.glb` ({spp} samples per pixel):

{table(["scattering events at most", "time", "brightness", "error, levels"], rows)}
"""


def trees(bench):
    """The kd-tree's builders."""
    study, _ = bench.study("trees", TREES, "kiln,median,sampled")
    rows = []
    for asset in study["assets"]:
        spp, points = common(asset, ["kiln", "median", "sampled"])
        own = points["kiln"]["cpu_seconds"]
        for way, word in [("kiln", "surface area heuristic"), ("median", "medians"), ("sampled", "random samples (2018)")]:
            s = points[way]["cpu_seconds"]
            rows.append([f"`{asset['asset']}`, {asset['scene']['triangles']} triangles", word, f"{1e3 * s['kdtree']:.1f} ms",
                         f"{s['render']:.3f} s", times(s["render"] / own["render"])])
    return f"""## kd-trees

The semi-randomised builder of 2018 (split planes from a random sample of the triangles), medians, and the surface area
heuristic that Kiln uses. CPU time of the build, and of the same render:

{table(["asset", "builder", "build", "render", "render against SAH"], rows)}
"""


def threads(bench, schedules):
    """Thread scaling and schedules."""
    rows = []
    for count in (1, 2):
        line = bench.render("chess.obj", "--width", 192, "--spp", 16, "--threads", count, "-o", bench.work / "threads.png")
        rows.append([count, f"{line['cpu_seconds']['render']:.2f} s", f"{line['seconds']['render']:.2f} s"])
    plans = []
    for s in schedules:
        for e in s["efficiencies"]:
            plans.append([f"`{s['asset']}`", e["threads"], f"{100 * e['static']:.0f} %", f"{100 * e['dynamic']:.0f} %"])
    return f"""## Threads

`chess.obj`, 192 × 192, 16 samples: the CPU seconds should not grow with the threads (what they grow by is lost), and the wall
seconds should shrink by as many.

{table(["threads", "CPU", "wall"], rows)}
Static scheduling (each thread as many neighbouring rows) against dynamic (each thread takes the next rows when it is
done, as OpenMP did in 2018 and Kiln does with tiles): the CPU time of {32} bands of rows was measured, and the share of the
threads' time that is used follows from it. (With 16 threads two bands each are too few for any schedule; Kiln's tiles are
smaller.)

{table(["asset", "threads", "static", "dynamic"], plans)}
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kiln", default="target/release/kiln")
    parser.add_argument("--out", default="docs")
    parser.add_argument("--work", help="keeps what is rendered on the way; a second run goes on from there")
    parser.add_argument("--budget", default="20", help="seconds for each asset of each study")
    options = parser.parse_args()
    bench = Bench(options)
    bench.work.mkdir(parents=True, exist_ok=True)
    example = Path(options.kiln).parent / "examples" / "seed_claims"
    assets = [bench.scenes / a for a in ("soft_shadows.ray", "chess.obj", "cornell_box.glb")]
    measured = json.loads(run(example, *assets))
    chapters = [
        random_numbers(bench, measured["nanoseconds_per_number"]),
        soft_shadows(bench),
        depth(bench),
        trees(bench),
        threads(bench, measured["schedules"]),
    ]
    today = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
    version = run(options.kiln, "--version").strip()
    model = next((l.split(":", 1)[1].strip() for l in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in l), "?")
    head = f"""# The claims of 2018, measured again

Kiln grew out of a student path tracer of 2018 that made a few claims about what makes rendering fast. Here they are
measured again, with Kiln, whose ways of 2018 are unbiased. Made by `scripts/seed_claims.py`, mostly from `kiln study`, on
{today} with {version} on {model}; all figures are CPU seconds unless they say otherwise.
Errors are RMS as displayed, levels 0–255.

"""
    (Path(options.out) / "seed-claims.md").write_text(head + "\n".join(chapters))


if __name__ == "__main__":
    main()
