"""Scenes as a stranger would think them up to break a renderer."""
from math import cos, pi, radians, sin, sqrt, tan

from .forms import cross, disc_beyond, glowing_box, irradiance, layers
from .geometry import INSIDE, SERIES, matte, scaled
from .remedies import unit
from .surfaces import FLAT, FURNACE, WHITE, at_angle, pencil
from .writers import box, glass, icosphere, lambert, material, png, quad, ray_mesh

BOTH = ["bsdf", "mis"]
THROUGH = FURNACE + "Clear smooth glass absorbs nothing."
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


def glasses(c):
    top = pencil((0.1, 0.2, 3), (0.1, 0.2, 0))
    plate = quad((-.9, -.9, 0), (.9, -.9, 0), (.9, .9, 0), (-.9, .9, 0))
    scene = c.gltf("light_in_glass", {"triangles": box((-1, -1, -.5), (1, 1, .5)), "material": glass(1.5)},
                   {"triangles": plate, "material": lambert(0.0, emission=2.25)})
    c.add("light-inside-glass", "A black plate that glows inside a glass box", scene,
          "(1 − R) · Le / n² with R = 0.04: radiance falls with n² on the way out, and what is reflected meets black.",
          {"value": 0.96 * 2.25 / 2.25}, top, strategies=BOTH, spp=1024)
    for thickness in (1e-3, 1e-5):
        scene = c.gltf(f"thin_slab_{thickness:g}", {"triangles": box((-1, -1, 0), (1, 1, thickness)), "material": glass(1.5)})
        c.add(f"glass-slab-thin-{thickness:g}", f"A glass slab {thickness:g} thick and 2 wide lets through what slabs do", scene,
              "(1 − R)/(1 + R) of what is behind, R = 0.04; the rest is black.", 0.96 / 1.04, top,
              {"rows": [[[1, 1, 1]] * 4 + [[0, 0, 0]] * 4] * 4}, strategies=BOTH, spp=1024, max_depth=32)
    for index in (1.5, 1.2):
        scene = c.gltf(f"touching_boxes_{index}", {"triangles": box((-1, -1, -1), (1, 1, 0)), "material": glass(1.5)},
                       {"triangles": box((-1, -1, 0), (1, 1, 1)), "material": glass(index, 0.0, (1, 1, 1), [0.999999] * 3)})
        c.add(f"glass-touching-{index}", f"Two glass boxes of index 1.5 and {index} that share a face", scene, THROUGH, {"value": 1.0, "relative": 1e-3}, OBLIQUE, WHITE,
              strategies=BOTH, max_depth=128, spp=256)
    tints = ([0.25, 0.5, 0.75], [0.6, 0.3, 0.9])
    takes = lambda k: [tint[k] ** 0.5 for tint in tints]
    for order in ((0, 1), (1, 0)):
        for index in (1.5, 1.2):
            plates = [{"triangles": box((-1, -1, -.5), (1, 1, 0)), "material": glass(1.5, attenuation=tints[0])},
                      {"triangles": box((-1, -1, 0), (1, 1, .5)), "material": glass(index, attenuation=tints[1])}]
            name = f"{index}-{'lower' if order[0] == 0 else 'upper'}-first"
            c.add(f"absorption-touching-{name}", f"Two plates that touch, the upper one of index {index}", c.gltf(f"plates_{name}", *[plates[k] for k in order]),
                  "Plates without air between them are added one by one (layers in scripts/checks/forms.py).",
                  [layers([1, index, 1.5, 1], takes(k)[::-1]) for k in range(3)], top, WHITE, strategies=BOTH, spp=1024, max_depth=64)
    scene = c.gltf("bricks", *[{"triangles": box((-1, -1, k - 1), (1, 1, k)), "material": glass(1.5)} for k in range(3)])
    c.add("glass-bricks", "Three bricks of one glass that touch", scene, THROUGH, {"value": 1.0, "relative": 2e-3}, OBLIQUE, WHITE, strategies=BOTH, max_depth=128, spp=256)
    outer, wall = box((-1, -1, -1), (1, 1, 1)), box((-.8, -.8, -.8), (.8, .8, .8), inward=True)
    liquid = glass(1.33, attenuation=[0.9999999] * 3)
    scene = c.gltf("glass_of_water", {"triangles": outer + wall, "material": glass(1.5)}, {"triangles": box((-.8, -.8, -.8), (.8, .8, .8)), "material": liquid})
    c.add("glass-of-water", "Water that fills the hollow of a glass exactly", scene, THROUGH, {"value": 1.0, "relative": 1e-3}, OBLIQUE, WHITE,
          strategies=BOTH, max_depth=128, spp=256)
    floor = quad((-9, -9, -1), (9, -9, -1), (9, 9, -1), (-9, 9, -1))
    for name, order in (("first", (1, 0)), ("last", (0, 1))):
        parts = [{"triangles": box(), "material": glass(1.5)}, {"triangles": floor, "material": lambert(1.0)}]
        scene = c.gltf(f"glass_on_floor_{name}", *[parts[k] for k in order])
        c.add(f"glass-on-the-floor-{name}", f"A glass box that stands on a white floor, which comes {name} in the file", scene,
              THROUGH + " The floor has albedo 1.", {"value": 1.0, "relative": 5e-3}, OBLIQUE, WHITE, strategies=BOTH, max_depth=256, spp=256)
    sphere = icosphere(2)
    scene = c.gltf("glass_smooth", {"triangles": sphere, "normals": sphere, "material": glass(1.5)})
    c.add("furnace-glass-smooth-normals", "A coarse glass sphere with smooth normals", scene,
          THROUGH + " What the interpolated normal refracts to the wrong side of a facet is lost.",
          [{"value": 1.0, "relation": "at-most", "relative": 1e-4}, {"value": 0.98, "relation": "at-least"}], {"eye": [0, 0, 4], "target": [0, 0, 0], "height": 1.0}, WHITE,
          strategies=BOTH, max_depth=256, spp=256)
    slab = box((-1, -1, -.25), (1, 1, .25))
    for name, distance, colour, value in (("black", 1.0, [0, 0, 0], 0.04), ("dense", 1e-30, [.5] * 3, 0.04), ("thin", 1e30, [.5] * 3, 1.0)):
        body = glass(1.5, attenuation=colour)
        body["extensions"]["KHR_materials_volume"]["attenuationDistance"] = distance
        c.add(f"absorption-{name}", f"A slab of glass of colour {colour[0]} at a distance of {distance:g}", c.gltf(f"absorption_{name}", {"triangles": slab, "material": body}),
              "R = 0.04, and of the rest all or nothing comes through.", value, top, WHITE, strategies=BOTH, spp=1024, max_depth=32)


def mirrors(c):
    """A closed room of mirrors with a hole: an image of an image of the world."""
    f0, hole = 0.98, 0.125
    room = [t for t in box(inward=True) if any(p[2] < 0 for p in t)]
    around = [((-1, -1), (1, -hole)), ((-1, hole), (1, 1)), ((-1, -hole), (-hole, hole)), ((hole, -hole), (1, hole))]
    lid = [t[::-1] for (x, y), (u, v) in around for t in quad((x, y, 1), (u, y, 1), (u, v, 1), (x, v, 1))]
    scene = c.gltf("mirror_room", {"triangles": room + lid, "material": material((f0,) * 3, metallic=1, roughness=0)})
    eye = (0.1, 0.05, -0.2)
    for bounces, direction in holes_after(eye, hole, ((10, 40), (60, 128))):
        value, cosines = 1.0, [abs(x) for x in direction]
        for axis, times in enumerate(bounces):
            value *= (f0 + (1 - f0) * (1 - cosines[axis]) ** 5) ** times
        c.add(f"mirror-room-{sum(bounces)}", f"The world by {sum(bounces)} mirrors through a hole", scene,
              "The room's images tile space: the straight line in them meets the hole after so many walls. Schlick's reflectance at each.",
              {"value": value, "relative": 1e-4, "resolution": 0.05}, pencil(eye, [e + d for e, d in zip(eye, direction)]), WHITE,
              strategies=["mis"], spp=4096, max_depth=128, width=1, height=1)


def holes_after(eye, hole, ranges):
    """Directions from `eye` that leave the room of mirrors through the middle of its hole after so many
    reflections, with those at walls across x, y and z."""
    found = []
    for low, high in ranges:
        for k in range(1, 1000):
            direction = unit((sin(k * 1.7), cos(k * 2.3), 0.9 * sin(k * 0.7) + 0.05))
            place, times = list(eye), [0, 0, 0]
            d = list(direction)
            for _ in range(128):
                walls = [((1 if x > 0 else -1) - p) / x for p, x in zip(place, d)]
                axis = walls.index(min(walls))
                place = [p + x * walls[axis] for p, x in zip(place, d)]
                if axis == 2 and d[2] > 0 and max(abs(place[0]), abs(place[1])) < hole:
                    break
                d[axis], place[axis] = -d[axis], 1.0 if d[axis] > 0 else -1.0
                times[axis] += 1
            else:
                continue
            if low <= sum(times) <= high and max(abs(place[0]), abs(place[1])) < 0.7 * hole:
                found.append((times, direction))
                break
    return found


def lights(c):
    why = "ρ/π · E with the irradiance by Lambert's contour integral in double precision."
    floor = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))
    for name, x in (("middle", 0.0), ("side", 0.25)):
        size = 2.0**-26 if x == 0 else 2.0**-24
        lamp = [((x, 0, 1), (x, size, 1), (x + size, 0, 1))]
        scene = c.obj(f"lamp_1e-8_{name}", ({"Kd": (0.5,) * 3}, floor), ({"Kd": (0, 0, 0), "Ke": (1e16,) * 3}, lamp))
        c.add(f"area-1e-8-{name}", f"A triangle of {size:.0e} units sends 1e16", scene, why,
              {"value": 0.5 / pi * irradiance(lamp, (0, 0, 0), (0, 0, 1), 1e16), "relative": 1e-3}, pencil((0.05, -0.1, 0.02), (0, 0, 0)),
              strategies=["light", "mis"], spp=256, max_depth=1)
    for gap in (1e-3, 1e-5):
        lamp = quad((-.5, -.5, gap), (-.5, .5, gap), (.5, .5, gap), (.5, -.5, gap))
        scene = c.obj(f"lamp_near_{gap:g}", ({"Kd": (0.5,) * 3}, floor), ({"Kd": (0, 0, 0), "Ke": (1,) * 3}, lamp))
        c.add(f"area-near-{gap:g}", f"A lamp {gap:g} over the floor that it lights", scene, why,
              {"value": 0.5 / pi * irradiance(lamp, (0.05, 0.02, 0), (0, 0, 1)), "relative": 1e-4},
              pencil((0.05 + 0.3 * gap, 0.02, 0.5 * gap), (0.05, 0.02, 0)), strategies=["bsdf", "light", "mis"], spp=256, max_depth=1)
    disc = lambda height, radius: (f"area_light {{ position = (3, 0, {height}); color = (0.6, 0.6, 0.6); constant_attenuation_coeff = 1; "
                                   f"linear_attenuation_coeff = 0; quadratic_attenuation_coeff = 0; light_radius = {radius}; }}")
    ground = ray_mesh(quad((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)), "diffuse = (0.5, 0.5, 0.5);")
    for name, height, radius in (("sunk", 0.4, 1.0), ("touching", 1.0, 1.0)):
        length = sqrt(9 + height**2)
        edge = height / sqrt(1 - (height / length) ** 2)
        share = 1.0 if edge >= radius else 1 - disc_beyond(edge, radius)
        c.add(f"area-light-{name}", f"A disc light of radius {radius} at height {height} over the floor", c.ray(f"area_light_{name}", disc(height, radius), ground),
              "k_d · color · cos θ of the centre · the share of the disc, which faces the point, above the floor.",
              {"value": 0.5 * 0.6 * height / length * share, "relative": 1e-4}, pencil((0.05, -0.1, 0.02), (0, 0, 0)), spp=256, strategies=["bsdf", "light", "mis"])
    white = {"triangles": FLAT, "material": lambert(0.5)}
    at = lambda x, y, z: [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]
    scene = c.gltf("lamp_on_surface", white, lights=[({"type": "point", "intensity": 1.0}, at(0.11, 0.23, 0))])
    c.add("light-in-the-surface", "A point light exactly at the point that it would light", scene, "It lies in the surface's plane: no light.",
          {"value": 0.0, "each_pixel": True, "absolute": 1e-3}, at_angle(40), spp=4)
    for name, spot, value in (("no-angle", {"innerConeAngle": 0, "outerConeAngle": 1e-9}, 0.0), ("no-penumbra", {"innerConeAngle": 0.5, "outerConeAngle": 0.5}, 0.5 / pi * 25),
                              ("hemisphere", {"innerConeAngle": 0, "outerConeAngle": pi / 2}, 0.5 / pi * 25)):
        scene = c.gltf(f"spot_{name}", white, lights=[({"type": "spot", "intensity": 100.0, "spot": spot}, at(0.11, 0.23, 2))])
        c.add(f"light-spot-{name}", f"Along the axis of a spot light with {name.replace('-', ' ')}", scene,
              "ρ/π · I/d² on the axis; a cone without angle, by the reference code of KHR_lights_punctual, is dark.",
              {"value": value, "each_pixel": True, "relative": 1e-4}, at_angle(40), spp=4)
    lamp = quad((-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1))
    mirrored = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    floor = quad((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0))
    scene = c.gltf("lamp_mirrored", {"triangles": floor, "material": lambert(0.5)},
                   {"triangles": lamp, "material": lambert(0.0, emission=3.0, double_sided=False), "matrix": mirrored})
    c.add("area-mirrored", "A one-sided area light under a reflecting transform", scene, why, 0.5 / pi * irradiance(lamp, (0, 0, 0), (0, 0, 1), 3.0),
          pencil((0.05, -0.1, 0.02), (0, 0, 0)), spp=1024, max_depth=1, strategies=["cosine", "bsdf", "light", "mis"])


def sheets(c):
    """Coverage in furnaces."""
    for mode, alpha in (("BLEND", 0.5), ("BLEND", 1e-7), ("MASK", 0.5)):
        body = material((1, 1, 1), alpha=alpha, alphaMode=mode, specular={"specularFactor": 0}, **({"alphaCutoff": 0.5} if mode == "MASK" else {}))
        scene = c.gltf(f"cutout_{mode.lower()}_{alpha:g}", {"triangles": icosphere(1), "material": body})
        c.add(f"furnace-{mode.lower()}-{alpha:g}", f"A white ball with {mode} and alpha {alpha:g}", scene, FURNACE + "White inside and outside, or not there.",
              {"value": 1.0, "relative": 1e-4}, {"eye": [0, 0, 4], "target": [0, 0, 0], "height": 1.8}, WHITE, strategies=BOTH, spp=64, max_depth=64)
    layers = [t for k in range(100) for t in quad((-1, -1, k / 100), (1, -1, k / 100), (1, 1, k / 100), (-1, 1, k / 100))]
    scene = c.gltf("hundred_sheets", {"triangles": layers, "material": material((0, 0, 0), alpha=0.01, alphaMode="BLEND", specular={"specularFactor": 0})})
    c.add("alpha-hundred-sheets", "A hundred black sheets of opacity 0.01", scene, "0.99^100 of the world behind.", 0.99**100,
          pencil((0.1, 0.2, 3), (0.11, 0.21, 0)), WHITE, strategies=["mis"], spp=4096)


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
    glasses(c)
    mirrors(c)
    lights(c)
    sheets(c)
    odds(c)
