"""Glass, mirrors, lamps and sheets as a stranger would put them together to break a renderer."""
from math import cos, pi, sin, sqrt

from .forms import disc_beyond, irradiance, layers
from .outside import BOTH, OBLIQUE
from .remedies import unit
from .surfaces import FLAT, FURNACE, WHITE, at_angle, pencil
from .writers import box, glass, icosphere, lambert, material, quad, ray_mesh

THROUGH = FURNACE + "Clear smooth glass absorbs nothing."


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
              pencil((0.05 + 0.3 * gap, 0.02, 0.5 * gap), (0.05, 0.02, 0)), strategies=["bsdf", "mis"], spp=256, max_depth=1)
    turned = icosphere(1, (0, 0, 0), 1.0)
    scene = c.obj("lamp_backs", ({"Kd": (0.5,) * 3, "Ke": (4,) * 3}, turned))
    c.add("area-back-of-a-lamp", "The backs of slanting lamps that glow on their other side", scene,
          "A closed body of one-sided lamps, seen from within by a camera in it: nothing glows inward, and nothing of the outside gets "
          "in, but for the rounding of points to f32 of the lamp that they are on.", {"value": 0.0, "each_pixel": True, "absolute": 1e-3}, {"eye": [0.1, 0.2, 0.3], "target": [1, 0.3, -0.4], "vfov_deg": 60.0}, strategies=["bsdf", "light", "mis"], spp=64)
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


def write(c):
    glasses(c)
    mirrors(c)
    lights(c)
    sheets(c)
