"""Checks that need one certain remedy each: taken away, they fail (scripts/mutate_checks.py tries it)."""
from math import atan, cos, pi, radians, sin, sqrt, tan

from .geometry import SERIES, facing, scaled
from .forms import glowing_box, irradiance, solid_angle
from .surfaces import FLAT, FURNACE, WHITE, at_angle, pencil
from .writers import box, glass, lambert, material, png, quad

IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
UVS = [((0, 1), (1, 1), (1, 0)), ((0, 1), (1, 0), (0, 0))]
UP = [[(0, 0, 1)] * 3] * 2
ONE_PATH = {"strategies": ["bsdf", "mis"], "spp": 4}


def grid(count, low, high, z):
    """A square of small triangles, fronts upward."""
    at = lambda k: low + (high - low) * k / count
    return [t for i in range(count) for j in range(count)
            for t in quad((at(i), at(j), z), (at(i + 1), at(j), z), (at(i + 1), at(j + 1), z), (at(i), at(j + 1), z))]


def unit(v):
    length = sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def normals_from_behind(c):
    """Viewers below the horizon of a mapped normal, and faces seen at grazing angles."""
    for lean in (60, 85):
        n = (sin(radians(lean)), 0.0, cos(radians(lean)))
        texel = tuple(round((x + 1) / 2 * 255) for x in n)
        normal = unit([b / 255 * 2 - 1 for b in texel])
        viewer = (-cos(radians(30)), 0.0, sin(radians(30)))
        away = 0.02 - sum(a * b for a, b in zip(normal, viewer))
        bent = unit([a + away * b for a, b in zip(normal, viewer)])
        scene = c.gltf(f"lean_{lean}_lit", {"triangles": FLAT, "material": lambert(0.5, normalTexture={"index": 0}), "uvs": UVS,
                                            "normals": UP}, images=[png(1, 1, [[texel]])],
                       lights=[({"type": "directional", "intensity": 2.0}, IDENTITY)])
        c.add(f"normal-map-lean-{lean}-from-behind", f"A normal map that leans {lean}° away from the viewer, who is 30° above the surface",
              scene, "The viewer is below the mapped normal's horizon: it is bent towards him until its cosine is 0.02. ρ/π · E · cos "
              "with that normal, and light at right angles to the face.", {"value": 0.5 / pi * 2 * bent[2], "relative": 1e-4},
              pencil((0.1 + 3 * viewer[0], 0.2, 3 * viewer[2]), (0.1, 0.2, 0)), spp=4)
    for degrees in (89.9, 89.99):
        height = 3.11 * tan(radians(90 - degrees))
        strip = quad((-3, -1, 0.7 * height), (-3, 1, 0.7 * height), (-3, 1, 1.3 * height), (-3, -1, 1.3 * height))
        scene = c.gltf(f"mirror_strip_{degrees}", {"triangles": FLAT, "material": material(metallic=1, roughness=0)},
                       {"triangles": strip, "material": lambert(0.0, emission=1.0)})
        c.add(f"mirror-grazing-{degrees}", f"A mirror seen from {degrees}° shows a strip of light that is lower than a hair", scene,
              "The mirror image of the viewer's direction meets the strip in its middle; the metal is white.",
              {"value": 1.0, "each_pixel": True}, at_angle(degrees), **ONE_PATH)


def highlights(c):
    """The GGX distribution itself, by parallel light: nothing but D(h) tells how bright a nearly smooth metal's highlight is."""
    degrees = 40
    wo = (sin(radians(degrees)), 0.0, cos(radians(degrees)))
    for roughness in (0.032, 0.04, 0.1):
        alpha = roughness**2
        scene_of = lambda name, half: c.gltf(name, {"triangles": FLAT, "material": material(metallic=1, roughness=roughness)}, lights=[
            ({"type": "directional", "intensity": 1e-3}, facing(reflected(wo, half)))])
        for name, half in (("peak", (0.0, 0.0, 1.0)), ("side", (0.0, sin(atan(alpha)), cos(atan(alpha))))):
            wi = reflected(wo, half)
            a2 = alpha * alpha
            d = a2 / (pi * (a2 * half[2] ** 2 + half[0] ** 2 + half[1] ** 2) ** 2)
            stretched = lambda w: sqrt(w[2] ** 2 + a2 * (1 - w[2] ** 2))
            value = 1e-3 * d * 0.25 * 2 * wi[2] / (wo[2] * stretched(wi) + wi[2] * stretched(wo))
            c.add(f"highlight-{roughness}-{name}", f"The highlight of white metal of roughness {roughness}, {name}",
                  scene_of(f"highlight_{roughness}_{name}", half),
                  "E · D(h) G2 / (4 cos θo) with GGX in double precision; at the peak D is 1/(πα²), at the side, where tan θh = α, "
                  "about a quarter of that.", {"value": value, "relative": 2e-3},
                  pencil((0.11 + 3 * wo[0], 0.23, 3 * wo[2]), (0.11, 0.23, 0)), spp=4)


def reflected(wo, half):
    along = 2 * sum(a * b for a, b in zip(wo, half))
    return tuple(along * h - o for h, o in zip(half, wo))


def shadows(c):
    """What stops light right beside its source."""
    floor = grid(8, -4, 4, 0)
    for name, z, value in (("below", 0.999, 0.0), ("above", 1.001, 0.5 / pi * 100)):
        plate = {"triangles": grid(4, -1, 1, z), "material": lambert(0.0)}
        scene = c.gltf(f"lamp_plate_{name}", {"triangles": floor, "material": lambert(0.5)}, plate,
                       lights=[({"type": "point", "intensity": 100.0}, [*IDENTITY[:2], [0, 0, 1, 1], IDENTITY[3]])])
        c.add(f"shadow-beside-the-light-{name}", f"A plate a thousandth {name} a lamp at height 1", scene,
              "ρ/π · I / d², or exactly 0 where the plate is between floor and lamp.", {"value": value, "each_pixel": True},
              pencil((2, 0, 0.5), (0, 0, 0)), spp=4)


def flat_triangles(c):
    """Triangles without area through one point that the viewer looks at."""
    wall = grid(8, -2, 2, -1)
    star = []
    for i in range(-4, 5):
        for j in range(-4, 5):
            for k in range(-4, 5):
                if (i, j, k) > (0, 0, 0):
                    d = (i / 8, j / 8, k / 8)
                    star.append((tuple(-x for x in d), tuple(x / 2 for x in d), d))
    scene = c.gltf("flat_star", {"triangles": wall, "material": lambert(0.0, emission=1.0)}, {"triangles": star, "material": lambert(0.5)})
    c.add("mesh-flat-triangles", f"{len(star)} triangles without area, all through the point that is looked at", scene,
          "They cover nothing; behind them the wall sends 1.", {"value": 1.0, "each_pixel": True}, pencil((0.31, 0.17, 2.9), (0, 0, 0)),
          strategies=["mis"], spp=16)


def range_of_f32(c):
    """Sizes whose squares f32 does not hold."""
    half = lambert(0.5, emission=1.0, double_sided=False)
    for size in (1e-25, 1e25):
        scene = c.gltf(f"box_{size:g}_at_0", {"triangles": box(inward=True), "material": half, "matrix": scaled(size)})
        at = lambda p: [size * x for x in p]
        c.add(f"scale-{size:g}-at-0", f"A glowing box {size:g} large", scene, SERIES, glowing_box(1.0, 0.5, 8),
              {"eye": at((0.3, -0.2, 0.5)), "target": at((-1, 0.4, -0.8)), "vfov_deg": 70.0}, max_depth=8, spp=256,
              strategies=["bsdf", "light", "mis"])


def whole_paths(c):
    """Roulette that goes by what a path is worth outside: inside glass every path is worth 1 and none may end. (The index is high: roulette
    spares what carries more than a quarter.)"""
    pile = [t for k in range(8) for t in box((-1, -1, k / 2), (1, 1, k / 2 + .25))]
    scene = c.gltf("clear_pile", {"triangles": pile, "material": glass(2.5)})
    c.add("glass-pile-each-path", "Every path through a pile of eight clear slabs brings exactly the furnace's light", scene,
          FURNACE + "At normal incidence a path leaves the pile sooner or later, and none is cut short or made heavier.",
          {"value": 1.0, "each_pixel": True}, pencil((0.1, 0.2, 7), (0.1, 0.2, 0)), WHITE, strategies=["bsdf", "mis"], spp=64, max_depth=512)


def lamps_nearby(c):
    """Light samples alone, beside a lamp: noise that is bounded by the lamp's solid angle, and not by 1/distance."""
    floor, rho, spp = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)), 0.5, 64
    for height in (0.1, 0.02):
        lamp = [((-0.5, -0.5, height), (0, 0.5, height), (0.5, -0.5, height))]
        scene = c.obj(f"lamp_of_one_triangle_{height:g}", ({"Kd": (rho,) * 3}, floor), ({"Kd": (0, 0, 0), "Ke": (1,) * 3}, lamp))
        mean, most = rho / pi * irradiance(lamp, (0, 0, 0), (0, 0, 1)), rho / pi * solid_angle(lamp[0], (0, 0, 0))
        c.add(f"area-noise-{height:g}", f"Light samples of a lamp of one triangle, {height:g} over the floor that it lights", scene,
              "The mean is ρ/π · E (Lambert's contour integral). A sample that is uniform over the solid angle Ω brings ρ/π · L · Ω · cos θ, so none "
              "brings more than ρ L Ω/π; numbers between 0 and M with the mean m have a variance of at most m (M − m), and independent samples "
              f"the standard error √((M/m − 1)/n) for n = 8 · 8 · {spp}. Samples of the area have 1/distance in both.",
              [{"value": mean, "resolution": sqrt((most / mean - 1) / (64 * spp))}, {"value": most, "relation": "at-most", "each_pixel": True}],
              pencil((0.05, -0.1, 0.01), (0, 0, 0)), strategies=["light"], spp=spp, max_depth=1)


def write(c):
    lamps_nearby(c)
    normals_from_behind(c)
    highlights(c)
    shadows(c)
    flat_triangles(c)
    range_of_f32(c)
    whole_paths(c)
