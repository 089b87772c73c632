#!/usr/bin/env python3
"""The pictures of docs/hard-cases.md: `python3 scripts/hard_cases.py WORK`, where mutate_checks.py WORK build has been run.

Each scene is rendered as it is (left) and with remedies taken away (right). Needs Pillow.
"""
import json
import os
import random
import subprocess
import sys
from math import cos, pi, radians, sin
from pathlib import Path

from checks.outside import looking
from checks.writers import box, glass, icosphere, lambert, material, png, quad, write_gltf
from mutations import MUTATIONS
from PIL import Image

OUT = Path(__file__).resolve().parent.parent / "docs" / "hard-cases"
SIZE = (200, 150)
WORLD = (0.35, 0.4, 0.5)
UVS = [((0, 1), (1, 1), (1, 0)), ((0, 1), (1, 0), (0, 0))]


def floor(y=0.0, half=4.0):
    return quad((-half, y, half), (half, y, half), (half, y, -half), (-half, y, -half))


def lamp(x=-2.0, y=4.0, z=2.0, half=0.7, power=24.0):
    """Faces down."""
    return {"triangles": quad((x - half, y, z - half), (x + half, y, z - half), (x + half, y, z + half), (x - half, y, z + half)),
            "material": lambert(0.0, emission=power, double_sided=False)}


def ball(x, y, z, radius, stuff, levels=2, smooth=False):
    triangles = icosphere(levels, (x, y, z), radius)
    part = {"triangles": triangles, "material": stuff}
    if smooth:
        part["normals"] = [[tuple((a - b) / radius for a, b in zip(p, (x, y, z))) for p in t] for t in triangles]
    return part


def clay(r, g, b):
    return material((r, g, b), roughness=1.0, specular={"specularFactor": 0})


GROUND = {"triangles": floor(), "material": clay(0.6, 0.58, 0.55)}
VIEW = {"eye": (0.3, 2.0, 6.0), "target": (0, 0.7, 0), "vfov": 34}


def balls(levels=2, smooth=False):
    return [ball(-1.3, 0.8, 0, 0.8, clay(0.75, 0.3, 0.25), levels, smooth), ball(0.5, 0.6, 0.6, 0.6, clay(0.3, 0.6, 0.35), levels, smooth),
            ball(1.7, 0.9, -0.4, 0.9, clay(0.3, 0.4, 0.75), levels, smooth)]


def moved(parts, offset):
    matrix = [[1, 0, 0, offset[0]], [0, 1, 0, offset[1]], [0, 0, 1, offset[2]], [0, 0, 0, 1]]
    return [{**part, "matrix": matrix} for part in parts]


def shifted(view, offset):
    return {**view, **{k: tuple(a + b for a, b in zip(view[k], offset)) for k in ("eye", "target")}}


def bumpy():
    """A normal map whose texels lean by up to 70° wherever they like."""
    rng, rows = random.Random(4), []
    for _ in range(24):
        row = []
        for _ in range(24):
            lean, turn = radians(70 * rng.random()), 2 * pi * rng.random()
            n = (sin(lean) * cos(turn), sin(lean) * sin(turn), cos(lean))
            row.append(tuple(round((x + 1) / 2 * 255) for x in n))
        rows.append(row)
    return png(24, 24, rows)


def cases():
    far, stray = (3e5, 0.0, -3e5), (2e6, 0.0, 2e6)
    yield "offset", [GROUND, lamp(), *balls()], {}, VIEW, 48, ["no-offset"]
    pea = [GROUND, lamp(), ball(0, 0.002, 0, 0.002, clay(0.75, 0.3, 0.25), 3),
           {"triangles": box((0.0035, 0, -0.002), (0.0055, 0.005, 0.001)), "material": clay(0.3, 0.4, 0.75)}]
    yield "epsilon", pea, {}, {"eye": (0.003, 0.009, 0.022), "target": (0.0015, 0.0015, 0), "vfov": 32}, 64, ["fixed-epsilon"]
    yield "far", moved([GROUND, lamp(), *balls(3, True)], far), {}, shifted(VIEW, far), 64, ["world-at-origin"]
    speck = {"triangles": [((0, 0, 0), (1, 0, 0), (0, 1, 0))], "material": clay(1, 1, 1)}
    yield "stray", [*moved([GROUND, lamp(), *balls(3, True)], stray), speck], {}, shifted(VIEW, stray), 64, ["world-with-strays"]
    sun = quad((-6, 1.4, 1.2), (-6, 1.4, 1.8), (-6, 2.0, 1.8), (-6, 2.0, 1.2))
    yield ("terminator", [GROUND, {"triangles": sun, "material": lambert(0.0, emission=400.0)}, *balls(1, True)], {"world": 0.02}, VIEW, 96, ["no-lift"])
    rough = {"triangles": [tuple(t) for t in floor()], "uvs": UVS, "normals": [[(0, 1, 0)] * 3] * 2,
             "material": material((0.9, 0.75, 0.45), metallic=1, roughness=0.35, normalTexture={"index": 0})}
    yield ("bent-normals", [rough, lamp(), *balls(3, True)], {"images": [bumpy()]},
           {"eye": (0.3, 0.9, 7.0), "target": (0, 0.6, 0), "vfov": 30}, 96, ["unbent-normal"])
    tints = ([0.9, 0.5, 0.35], [0.4, 0.8, 0.55], [0.45, 0.6, 0.95])
    blocks = [{"triangles": box((-1.2, 0.01 + 0.55 * k, -0.8), (1.2, 0.01 + 0.55 * (k + 1), 0.8)), "material": glass(1.5 - 0.1 * k, attenuation=t)}
              for k, t in enumerate(tints)]
    yield "touching", [GROUND, lamp(), *blocks], {}, VIEW, 256, ["touching-forgotten"]
    drink = [ball(0, 1.15, 0, 1.1, glass(1.5, attenuation=[0.95, 0.97, 0.97]), 4), ball(0, 1.15, 0, 0.95, glass(1.33, attenuation=[0.9, 0.35, 0.15]), 4),
             ball(0, 1.15, 0, 0.45, glass(1.0), 4)]
    yield "nested", [GROUND, lamp(), *drink], {}, VIEW, 256, ["one-body"]
    metal = lambda roughness: material((0.95, 0.93, 0.88), metallic=1, roughness=roughness)
    yield ("multiple-scattering", [GROUND, lamp(), ball(-1.9, 0.8, 0, 0.8, metal(0.4), 4, True), ball(0, 0.8, 0, 0.8, metal(0.7), 4, True),
                                   ball(1.9, 0.8, 0, 0.8, metal(1.0), 4, True)], {}, VIEW, 96, ["single-scattering"])


def picture(kiln, work, name, view, spp, world, bits):
    light = {"type": "constant", "radiance": [c * world for c in WORLD]}
    camera = {"camera_to_world": looking(view["eye"], view["target"]), "vfov_deg": view["vfov"], "environment": light, "max_scatter": 24}
    (work / f"{name}.json").write_text(json.dumps(camera))
    out = work / f"{name}-{bits}.png"
    subprocess.run([kiln, "render", work / f"{name}.gltf", "--view", work / f"{name}.json", "-o", out, "--spp", str(spp), "--width", str(SIZE[0]),
                    "--height", str(SIZE[1]), "--integrator", "plain", "--quiet"], check=True, env={**os.environ, "KILN_MUTATION": str(bits)})
    return Image.open(out).convert("RGB")


def main(work, wanted):
    kiln = work / "target" / "release" / "kiln"
    numbers = {m[0]: k for k, m in enumerate(MUTATIONS)}
    OUT.mkdir(exist_ok=True)
    scenes = work / "scenes"
    scenes.mkdir(exist_ok=True)
    for name, parts, more, view, spp, off in cases():
        if wanted and name not in wanted:
            continue
        world = more.pop("world", 1.0)
        write_gltf(scenes, name, parts, **more)
        pair = [picture(kiln, scenes, name, view, spp, world, bits) for bits in (0, sum(1 << numbers[m] for m in off))]
        sheet = Image.new("RGB", (2 * SIZE[0] + 6, SIZE[1]), (255, 255, 255))
        for k, half in enumerate(pair):
            sheet.paste(half, (k * (SIZE[0] + 6), 0))
        sheet.quantize(160).save(OUT / f"{name}.png", optimize=True)
        print(name, (OUT / f"{name}.png").stat().st_size, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), sys.argv[2:])
