"""Checks of light: form factors, punctual lights, shadows, environments."""
from math import cos, pi, radians, sin, sqrt

from .forms import clamped, disc_beyond, irradiance
from .surfaces import WHITE, pencil
from .writers import box, icosphere, lambert, material, quad, ray_mesh

FLOOR = quad((-90, -90, 0), (90, -90, 0), (90, 90, 0), (-90, 90, 0))
RHO = 0.5
LOOK = pencil((0.05, -0.1, 0.02), (0, 0, 0))
IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
FIND = ["cosine", "bsdf", "light", "mis"]


def moved(position, z_axis=(0, 0, 1)):
    """Matrix (rows) of a node at `position` whose +Z is one of the axes, so that its light travels the other way."""
    axes = {(0, 0, 1): ((1, 0, 0), (0, 1, 0)), (0, 0, -1): ((-1, 0, 0), (0, 1, 0)), (1, 0, 0): ((0, 1, 0), (0, 0, 1)),
            (-1, 0, 0): ((0, -1, 0), (0, 0, 1)), (0, 1, 0): ((0, 0, 1), (1, 0, 0)), (0, -1, 0): ((0, 0, -1), (1, 0, 0))}
    x, y = axes[z_axis]
    return [[x[k], y[k], z_axis[k], position[k]] for k in range(3)] + [[0, 0, 0, 1]]


def areas(c):
    why = ("ρ/π · E with the irradiance E of the light's triangles by Lambert's contour integral in double precision "
           "(irradiance in scripts/checks/forms.py).")

    def add(name, title, triangles, emission, strategies, **more):
        scene = c.obj(f"area_{name}", ({"Kd": (RHO,) * 3}, FLOOR), ({"Kd": (0, 0, 0), "Ke": (emission,) * 3}, triangles))
        value = RHO / pi * irradiance(triangles, (0, 0, 0), (0, 0, 1), emission)
        expect = {"value": value, **more.pop("expect", {})}
        c.add(f"area-{name}", title, scene, more.pop("why", why), expect, LOOK, strategies=strategies, **{"spp": 1024, "max_depth": 1, **more})

    down = lambda x, y, z, s: quad((x - s, y - s, z), (x - s, y + s, z), (x + s, y + s, z), (x + s, y - s, z))
    every = ["hemisphere", *FIND]
    add("parallel", "A square light overhead", down(0, 0, 1, 1), 3.0, every)
    add("parallel-off-centre", "A square light overhead and to the side", down(1.5, 0.7, 1, 0.8), 5.0, every)
    add("perpendicular", "A square light that stands on the floor", quad((1, -1, 0), (1, 1, 0), (1, 1, 2), (1, -1, 2)), 2.0, every)
    add("perpendicular-sunk", "A square light that goes through the floor", quad((1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)), 2.0, every, spp=2048)
    add("sphere", "A faceted sphere light", icosphere(2, (0.5, 0.3, 2), 0.5), 8.0, every, spp=2048)
    add("tiny", "A triangle of a millionth of a unit", [((0.25, 0, 1), (0.25, 2**-20, 1), (0.25 + 2**-20, 0, 1))], 1e13, ["light", "mis"])
    add("huge", "A triangle of ten thousand units a unit overhead", [((-9999, -9999, 1), (0, 19999, 1), (9999, -9999, 1))], 1.0,
        ["hemisphere", "cosine", "bsdf", "mis"], expect={"relative": 1e-4})
    add("needle", "A light a thousand times longer than wide", quad((-5, 0, 1), (-5, 0.01, 1), (5, 0.01, 1), (5, 0, 1)), 40.0,
        ["light", "mis"])
    dark = "Nothing of the light's front is above the horizon: exactly 0."
    zero = {"each_pixel": True}
    nearly = {"each_pixel": True, "absolute": 1e-6}
    add("edge-on", "A light whose plane holds the point", quad((0, 1, 1), (0, 2, 1), (0, 2, 2), (0, 1, 2)), 9.0, ["light", "mis"], why=dark + " But for the rounding of the point to f32.", expect=nearly)
    add("behind", "A light below the floor", down(0, 0, -1, 1), 9.0, every, why=dark, expect=zero)
    add("turned-away", "A light that shows its back", [t[::-1] for t in down(0, 0, 1, 1)], 9.0, every, why=dark, expect=zero)
    lamps = [({"Kd": (0, 0, 0), "Ke": (0, 0, 0)}, down(k % 10 - 4.5, k // 10 - 4.5, 2, 0.4)) for k in range(99)]
    bright = down(0.3, 0.2, 1, 0.3)
    scene = c.obj("area_dark_ones", ({"Kd": (RHO,) * 3}, FLOOR), ({"Kd": (0, 0, 0), "Ke": (7, 7, 7)}, bright), *lamps)
    c.add("area-zero-power", "One light among ninety-nine that are black", scene, why, RHO / pi * irradiance(bright, (0, 0, 0), (0, 0, 1), 7),
          LOOK, strategies=["light", "mis"], spp=256, max_depth=1)
    down_triangles = [t for x in range(-8, 8) for y in range(-8, 8) for t in down(x + 0.5, y + 0.5, 2, 0.2)]
    scene = c.obj("area_many", ({"Kd": (RHO,) * 3}, FLOOR), ({"Kd": (0, 0, 0), "Ke": (1e-3,) * 3}, down_triangles),
                  ({"Kd": (0, 0, 0), "Ke": (1e3,) * 3}, bright))
    c.add("area-one-in-a-million", "One light a million times brighter than 512 others", scene, why,
          RHO / pi * (irradiance(down_triangles, (0, 0, 0), (0, 0, 1), 1e-3) + irradiance(bright, (0, 0, 0), (0, 0, 1), 1e3)),
          LOOK, strategies=["light", "mis"], spp=512, max_depth=1)


def punctual(c):
    why = "ρ/π · I · cos θ · cone / d² (KHR_lights_punctual)."
    floor = {"triangles": FLOOR, "material": lambert(RHO)}

    def add(name, title, light, matrix, value, camera=LOOK, parts=(floor,), why=why, **more):
        light = {"intensity": 100.0, **light}
        c.add(f"light-{name}", title, c.gltf(f"light_{name}", *parts, lights=[(light, matrix)]), why, {"value": value, "each_pixel": True, **more}, camera, spp=4)

    point = lambda x, z: RHO / pi * 100 * z / (x * x + z * z) ** 1.5
    add("point", "A point light at an angle", {"type": "point"}, moved((30, 0, 40)), point(30, 40))
    add("point-near", "A point light 0.03 above", {"type": "point", "intensity": 0.01}, moved((0.04, 0, 0.03)), 1e-4 * point(0.04, 0.03),
        parts=({"triangles": quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)), "material": lambert(RHO)},))
    add("range", "A point light with a range", {"type": "point", "range": 80.0}, moved((30, 0, 40)),
        point(30, 40) * (1 - (50 / 80) ** 4), why=why + " The window is 1 − (d/range)⁴.")
    add("out-of-range", "Beyond a light's range", {"type": "point", "range": 49.0}, moved((30, 0, 40)), 0.0, why="0 from the range on.")
    spot = {"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 1.0}}
    cone = ((0.8 - cos(1.0)) / (cos(0.2) - cos(1.0))) ** 2
    add("spot", "In the penumbra of a spot light", spot, moved((30, 0, 40)), point(30, 40) * cone,
        why=why + " cone = ((cos − cos outer)/(cos inner − cos outer))².")
    add("spot-outside", "Outside a spot light's cone", {"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}},
        moved((30, 0, 40)), 0.0, why="0 beyond the outer angle: 36.9° are more than 34.4°.")
    for name, axis, plate in (("x", (1, 0, 0), quad((0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1))),
                              ("y", (0, 1, 0), quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1))),
                              ("z", (0, 0, 1), quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)))):
        for sign in (1, -1):
            z_axis = tuple(sign * x for x in axis)
            eye = tuple(3 * x + 0.3 for x in z_axis)
            add(f"directional-{'+' if sign > 0 else '-'}{name}", f"Parallel light exactly from {'+' if sign > 0 else '−'}{name}",
                {"type": "directional", "intensity": 2.0}, moved((0, 0, 0), z_axis), RHO / pi * 2, pencil(eye, (0, 0, 0)),
                ({"triangles": plate, "material": lambert(RHO)},), "ρ/π · E.")
    add("directional-grazing", "Parallel light along the surface", {"type": "directional"}, moved((0, 0, 0), (1, 0, 0)), 0.0, why="cos θ = 0.")
    add("zero", "A light of zero power", {"type": "point", "intensity": 0.0}, moved((0, 0, 4)), 0.0, why="0.")
    add("shadow-leak", "A light behind a wall of two triangles", {"type": "point"}, moved((0, 0, 4)), 0.0,
        parts=(floor, {"triangles": quad((-1, -1, 2), (1, -1, 2), (1, 1, 2), (-1, 1, 2)), "material": lambert(0.0)}),
        why="The shadow ray goes exactly through the edge that the wall's triangles share.")


def ray_lights(c):
    floor = ray_mesh(quad((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)), "diffuse = (0.5, 0.5, 0.5);")
    light = lambda word, position, color, abc, more="": (
        f"{word} {{ position = ({position[0]}, {position[1]}, {position[2]}); color = ({color}, {color}, {color}); "
        f"constant_attenuation_coeff = {abc[0]}; linear_attenuation_coeff = {abc[1]}; quadratic_attenuation_coeff = {abc[2]}; {more}}}")
    why = "k_d · color · cos θ · min(1, 1/(a + b·d + c·d²)), the rule of the .ray tracers."
    for name, abc in (("clamped", (0, 0, 0.01)), ("quadratic", (0.25, 0.1, 0.05)), ("constant", (2, 0, 0))):
        c.add(f"ray-light-{name}", f"Fall-off {abc} at distance 5", c.ray(f"falloff_{name}", light("point_light", (3, 0, 4), 0.6, abc), floor),
              why, {"value": 0.5 * 0.6 * 0.8 * clamped(*abc, 5), "each_pixel": True}, LOOK, spp=4)
    disc = light("area_light", (0, 0, 4), 0.6, (1, 0, 0), "light_radius = 0.5; ")
    for name, edge, share in (("half", 0.0, 0.5), ("part", 0.125, 1 - disc_beyond(0.25, 0.5)), ("all", -0.5, 0.0), ("none", 0.5, 1.0)):
        wall = ray_mesh(quad((edge, -9, 2), (9, -9, 2), (9, 9, 2), (edge, 9, 2)), "diffuse = (0, 0, 0);")
        c.add(f"penumbra-{name}", f"A disc light of which a wall leaves {share:.4g}", c.ray(f"penumbra_{name}", disc, floor, wall),
              "k_d · color · visible share of a disc of radius 0.5 at height 4 behind an edge at height 2: the share beyond a chord.",
              0.5 * 0.6 * share, LOOK, spp=256, strategies=["bsdf", "light", "mis"])
    lights, total = [], 0.0
    for k in range(1000):
        position = (k % 10 - 4.5, k // 10 % 10 - 4.5, 2 + k // 100 * 0.2)
        color = 1000.0 if k == 617 else 0.001
        lights.append(light("point_light", position, color, (0, 0, 1)))
        d = sqrt(sum(x * x for x in position))
        total += 0.5 * color * position[2] / d * clamped(0, 0, 1, d)
    c.add("light-one-in-a-thousand", "One light a million times brighter than 999 others", c.ray("thousand_lights", *lights, floor),
          "The sum of " + why, total, LOOK, spp=512, strategies=["bsdf", "mis"])


def environments(c):
    nothing = c.obj("speck", ({"Kd": (0, 0, 0)}, [((0, -50, 0), (0.001, -50, 0), (0, -50, 0.001))]))
    quarters = {"rows": [[list(map(float, t)) for t in ([3, 0, 0], [3, 0, 0], [0, 3, 0], [0, 3, 0], [0, 0, 3], [0, 0, 3], [1, 1, 1], [1, 1, 1])]] * 8}
    for name, degrees, value in (("red", -135, [3, 0, 0]), ("green", -45, [0, 3, 0]), ("blue", 45, [0, 0, 3]), ("white", 135, [1, 1, 1])):
        target = (cos(radians(degrees)), 0, sin(radians(degrees)))
        c.add(f"environment-{name}", f"A quarter of the horizon: {name}", nothing,
              "Quarters of an equirectangular picture; u = 0.5 + atan2(z, x)/2π, so the second quarter is around +X −Z.",
              {"value": value, "each_pixel": True}, pencil((0, 0, 0), target), quarters, spp=4)
    up = {"rows": [[[2.0, 2.0, 2.0]] * 16] * 8 + [[[0.0, 0.0, 0.0]] * 16] * 8}
    floor = c.obj("env_floor", ({"Kd": (RHO,) * 3}, quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1))))
    c.add("environment-lights-floor", "A bright upper half lights a floor", floor,
          "ρ/π ∫ L cos: rows are 11.25° high, the lowest bright one's centre is 5.625° up, and from there to the horizon "
          "interpolation takes the radiance linearly from 2 to 1 (environment_floor in scripts/checks/light.py).",
          RHO * environment_floor(), pencil((0.3, 2, 0.2), (0.1, 0, 0.2)), up, spp=1024)
    ground = {"triangles": quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)), "material": lambert(RHO)}
    pane = {"triangles": quad((-99, .5, -99), (-99, .5, 99), (99, .5, 99), (99, .5, -99)),
            "material": material((0.6,) * 3, roughness=0.0, specular={"specularFactor": 0}, transmission={"transmissionFactor": 1.0})}
    c.add("wall-before-environment", "The same floor under a pane that lets 0.6 through and reflects nothing", c.gltf("wall_env_floor", ground, pane),
          "0.6 times that of environment-lights-floor; 10⁻⁵ of it comes in below the pane's edges.", {"value": 0.6 * RHO * environment_floor(), "relative": 3e-5},
          pencil((0.3, 0.3, 0.2), (0.1, 0, 0.2)), up, strategies=["bsdf", "light", "mis"], spp=1024)
    c.add("bounce-from-an-edge", "Rays that leave the very edge between two triangles of a flat floor", floor,
          "ρ · 1 in a white world.", RHO, pencil((0.3, 2, 0.2), (0.1, 0, 0.1)), WHITE)


def environment_floor(nodes=20000):
    """(1/π)∫ L cos dω for radiance 2 above 5.625° and linear down to 1 at the horizon."""
    total = 0.0
    for k in range(nodes):
        elevation = (k + 0.5) / nodes * pi / 2
        radiance = min(2.0, 1.0 + elevation / radians(5.625))
        total += radiance * 2 * sin(elevation) * cos(elevation) * (pi / 2 / nodes)
    return total


def write(c):
    areas(c)
    punctual(c)
    ray_lights(c)
    environments(c)
