"""Scenes as a stranger would think them up to break a renderer."""
from math import radians, tan

from .forms import cross, glowing_box
from .geometry import INSIDE, SERIES, matte, scaled
from .remedies import unit
from .surfaces import FLAT, FURNACE, WHITE, at_angle, pencil
from .writers import box, icosphere, lambert, material, png, quad, ray_mesh

BOTH = ["bsdf", "mis"]
OBLIQUE = {"eye": [3, 2, 4], "target": [0, 0, 0], "height": 1.0}


def looking(eye, target):
    """Matrix (rows) of a camera node."""
    z = unit([a - b for a, b in zip(eye, target)])
    x = unit(cross((0, 1, 0), z))
    y = cross(z, x)
    return [[x[k], y[k], z[k], eye[k]] for k in range(3)] + [[0, 0, 0, 1]]


def cameras(c):
    half = lambert(0.5, emission=1.0, double_sided=False)
    for size in (1e-12, 1e-6, 1e6, 1e12):
        scene = c.gltf(f"box_with_camera_{size:g}", {"triangles": box(inward=True), "material": half, "matrix": scaled(size)},
                       camera=(70, looking([size * x for x in INSIDE["eye"]], [size * x for x in INSIDE["target"]])))
        c.add(f"camera-in-file-{size:g}", f"A glowing box {size:g} large, seen by the camera in its file", scene, SERIES,
              glowing_box(1.0, 0.5, 8), max_depth=8, strategies=BOTH, spp=256)
    red, blue = {"Kd": (0, 0, 0), "Ke": (1, 0, 0)}, {"Kd": (0, 0, 0), "Ke": (0, 0, 1)}
    scene = c.obj("two_halves", (red, quad((-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0))), (blue, quad((0, -1, 0), (1, -1, 0), (1, 1, 0), (0, 1, 0))))
    for degrees in (0.01, 0.0001, 179):
        distance = 1 / tan(radians(degrees / 2))
        c.add(f"camera-fov-{degrees:g}", f"Two halves of a square, seen under {degrees:g}°", scene,
              "The square fills the picture; its middle line is that of the picture.",
              [{"value": [1, 0, 0], "region": [0, 0, 4, 8], "each_pixel": True}, {"value": [0, 0, 1], "region": [4, 0, 8, 8], "each_pixel": True}],
              {"eye": [0, 0, distance], "target": [0, 0, 0], "vfov_deg": degrees}, strategies=["mis"], spp=16)
    speck = lambda x, y: f"translate({x!r}, {y!r}, 0, scale(0.0001, sphere {{ material = {{ diffuse = (1, 1, 1); }} }}))"
    scene = c.ray("specks", speck(1e4, 0.0), speck(1e4, 3e-4))
    c.add("camera-at-specks", "Spheres of radius 0.0001 at 10000 from the origin", scene, FURNACE + "ρ = 1; what touches the other sees white.",
          {"value": 1.0, "relative": 1e-4}, {"eye": [1e4, 1e-5, 1e-3], "target": [1e4, 0, 0], "height": 1e-4}, WHITE, strategies=BOTH, spp=16, max_depth=64)


def stretched(c):
    half = lambert(0.5, emission=1.0, double_sided=False)
    m = [[1, 0, 0, 0], [0, 1e3, 0, 0], [0, 0, 1e-3, 0], [0, 0, 0, 1]]
    camera = {"eye": [0.3, -200, 0.0005], "target": [-1, 400, -0.0008], "vfov_deg": 30.0}
    more = {"max_depth": 8, "spp": 256, "strategies": BOTH}
    value = glowing_box(1.0, 0.5, 8)
    c.add("transform-stretched-million", "A glowing box, a million times longer than thin by its transform",
          c.gltf("box_million", {"triangles": box(inward=True), "material": half, "matrix": m}), SERIES, value, camera, **more)
    c.add("mesh-million-to-one", "A glowing box, a million times longer than thin by its corners",
          c.obj("box_million", (matte(0.5, 1), box((-1, -1e3, -1e-3), (1, 1e3, 1e-3), inward=True))), SERIES, value, camera, **more)
    needles = []
    for k in range(64):
        needles += [t[::-1] for t in quad((-1, k / 32 - 1, 1), (1, k / 32 - 1, 1), (1, k / 32 - 1 + 2e-6, 1), (-1, k / 32 - 1 + 2e-6, 1))]
        needles += [t[::-1] for t in quad((-1, k / 32 - 1 + 2e-6, 1), (1, k / 32 - 1 + 2e-6, 1), (1, k / 32 - 1 + 1 / 32, 1), (-1, k / 32 - 1 + 1 / 32, 1))]
    rest = [t for t in box(inward=True) if any(p[2] < 0 for p in t)]
    c.add("mesh-needles-million", "A glowing box whose lid has strips a million times longer than wide",
          c.obj("box_needles_million", (matte(0.5, 1), rest + needles)), SERIES, value, INSIDE, max_depth=8, spp=512, strategies=BOTH)


def strays(c):
    """Something small far away from all the rest, as files often have it at their origin."""
    half = lambert(0.5, emission=1.0, double_sided=False)
    walls = [part for t in box(inward=True) for part in quarters(t)]
    for distance in (1e4, 1e6, 1e9):
        at = lambda p: [x + s * distance for x, s in zip(p, (1, -1, 1))]
        scene = c.gltf(f"stray_{distance:g}", {"triangles": walls, "material": half, "matrix": scaled(1.0, distance)},
                       {"triangles": [((0, 0, 0), (1, 0, 0), (0, 1, 0))], "material": lambert(0.5)})
        c.add(f"stray-{distance:g}", f"A glowing box, and a triangle {distance:g} away from it", scene, SERIES, glowing_box(1.0, 0.5, 8),
              {"eye": at(INSIDE["eye"]), "target": at(INSIDE["target"]), "vfov_deg": 70.0}, max_depth=8, strategies=BOTH, spp=256)
    ball = [part for t in icosphere(2) for part in quarters(t)]
    ground = quad((-1e6, -1e6, -3), (1e6, -1e6, -3), (1e6, 1e6, -3), (-1e6, 1e6, -3))
    scene = c.gltf("ball_on_plain", {"triangles": [tuple((1e5 + x, y, z) for x, y, z in t) for t in ball], "material": lambert(1.0)},
                   {"triangles": ground, "material": lambert(1.0)})
    c.add("stray-plain", "A white ball over a white plain two million wide", scene, FURNACE + "All is white.", {"value": 1.0, "relative": 1e-4},
          {"eye": [1e5 + 3, 1, 4], "target": [1e5, 0, 0], "height": 6.0}, WHITE, strategies=BOTH, spp=64, max_depth=64)


def quarters(triangle):
    a, b, d = triangle
    half = lambda p, q: tuple((x + y) / 2 for x, y in zip(p, q))
    ab, bd, da = half(a, b), half(b, d), half(d, a)
    return [(a, ab, da), (ab, b, bd), (da, bd, d), (ab, bd, da)]


def odds(c):
    for sampler in ("pcg", "lcg", "xorshift32"):
        c.add(f"sampler-{sampler}", f"A glowing box by the numbers of {sampler}", "box_0.5.obj", SERIES, glowing_box(0.7, 0.5, 16), INSIDE,
              sampler=sampler, strategies=BOTH, spp=1024)
    for size in (1e7, 1e30):
        uvs = [((0, size), (size, size), (size, 0)), ((0, size), (size, 0), (0, 0))]
        scene = c.gltf(f"uv_{size:g}", {"triangles": FLAT, "material": material(unlit={}, base_texture={"index": 0}), "uvs": uvs}, images=[png(1, 1, [[(255, 255, 255)]])])
        c.add(f"texture-uv-{size:g}", f"Texture coordinates of {size:g}", scene, "The texture is white all over.", {"value": 1.0, "each_pixel": True}, at_angle(30), strategies=["mis"], spp=4)
    scene = c.gltf("no_normals", {"triangles": FLAT, "normals": [[(0, 0, 0)] * 3] * 2, "material": lambert(0.5)})
    c.add("normals-of-no-length", "Normals of length zero in the file", scene, FURNACE + "ρ · 1.", 0.5, at_angle(30), WHITE, strategies=BOTH)
    rows = [[[3.0, 2.0, 1.0]] * 8] + [[[0.5] * 3] * 8] * 6 + [[[1.0, 2.0, 3.0]] * 8]
    for name, y, value in (("up", 1, [3, 2, 1]), ("down", -1, [1, 2, 3])):
        c.add(f"environment-pole-{name}", f"The world exactly {name}", "speck.obj", "The row of texels at the pole.", {"value": value, "each_pixel": True},
              pencil((5, 0, 5), (5, y, 5), up=[1.0, 0.0, 0.0]), {"rows": rows}, strategies=["mis"], spp=4)
    for k, target in enumerate(((1, 1e-30, 0), (1e-38, 1, -1e-38), (-1e-7, 1e-20, -1), (1e-44, -1, 1e-10))):
        up = [0.0, 0.0, 1.0] if abs(target[2]) < 0.5 else [0.0, 1.0, 0.0]
        c.add(f"ray-direction-nearly-{k}", f"A ray along {target}: all but parallel to an axis", "box_of_many.obj", "The world behind is a million: the least crack shows.",
              {"value": 1.0, "each_pixel": True}, {"eye": [0, 0, 0], "target": list(target), "up": up, "vfov_deg": 0.0}, 1e6, strategies=["mis"], spp=2, width=1, height=1)
    at_most = [{"value": 1.0, "relation": "at-most", "relative": 0.005, "resolution": 0.05}]
    for k, extra in enumerate(({"Ks": (1, 1, 1), "Ns": 0}, {"Ks": (1, 1, 1), "Ns": 1e9}, {"Ks": (1, 1, 1), "Ns": 1000, "illum": 3}, {"Ni": 1.0, "d": 0.5, "illum": 7},
                               {"Ni": 0.0, "illum": 7, "Tf": (1, 1, 1)}, {"Pr": 0.0, "Pm": 1.0}, {"Pr": 1.0, "Pm": 0.5, "Ps": 1.0, "Pc": 1.0, "Pcr": 1.0})):
        scene = c.obj(f"mtl_{k}", ({"Kd": (1, 1, 1), **extra}, box()))
        c.add(f"furnace-mtl-{k}", "A white MTL material with " + ", ".join(f"{a} {b}" for a, b in extra.items()), scene, FURNACE + "Passive: at most 1.", at_most,
              OBLIQUE, WHITE, strategies=BOTH, spp=256, max_depth=64)
    for shininess in (0, 1, 1e6):
        body = ray_mesh(box(), f"diffuse = (0.5, 0.5, 0.5); specular = (0.5, 0.5, 0.5); shininess = {shininess};")
        c.add(f"furnace-ray-phong-{shininess:g}", f"A .ray body of shininess {shininess:g}", c.ray(f"phong_{shininess:g}", body), FURNACE + "Passive: at most 1.", at_most,
              OBLIQUE, WHITE, strategies=BOTH, spp=256)


def write(c):
    cameras(c)
    stretched(c)
    strays(c)
    odds(c)
