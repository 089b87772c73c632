"""Still lifes for the studio light: a mended bowl, coloured glass, a stair of metals, frosted dice."""
import numpy as np

from .gltf import Gltf
from .pictures import bytes_of, fractal, mix, noise, normal_map, png, smoothstep, srgb
from .shapes import arc, curve, cylinder, lathe, merge, rounded_box, sphere


def bowl_profile():
    """Inside from the centre to the rim, over the rim, down the outside to the foot."""
    inner = curve([(0.0, 0.16), (0.3, 0.18), (0.66, 0.36), (0.9, 0.68), (1.0, 0.98)], 28)[::-1]
    rim = arc(1.03, 0.98, 0.03, 0, 180, 7)
    outer = curve([(0.42, 0.1), (0.74, 0.26), (0.98, 0.62), (1.06, 0.98)], 24)
    foot = [np.array([(0.0, 0.04), (0.36, 0.04)]), np.array([(0.36, 0.04), (0.38, 0.0), (0.44, 0.0)]),
            np.array([(0.44, 0.0), (0.42, 0.1)])]
    return [*foot, np.vstack([outer, rim[1:-1], inner])]


def profile_at(profile, size):
    """(r, y) and arc length per texel row for `size` rows of a lathe's texture (v = 0 is the profile's end)."""
    points = np.vstack([run if k == 0 else run[1:] for k, run in enumerate(profile)])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = (1 - (np.arange(size) + 0.5) / size) * length[-1]
    return np.interp(at, length, points[:, 0]), np.interp(at, length, points[:, 1]), length[-1]


def cracks(p):
    """Distance to the nearest seam between shards, and the shard's number: a Voronoi pattern, bent by noise."""
    bent = p + 0.16 * np.stack([noise(p * 2.6, s) - 0.5 for s in (11, 12, 13)], -1)
    bent = bent + 0.03 * np.stack([noise(p * 11, s) - 0.5 for s in (14, 15, 16)], -1)
    rng = np.random.RandomState(5)
    seeds = np.array([(r * np.cos(a), y, r * np.sin(a)) for r, a, y in
                      zip(rng.uniform(0.25, 1.15, 15), rng.uniform(0, 2 * np.pi, 15), rng.uniform(0.0, 1.1, 15))])
    squared = ((bent[..., None, :] - seeds) ** 2).sum(-1)
    order = np.argsort(squared, -1, kind="stable")
    near, next_ = (np.take_along_axis(squared, order[..., k:k + 1], -1)[..., 0] for k in (0, 1))
    gap = np.linalg.norm(seeds[order[..., 0]] - seeds[order[..., 1]], axis=-1)
    return (next_ - near) / (2 * gap), order[..., 0]


def kintsugi(path):
    """A glazed bowl mended with gold: base colour, metallic-roughness and normal textures."""
    width, height = 896, 448
    profile = bowl_profile()
    r, y, length = profile_at(profile, height)
    angle = (np.arange(width) + 0.5) / width * 2 * np.pi
    p = np.stack([r[:, None] * np.cos(angle), np.broadcast_to(y[:, None], (height, width)), -r[:, None] * np.sin(angle)], -1)
    distance, shard = cracks(p)
    gold = 1 - smoothstep(0.011, 0.017, distance)
    rim = np.argmax(y) / height  # rows above it are the inside
    inside = smoothstep(rim + 0.004, rim - 0.004, (np.arange(height) + 0.5) / height)[:, None] * np.ones((1, width))
    cloud = fractal(p * 3.0, 4, 3)
    spots = smoothstep(0.80, 0.86, noise(p * 26, 21)) * 0.5
    glaze = mix(bytes_of("#17406b"), bytes_of("#3f86a8"), smoothstep(0.25, 0.8, cloud)[..., None])
    glaze = mix(glaze, bytes_of("#0e2747"), spots[..., None])
    cream = mix(bytes_of("#e9dfcb"), bytes_of("#f4eee2"), smoothstep(0.3, 0.7, cloud)[..., None])
    cream = mix(cream, bytes_of("#bfa98a"), (spots * 0.5)[..., None])
    base = mix(glaze, cream, inside[..., None])
    clay = (y < 0.105)[:, None] & (inside < 0.5)
    base = np.where(clay[..., None], bytes_of("#8d6a4c"), base)
    base = mix(base, bytes_of("#f2c063"), gold[..., None])
    rough = mix(np.where(clay, 0.85, 0.16 + 0.10 * cloud), 0.26 + 0.1 * noise(p * 40, 8), gold)
    seam = 0.016 * np.sqrt(np.clip(1 - (distance / 0.017) ** 2, 0, 1))
    rings = 0.0012 * np.sin(y * 95)[:, None] * (1 - gold)
    bumps = normal_map(seam + rings, 2 * np.pi * np.maximum(r, 0.05)[:, None] / width, length / height)
    g = Gltf()
    maps = {"baseColor": g.texture("base colour", png(base, 128)),
            "metallicRoughness": g.texture("metal rough", png(np.stack([np.full_like(gold, 255), rough * 255, gold * 255], -1), 96)),
            "normal": g.texture("normal", png(bumps, 200))}
    bowl = g.material("mended glaze", metallic=1.0, maps=maps)
    g.put("bowl", lathe(profile, 64), bowl, uv=True)
    g.save_glb(path)


def vessel(outer, inner):
    """A closed glass body of revolution: up the outside, round the lip, down the inside."""
    lip = np.array([outer[-1], (outer[-1] + inner[0]) / 2 + (0, 0.03), inner[0]])
    return lathe([np.array([(0, outer[0][1]), outer[0]]), np.vstack([outer, curve(lip, 7)[1:-1], inner])], 48)


def tinted_glass(path):
    """Three coloured glasses: transmission, index of refraction and a volume that absorbs."""
    g = Gltf()

    def glass(name, colour, distance):
        return g.material(name, roughness=0.0, transmission={"transmissionFactor": 1.0}, ior={"ior": 1.5}, volume={
            "thicknessFactor": 0.1, "attenuationColor": [round(c, 4) for c in srgb(colour)], "attenuationDistance": distance})

    bottle = vessel(curve([(0.40, 0.0), (0.46, 0.06), (0.47, 0.5), (0.44, 1.0), (0.2, 1.32), (0.13, 1.6), (0.17, 1.86)], 32),
                    curve([(0.09, 1.86), (0.06, 1.6), (0.12, 1.3), (0.36, 0.97), (0.39, 0.5), (0.37, 0.14), (0.0, 0.1)], 32))
    stopper = sphere(0.2, 32, 64).scaled(1, 1.1, 1).moved(y=2.1)
    vase = vessel(curve([(0.3, 0.0), (0.52, 0.2), (0.62, 0.5), (0.5, 0.82), (0.24, 1.02), (0.22, 1.12), (0.36, 1.3)], 32),
                  curve([(0.29, 1.3), (0.15, 1.1), (0.17, 1.0), (0.42, 0.78), (0.53, 0.5), (0.44, 0.22), (0.0, 0.12)], 32))
    bowl = vessel(curve([(0.2, 0.0), (0.36, 0.05), (0.52, 0.24), (0.58, 0.5)], 24),
                  curve([(0.5, 0.5), (0.44, 0.27), (0.3, 0.14), (0.0, 0.1)], 24))
    g.put("bottle", bottle, glass("amber", "#e8912a", 0.09), translation=(-0.52, 0.0, -0.35))
    g.put("stopper", stopper, glass("amber, solid", "#e8912a", 0.3), translation=(-0.52, 0.0, -0.35))
    g.put("vase", vase, glass("petrol", "#2aa6a0", 0.09), translation=(0.68, 0.0, -0.2))
    g.put("bowl", bowl, glass("rose", "#e0618a", 0.10), translation=(0.1, 0.0, 0.72))
    g.put("tray", cylinder(1.62, -0.12, 0.0, 96, bevel=0.05), g.material("chalk", srgb("#e8e4dc"), roughness=0.9))
    g.save_glb(path)


def metal_stairs(path):
    """Four materials by six roughnesses; all spheres share one geometry, all cups and steps one mesh each."""
    g = Gltf()
    ball, step = g.geometry(sphere(0.46, 28, 56)), g.geometry(rounded_box(6.5, 0.66, 1.1, 0.05))
    cup = g.geometry(lathe([[(0, 0), (0.3, 0)], curve([(0.3, 0), (0.31, 0.04), (0.24, 0.09)], 8), [(0.24, 0.09), (0.0, 0.09)]], 48))
    stone = g.mesh("step", (step, g.material("limestone", srgb("#cfc9bf"), roughness=0.8)))
    brass = g.mesh("cup", (cup, g.material("dark steel", srgb("#55585e"), metallic=1.0, roughness=0.4)))
    rows = [("lacquer", (0.62, 0.035, 0.03), 0.0), ("copper", (0.93, 0.56, 0.42), 1.0),
            ("gold", (0.944, 0.776, 0.373), 1.0), ("silver", (0.962, 0.949, 0.922), 1.0)]
    for j, (name, colour, metallic) in enumerate(rows):
        y, z = 0.62 * j, -1.04 * j
        g.node(name=f"step {j}", mesh=stone, translation=(0, y - 0.33, z))
        for i in range(6):
            roughness = round(0.04 + 0.16 * i, 2)
            x = (i - 2.5) * 1.05
            m = g.material(f"{name} {roughness}", colour, metallic, roughness)
            g.node(name=f"cup {j} {i}", mesh=brass, translation=(x, y, z))
            g.node(name=f"{name} {i}", mesh=g.mesh(f"{name} {i}", (ball, m)), translation=(x, y + 0.51, z))
    g.camera((2.2, 5.0, 11.0), (0.0, 1.0, -1.45), 33)
    g.save_glb(path)


PIPS = {1: [(0, 0)], 2: [(-1, -1), (1, 1)], 3: [(-1, -1), (0, 0), (1, 1)], 4: [(-1, -1), (-1, 1), (1, -1), (1, 1)],
        5: [(-1, -1), (-1, 1), (0, 0), (1, -1), (1, 1)], 6: [(-1, -1), (-1, 0), (-1, 1), (1, -1), (1, 0), (1, 1)]}


def frosted_dice(path):
    """Rough transmission with absorption; a .gltf whose buffer is a data: URI. One die, placed three times."""
    g = Gltf()
    body = g.geometry(rounded_box(1, 1, 1, 0.16, 5))
    disc = lathe([[(0, 0.501), (0.088, 0.501)], [(0.088, 0.501), (0.088, 0.51)], [(0.088, 0.51), (0, 0.51)]], 16)
    turns = {1: (), 6: ((180, "x"),), 2: ((90, "x"),), 5: ((-90, "x"),), 3: ((90, "z"),), 4: ((-90, "z"),)}
    pips = []
    for number, spots in PIPS.items():
        for x, z in spots:
            pip = disc.moved(0.24 * x, 0, 0.24 * z)
            for degrees, axis in turns[number]:
                pip = pip.turned(degrees, axis)
            pips.append(pip)
    dots = g.mesh("pips", (g.geometry(merge(*pips)), g.material("ivory", srgb("#fbf6ea"), roughness=0.5)))
    about_y = lambda degrees: (0, np.sin(np.radians(degrees / 2)), 0, np.cos(np.radians(degrees / 2)))
    for name, colour, distance, place, turn in (("ruby", "#e8405a", 0.6, (-0.62, 0.5, 0.05), 24), ("sapphire", "#4f95f0", 0.62, (0.66, 0.5, 0.0), -20),
                                                ("amber", "#f5b03a", 0.55, (-0.02, 1.512, 0.02), 52)):
        acrylic = g.material(name, roughness=0.22, transmission={"transmissionFactor": 1.0}, ior={"ior": 1.49}, volume={
            "thicknessFactor": 1.0, "attenuationColor": [round(c, 4) for c in srgb(colour)], "attenuationDistance": distance})
        die = g.node(name=f"{name} die", translation=place, rotation=about_y(turn))
        g.node(die, name=name, mesh=g.mesh(name, (body, acrylic)))
        g.node(die, name=f"{name} pips", mesh=dots)
    g.put("slate", cylinder(1.55, -0.12, -0.013, 96, bevel=0.04), g.material("slate", srgb("#5d6468"), roughness=0.7))
    g.save_embedded(path)
