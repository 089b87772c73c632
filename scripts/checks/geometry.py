"""Checks of geometry: closed boxes at any scale, transforms, needles, leaks, cameras in odd places."""
from math import cos, pi, radians, sin

from .forms import cross, dot, glowing_box, minus
from .surfaces import WHITE, pencil
from .writers import box, icosphere, lambert, quad

SERIES = "Le · (1 + a + a² + … + a^depth): in a closed box of one emission and albedo all light is alike. "
INSIDE = {"eye": [0.3, -0.2, 0.5], "target": [-1, 0.4, -0.8], "vfov_deg": 70.0}
ALL = ["hemisphere", "cosine", "bsdf", "light", "mis"]
FOUR = ["cosine", "bsdf", "light", "mis"]


def matte(albedo, emission):
    return {"Kd": (albedo,) * 3, "Ke": (emission,) * 3}


def scaled(s, offset=0.0):
    return [[s, 0, 0, offset], [0, s, 0, -offset], [0, 0, s, offset], [0, 0, 0, 1]]


def boxes(c):
    for albedo, depth, strategies in ((0.0, 4, ALL), (0.5, 16, ALL), (0.9, 32, FOUR), (0.99, 64, ["bsdf", "mis"])):
        scene = c.obj(f"box_{albedo}", (matte(albedo, 0.7), box(inward=True)))
        c.add(f"box-{albedo}", f"A glowing box of albedo {albedo}", scene, SERIES, glowing_box(0.7, albedo, depth), INSIDE,
              max_depth=depth, strategies=strategies, spp=1024)
    colour = (0.2, 0.5, 0.8)
    scene = c.obj("box_colour", ({"Kd": colour, "Ke": (1, 0.5, 0.25)}, box(inward=True)))
    c.add("box-colour", "A glowing box with a colour", scene, SERIES,
          [glowing_box(e, a, 16) for e, a in zip((1, 0.5, 0.25), colour)], INSIDE, strategies=FOUR, spp=512)
    value = glowing_box(1.0, 0.5, 8)
    half = lambert(0.5, emission=1.0, double_sided=False)
    places = [(s, 0.0) for s in (1e-6, 1e-3, 1e3, 1e6)] + [(1.0, 1e6), (1e-3, 1e3), (1e6, 1e12)]
    for size, offset in places:
        scene = c.gltf(f"box_{size:g}_at_{offset:g}", {"triangles": box(inward=True), "material": half, "matrix": scaled(size, offset)})
        at = lambda p: [s * o + size * x for x, s, o in zip(p, (1, -1, 1), (offset,) * 3)]
        c.add(f"scale-{size:g}-at-{offset:g}", f"A glowing box {size:g} large, {offset:g} away", scene, SERIES, value,
              {"eye": at(INSIDE["eye"]), "target": at(INSIDE["target"]), "vfov_deg": 70.0}, max_depth=8, strategies=FOUR, spp=256)
    transforms = {
        "mirrored": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
        "inverted": [[-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]],
        "sheared": [[1, 0.7, -0.4, 0], [0, 1, 0.3, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
        "stretched": [[1, 0, 0, 0], [0, 100, 0, 0], [0, 0, 0.01, 0], [0, 0, 0, 1]],
    }
    for name, m in transforms.items():
        scene = c.gltf(f"box_{name}", {"triangles": box(inward=True), "material": half, "matrix": m})
        at = lambda p: [sum(m[r][k] * p[k] for k in range(3)) for r in range(3)]
        c.add(f"transform-{name}", f"A glowing box, {name}", scene, SERIES, value,
              {"eye": at((0.3, -0.2, 0.5)), "target": at((-1, 0.4, -0.8)), "vfov_deg": 30.0}, max_depth=8, spp=512,
              strategies=["cosine", "bsdf", "mis"] if name == "stretched" else FOUR)
    flat = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]
    point = [[0, 0, 0, 0.2], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]
    thin = [[0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1e-7, 0], [0, 0, 0, 1]]
    for name, m in (("singular", point), ("flat", flat), ("nearly-flat", thin)):
        white = {"triangles": box(inward=True), "material": half}
        scene = c.gltf(f"box_with_{name}", white, {"triangles": box((-.1,) * 3, (.1,) * 3), "material": half, "matrix": m})
        c.add(f"transform-{name}", f"A glowing box with a small one in it, under a {name} transform", scene,
              SERIES + "What is in it has the same emission and albedo, so it cannot be seen.", value, INSIDE, max_depth=8,
              strategies=["bsdf", "mis"], spp=256)


def triangles(c):
    value = glowing_box(1.0, 0.5, 8)

    def add(name, title, parts, **more):
        c.add(f"mesh-{name}", title, c.obj(f"mesh_{name}", *parts), SERIES, value, INSIDE, max_depth=8,
              **{"strategies": FOUR, "spp": 512, **more})

    walls = box(inward=True)
    needles = []
    for a, b, d in walls:
        cut = [tuple(x + (y - x) * k / 200 for x, y in zip(b, d)) for k in range(201)]
        needles += [(a, p, q) for p, q in zip(cut, cut[1:])]
    add("needles", "A glowing box of 2400 needles", [(matte(0.5, 1), needles)], spp=128)
    nothing = [((0, 0, 0), (0, 0, 0), (0.1, 0, 0)), ((0, 0, 0), (0.1, 0.1, 0.1), (0.2, 0.2, 0.2)), ((0.5, 0.5, 0.5),) * 3]
    add("degenerate", "A glowing box with triangles without area", [(matte(0.5, 1), walls + nothing)])
    add("duplicate", "A glowing box of which every triangle is there twice", [(matte(0.5, 1), walls), (matte(0.5, 1), walls)],
        strategies=["bsdf", "light", "mis"])
    dull = {"Kd": (0.5,) * 3}
    overlaid = [((-1, -1, -1), (-1, 1, -1), (1, 1, -1))]
    add("coplanar", "A glowing box with a dull triangle in the plane of a wall, behind it in the file",
        [(matte(0.5, 1), walls), (dull, [t[::-1] for t in overlaid])], strategies=["cosine", "bsdf"])
    grid = [t for x in range(-4, 4) for y in range(-4, 4) for t in quad((x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0))]
    scene = c.obj("grid", (matte(0, 1), grid))
    leak = "The world behind is a million: the least crack shows."
    shown = {"value": 1.0, "each_pixel": True}
    c.add("leak-grid", "A grid of triangles seen at right angles", scene, leak, shown,
          {"eye": [0, 0, 5], "target": [0, 0, 0], "height": 8.0}, 1e6, strategies=["mis"], width=16, height=16, spp=256)
    for name, at in (("vertex", (1, 1, 0)), ("edge", (1, 0.5, 0)), ("diagonal", (0.5, 0.5, 0)), ("split", (0, 0, 0))):
        c.add(f"leak-grid-{name}", f"Rays along an axis exactly through a grid's {name}", scene, leak, shown,
              pencil((at[0], at[1], 5), at), 1e6, strategies=["mis"], spp=4)
        c.add(f"leak-grid-{name}-oblique", f"Slanting rays exactly through a grid's {name}", scene, leak, shown,
              pencil((at[0] + 4, at[1] - 3, 5), at), 1e6, strategies=["mis"], spp=4)
    ball = [t[::-1] for t in icosphere(2)]
    scene = c.obj("ball", (matte(0, 1), ball))
    c.add("leak-ball", "From within a closed ball of triangles", scene, leak, shown,
          {"eye": [0, 0, 0], "target": [0, 0, -1], "vfov_deg": 150.0}, 1e6, strategies=["mis"], width=16, height=16, spp=256)
    corner = ball[7][1]
    c.add("leak-ball-vertex", "From within a closed ball at one of its corners", scene, leak, shown,
          {"eye": [0, 0, 0], "target": list(corner), "vfov_deg": 1e-4}, 1e6, strategies=["mis"], spp=64)
    tiny = c.gltf("ball_far", {"triangles": ball, "material": lambert(0.0, emission=1.0), "matrix": scaled(1e-3, 1e4)})
    c.add("leak-ball-far", "From within a small ball far away", tiny, leak, shown,
          {"eye": [1e4, -1e4, 1e4], "target": [1e4, -1e4, 0], "vfov_deg": 150.0}, 1e6, strategies=["mis"], width=16, height=16, spp=64)


def cameras(c):
    scene = c.obj("box_cameras", (matte(0.5, 1), box(inward=True)))
    value = glowing_box(1.0, 0.5, 8)
    for name, eye in (("wall", (1, 0.2, 0.3)), ("edge", (1, 1, 0.3)), ("corner", (1, 1, 1))):
        c.add(f"camera-on-{name}", f"The camera exactly on a box's {name}, looking in", scene, SERIES, value,
              {"eye": list(eye), "target": [-0.4, 0.1, 0.2], "vfov_deg": 40.0}, max_depth=8, strategies=FOUR, spp=512)
    outside = c.obj("cube_around", (matte(0.5, 0), box()), (matte(0, 1), box((-3,) * 3, (3,) * 3, inward=True)))
    c.add("camera-in-body", "The camera inside an opaque body", outside, "No light gets in: exactly 0.",
          {"value": 0.0, "each_pixel": True}, INSIDE)


def normals(c):
    sphere = icosphere(1)
    scene = c.gltf("smooth", {"triangles": sphere, "normals": sphere, "material": lambert(1.0)})
    c.add("normals-smooth", "A coarse white sphere with smooth normals neither makes light nor loses it", scene,
          "ρ = 1 in a white world: every direction that the smooth normal leaves open is open.",
          {"value": 1.0, "each_pixel": True}, {"eye": [0, 0, 4], "target": [0, 0, 0], "height": 1.8}, WHITE, spp=128,
          strategies=["cosine", "bsdf", "mis"])
    wild = [[(p[2], -p[0], 0.3 * p[1]) for p in t] for t in sphere]
    scene = c.gltf("wild", {"triangles": sphere, "normals": wild, "material": lambert(1.0)})
    c.add("normals-wild", "A sphere whose normals have nothing to do with it", scene,
          "As for smooth normals: at most 1.", {"value": 1.0, "relation": "at-most", "resolution": 0.05},
          {"eye": [0, 0, 4], "target": [0, 0, 0], "height": 1.8}, WHITE, spp=128)


def facing(z):
    """Matrix (rows) of a node whose +Z is the unit vector z: its light comes from there."""
    x = cross((0, 1, 0), z) if abs(z[1]) < 0.9 else cross((1, 0, 0), z)
    x = tuple(a / dot(x, x) ** 0.5 for a in x)
    y = cross(z, x)
    return [[x[k], y[k], z[k], 0] for k in range(3)] + [[0, 0, 0, 1]]


def terminator(c):
    """Points of a coarse sphere that a light behind their faces' planes still reaches by the smooth normals."""
    sphere = icosphere(2)
    for name, degrees in (("lit", 40), ("grazing", 80), ("below-the-face", 87)):
        # A corner of the mesh straight up, one of the faces around it, and light from beyond that face's upper edge.
        face = next(t for t in sphere if max(p[2] for p in t) > 0.9)
        weights = (0.5, 0.3, 0.2)
        point = tuple(sum(w * p[k] for w, p in zip(weights, face)) for k in range(3))
        length = sum(x * x for x in point) ** 0.5
        normal = tuple(x / length for x in point)  # the corners' normals are the corners, so the mixture is the point
        flat = cross(minus(face[1], face[0]), minus(face[2], face[0]))
        flat = tuple(x / dot(flat, flat) ** 0.5 for x in flat)
        # In the plane of both normals, `degrees` from the smooth one, away from the flat one.
        away = minus(normal, tuple(x * dot(normal, flat) for x in flat))
        away = minus(away, tuple(x * dot(away, normal) for x in normal))
        away = tuple(x / dot(away, away) ** 0.5 for x in away)
        to_light = tuple(cos(radians(degrees)) * n + sin(radians(degrees)) * a for n, a in zip(normal, away))
        assert (dot(to_light, flat) < 0) == (name == "below-the-face") and dot(flat, normal) > 0
        scene = c.gltf(f"terminator_{name}", {"triangles": sphere, "normals": sphere, "material": lambert(0.5)},
                       lights=[({"type": "directional", "intensity": 2.0}, facing(to_light))])
        c.add(f"terminator-{name}", f"Light {degrees}° from a smooth normal, {name.replace('-', ' ')}", scene,
              "ρ/π · E · cos with the interpolated normal: the facets of a sphere cast no shadows on it.",
              {"value": 0.5 / pi * 2 * cos(radians(degrees)), "each_pixel": True, "relative": 1e-4},
              pencil([4 * x for x in normal], point), spp=4)


def write(c):
    boxes(c)
    triangles(c)
    cameras(c)
    normals(c)
    terminator(c)
