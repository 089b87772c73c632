"""Scenes with lights and a camera of their own: a Cornell box, a tree of small lights, three coloured spots."""
import numpy as np

from .gltf import Gltf
from .pictures import srgb
from .shapes import arc, curve, cylinder, lathe, merge, octasphere, quad, rounded_box, rotation, sphere, surface, torus, tube, unit

RED, GREEN = (0.63, 0.065, 0.05), (0.14, 0.45, 0.091)


def open_room(w, h, d):
    """Floor, ceiling, back, left and right of a room with y from 0 to h, facing inwards; the front is open."""
    x, z = w / 2, d / 2
    return {"floor": quad((-x, 0, z), (x, 0, z), (x, 0, -z), (-x, 0, -z)),
            "ceiling": quad((-x, h, -z), (x, h, -z), (x, h, z), (-x, h, z)),
            "back": quad((-x, 0, -z), (x, 0, -z), (x, h, -z), (-x, h, -z)),
            "left": quad((-x, 0, z), (-x, 0, -z), (-x, h, -z), (-x, h, z)),
            "right": quad((x, 0, -z), (x, 0, z), (x, h, z), (x, h, -z))}


def cornell_box(path):
    """The classic: red and green walls, two white blocks, one light."""
    g = Gltf()
    matte = {"specular": {"specularFactor": 0.0}}
    white = g.material("white", (0.74, 0.72, 0.68), **matte)
    walls = {"left": g.material("red", RED, **matte), "right": g.material("green", GREEN, **matte)}
    for name, mesh in open_room(2, 2, 2).items():
        g.put(name, mesh, walls.get(name, white))
    lamp = quad((-0.36, 1.995, -0.22), (0.36, 1.995, -0.22), (0.36, 1.995, 0.4), (-0.36, 1.995, 0.4))
    g.put("lamp", lamp, g.material("lamp", (0, 0, 0), emission=(15.5, 12.6, 9.2), **matte))
    block = g.geometry(rounded_box(1, 1, 1, 0.0))
    quarter = lambda degrees: (0, np.sin(np.radians(degrees / 2)), 0, np.cos(np.radians(degrees / 2)))
    m = g.mesh("block", (block, white))
    g.node(name="tall block", mesh=m, translation=(-0.34, 0.6, -0.3), rotation=quarter(18), scale=(0.58, 1.2, 0.58))
    g.node(name="short block", mesh=m, translation=(0.36, 0.3, 0.32), rotation=quarter(-17), scale=(0.58, 0.6, 0.58))
    g.camera((0, 1, 4.6), (0, 1, 0), 2 * np.degrees(np.arctan(1 / 3.6)) * 0.997)
    g.save_glb(path)


def tree_of_lights(path):
    """Ninety-odd small lights wind up a wire cone in a dark room with a polished floor."""
    g = Gltf()
    rng = np.random.RandomState(3)
    bulb = g.geometry(octasphere(1))
    kinds = []
    for name, colour, power in (("warm", "#ff9f3f", 4.2), ("rose", "#ff3f5c", 3.6), ("sea", "#2fb4d9", 3.2), ("leaf", "#8fd33a", 3.2)):
        light = g.material(name, (0, 0, 0), emission=tuple(round(c * power, 3) for c in srgb(colour)))
        kinds.append(g.mesh(name, (bulb, light)))
    turns, count, height, foot = 7, 96, 2.5, 0.95
    spiral = lambda t: np.array([foot * (1 - t) * np.cos(t * turns * 2 * np.pi), 0.22 + height * t,
                                 foot * (1 - t) * np.sin(t * turns * 2 * np.pi)])
    along = lambda s: 1 - np.sqrt(1 - 0.985 * s)  # evenly along the wire, not in height
    for i in range(count):
        t = along((i + 0.5) / count)
        kind = (0, 1, 0, 2, 0, 3)[i % 6]
        g.node(name=f"light {i}", mesh=kinds[kind], translation=tuple(spiral(t) * (1.03, 1, 1.03)), scale=(0.052,) * 3)
    star = g.material("star", (0, 0, 0), emission=(5.0, 3.4, 1.3))
    g.node(name="star", mesh=g.mesh("star", (g.geometry(star_shape(0.2, 0.085, 0.06)), star)), translation=(0, 2.93, 0))
    wire = np.array([spiral(along(s)) for s in np.linspace(0, 1, 300)])
    g.put("wire", tube(wire, 0.026, 6), g.material("wire", srgb("#4f7a4a"), roughness=0.6))
    g.put("pole", cylinder(0.03, 0, 2.78, 16), g.material("pole", srgb("#6d5a45"), roughness=0.6))
    g.put("stand", cylinder(0.34, 0, 0.1, 48, bevel=0.03), g.material("stand", srgb("#2f4a3c"), roughness=0.4))
    room = open_room(9, 5, 7)
    g.put("floor", room["floor"], g.material("floor", srgb("#5a4438"), roughness=0.22))
    plaster = g.material("plaster", srgb("#55657f"), roughness=0.95)
    for name in ("ceiling", "back", "left", "right"):
        g.put(name, room[name], plaster)
    glow = quad((-2.5, 4.9, -2), (2.5, 4.9, -2), (2.5, 4.9, 3), (-2.5, 4.9, 3))
    g.put("moonlight", glow, g.material("moonlight", (0, 0, 0), emission=(1.15, 1.35, 1.85)))
    gifts = ((-1.25, 0.55, 0.5, 24, "#b23a48"), (1.2, 0.3, 0.62, -18, "#d8a657"), (0.82, 1.12, 0.36, 35, "#e6dfd2"), (-0.75, 1.2, 0.34, -12, "#3d7068"))
    ribbon = g.material("ribbon", srgb("#efe6d6"), roughness=0.3)
    for k, (x, z, size, turn, colour) in enumerate(gifts):
        box = rounded_box(size, size * 0.8, size, 0.02).moved(y=size * 0.4).turned(turn).moved(x, 0, z)
        band = merge(rounded_box(size * 1.015, size * 0.815, size * 0.16, 0.01), rounded_box(size * 0.16, size * 0.815, size * 1.015, 0.01))
        g.put(f"gift {k}", box, g.material(f"paper {k}", srgb(colour), roughness=0.45))
        g.put(f"ribbon {k}", band.moved(y=size * 0.4).turned(turn).moved(x, 0, z), ribbon)
    g.camera((0.9, 1.85, 6.3), (0.0, 1.36, 0), 35)
    g.save_glb(path)


def star_shape(outer, inner, thickness):
    """A five-pointed star, raised in the middle on both sides."""
    a = np.radians(90 + 36 * np.arange(10))
    r = np.where(np.arange(10) % 2 == 0, outer, inner)
    rim = np.stack([r * np.cos(a), r * np.sin(a), 0 * a], -1)
    parts = []
    for z in (thickness, -thickness):
        for i in range(10):
            p = np.array([(0, 0, z), rim[i], rim[(i + 1) % 10]])[::1 if z > 0 else -1]
            parts.append(quad(p[0], p[1], p[2], p[2]))
    whole = merge(*parts)
    whole.tri = whole.tri[::2]
    return whole


def coloured_spots(path):
    """KHR_lights_punctual: red, green and blue spots make white light and coloured shadows; a point fills."""
    g = Gltf()
    paper = g.material("paper", srgb("#e6e3dd"), roughness=0.9, specular={"specularFactor": 0.3})
    run = np.vstack([[(z, 0.0) for z in np.linspace(4.5, -1.4, 10)], arc(-1.4, 1.4, 1.4, -90, -180, 24)[1:] * 1.0,
                     [(-2.8, y) for y in np.linspace(1.7, 5.5, 6)]])
    x = np.linspace(-5, 5, 3)
    sweep = np.stack([np.broadcast_to(x, (len(run), 3)), np.repeat(run[:, 1:], 3, 1), np.repeat(run[:, :1], 3, 1)], -1)
    g.put("sweep", surface(sweep), paper)
    g.put("plinth", cylinder(0.62, 0, 0.34, 96, bevel=0.03), paper)
    g.put("knot", knot(0.62, 0.155).moved(y=1.42), g.material("porcelain", srgb("#f0ece4"), roughness=0.35))
    g.put("foot", lathe([curve([(0.16, 0.34), (0.07, 0.42), (0.05, 0.6), (0.09, 0.74)], 16)], 48), g.material("brass", (0.9, 0.7, 0.4), 1.0, 0.3))
    cone = {"innerConeAngle": 0.3, "outerConeAngle": 0.62}
    for name, colour, x in (("red", (1.0, 0.1, 0.08), 2.7), ("green", (0.08, 0.72, 0.14), 0.3), ("blue", (0.1, 0.2, 1.0), -2.1)):
        g.light(name, "spot", colour, 85.0, (x, 2.9, 5.4), (0, 1.3, -0.9), **cone)
    g.light("fill", "point", (1.0, 0.95, 0.9), 2.2, (0.5, 4.2, 3.0))
    g.camera((0.35, 1.9, 7.4), (0.0, 1.5, -0.5), 31)
    g.save_glb(path)


def knot(radius, thickness, p=2, q=3):
    """A torus knot."""
    t = np.linspace(0, 2 * np.pi, 193)
    r = radius * (1 + 0.42 * np.cos(q * t))
    path = np.stack([r * np.cos(p * t), r * np.sin(p * t), radius * 0.62 * np.sin(q * t)], -1)
    tangent = np.gradient(np.vstack([path[-2], path, path[1]]), axis=0)[1:-1]
    across = unit(np.cross(tangent, path * (1, 1, 0.0) + (0, 0, 1e-6)))
    out = unit(np.cross(across, tangent))
    a = np.linspace(0, 2 * np.pi, 21)
    ring = out[:, None] * np.cos(a)[None, :, None] + across[:, None] * np.sin(a)[None, :, None]
    return surface(path[:, None] + thickness * ring, ring)
