"""Checks at the ends of ranges: nearly white walls, grazing views, the thinnest and the finest, every direction of rays."""
from math import cos, pi, radians, sin

from .forms import glowing_box, irradiance
from .geometry import INSIDE, SERIES, facing, matte, scaled
from .surfaces import FLAT, FURNACE, WHITE, at_angle, pencil
from .writers import box, glass, icosphere, lambert, material, png, quad, ray_mesh

COMPENSATED = ("What one bounce among microfacets loses is made up for, by a table that is documented to be at most 0.005 too low "
               "and 0.01 too high.")
ONE_PATH = {"strategies": ["bsdf", "mis"], "spp": 4}


def white_walls(c):
    for albedo, depth, spp in ((0.999, 512, 256), (1.0, 64, 64)):
        scene = c.obj(f"box_{albedo}", (matte(albedo, 0.7), box(inward=True)))
        c.add(f"box-{albedo}", f"A glowing box of albedo {albedo}", scene, SERIES, glowing_box(0.7, albedo, depth), INSIDE,
              max_depth=depth, strategies=["bsdf", "mis"], spp=spp, width=4, height=4)
    corridor = quad((-0.5, -9, 0.5), (-0.5, 9, 0.5), (-0.5, 9, -64), (-0.5, -9, -64)) + quad(
        (0.5, -9, 0.5), (0.5, -9, -64), (0.5, 9, -64), (0.5, 9, 0.5))
    scene = c.gltf("corridor_64", {"triangles": corridor, "material": material((0.98,) * 3, metallic=1, roughness=0)})
    c.add("mirror-corridor-64", "Sixty-four reflections between metal mirrors of 0.98 at normal incidence", scene,
          "At 45° in a corridor 1 wide and 64 long: (0.98 + 0.02·(1 − cos 45°)⁵)^64 by Schlick, then the white world.",
          {"value": (0.98 + 0.02 * (1 - 0.5**0.5) ** 5) ** 64, "relative": 1e-4, "resolution": 0.05},
          pencil((0, 0.3, 0), (1, 0.3, -1)), WHITE, max_depth=128, spp=1024, strategies=["bsdf", "mis"])


def grazing(c):
    for degrees in (88, 89.9):
        for roughness in (0.1, 0.5, 1.0):
            scene = c.gltf(f"metal_{roughness}", {"triangles": FLAT, "material": material(metallic=1, roughness=roughness)})
            c.add(f"furnace-metal-{roughness}-at-{degrees}", f"White metal of roughness {roughness}, seen from {degrees}°", scene,
                  FURNACE + COMPENSATED, [{"value": 1.0, "relative": 0.005, "relation": "at-most", "resolution": 0.02},
                                          {"value": 1.0, "relative": 0.01, "relation": "at-least", "resolution": 0.02}],
                  at_angle(degrees), WHITE,
                  strategies=["bsdf", "mis"], spp=1024)
        scene = c.gltf("metal_0.0", {"triangles": FLAT, "material": material(metallic=1, roughness=0.0)})
        c.add(f"furnace-metal-0.0-at-{degrees}", f"A white mirror, seen from {degrees}°", scene, FURNACE + "A perfect mirror.", 1.0,
              at_angle(degrees), WHITE, **ONE_PATH)
        scene = c.gltf("plastic_0.3", {"triangles": FLAT, "material": material(roughness=0.3)})
        c.add(f"furnace-plastic-0.3-at-{degrees}", f"White plastic, seen from {degrees}°", scene, FURNACE + "Passive: at most 1, but for "
              "the table of the coat's albedo, which may be 0.005 too low.",
              {"value": 1.0, "relative": 0.005, "relation": "at-most", "resolution": 0.05}, at_angle(degrees), WHITE,
              strategies=["bsdf", "mis"], spp=256)


def mixtures(c):
    most = {"value": 1.0, "relative": 0.005, "relation": "at-most", "resolution": 0.05}
    for roughness in (0.05, 0.3, 1.0):
        wall = material(roughness=roughness, transmission={"transmissionFactor": 1})
        scene = c.gltf(f"thin_wall_{roughness}", {"triangles": FLAT, "material": wall})
        for degrees in (10, 75):
            c.add(f"furnace-rough-wall-{roughness}-at-{degrees}", f"A thin wall of roughness {roughness}, seen from {degrees}°", scene,
                  FURNACE + COMPENSATED, [most, {"value": 1.0, "relation": "at-least", "resolution": 0.05, "relative": 0.01}],
                  at_angle(degrees), WHITE,
                  strategies=["bsdf", "mis"], spp=256)
    for metallic, transmission, roughness in ((0.5, 0.0, 0.4), (0.5, 0.5, 0.4), (0.3, 0.7, 0.0), (0.0, 0.5, 1.0)):
        mixed = material(metallic=metallic, roughness=roughness, transmission={"transmissionFactor": transmission})
        name = f"metal-{metallic}-glass-{transmission}-rough-{roughness}"
        scene = c.gltf("mix_" + name, {"triangles": FLAT, "material": mixed})
        for degrees in (15, 80):
            c.add(f"furnace-{name}-at-{degrees}", f"A mixture of lobes, seen from {degrees}°", scene,
                  FURNACE + "Passive: at most 1, but for the table of the coat's albedo (0.005).",
                  [most, {"value": 0.6, "relation": "at-least", "resolution": 0.05}], at_angle(degrees), WHITE,
                  strategies=["bsdf", "mis"], spp=256)
    for index in (0.5, 0.9999999, 1.0000001, 3.0):
        body = ray_mesh(box(), f"transmissive = (1, 1, 1); index = {index!r};")
        c.add(f"furnace-ray-glass-{index}", f"A .ray body of index {index}", c.ray(f"glass_{index}", body),
              FURNACE + "Clear smooth glass absorbs nothing. What total reflection keeps inside for 128 bounces is lost: up to 0.3 %.",
              {"value": 1.0, "relative": 3e-3}, {"eye": [3, 2, 4], "target": [0, 0, 0], "height": 1.0}, WHITE,
              strategies=["bsdf", "mis"], max_depth=128, spp=256)
    scene = c.gltf("ior_0", {"triangles": FLAT, "material": material((0.3, 0.3, 0.3), roughness=0, ior={"ior": 0})})
    c.add("furnace-ior-0", "Index 0: a coat that reflects everything", scene,
          FURNACE + "KHR_materials_ior: 0 means that Fresnel's term is 1.", {"value": 1.0, "each_pixel": True}, at_angle(40), WHITE, **ONE_PATH)


def directions(c):
    """A closed box of many triangles, whose centre, edges and corners are at zero and at split planes."""
    walls = []
    for a, b, d in box(inward=True):
        for i in range(4):
            for j in range(4 - i):
                at = lambda p, q: tuple(x + (y - x) * p / 4 + (z - x) * q / 4 for x, y, z in zip(a, b, d))
                walls.append((at(i, j), at(i + 1, j), at(i, j + 1)))
                if i + j < 3:
                    walls.append((at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))
    scene = c.obj("box_of_many", (matte(0, 1), walls))
    names = {-1: "-", 0: "0", 1: "+"}
    for x in (-1, 0, 1):
        for y in (-1, 0, 1):
            for z in (-1, 0, 1):
                if (x, y, z) != (0, 0, 0):
                    up = (0.0, 0.0, 1.0) if z == 0 else (0.0, 1.0, 0.0) if y == 0 else (1.0, 0.0, 0.0) if x == 0 else (1.0, -1.0, 0.0)
                    c.add(f"ray-direction-{names[x]}{names[y]}{names[z]}", f"A ray along ({x}, {y}, {z}) through the corners of triangles",
                          scene, "The world behind is a million: the least crack shows.", {"value": 1.0, "each_pixel": True},
                          {"eye": [0, 0, 0], "target": [x, y, z], "up": up, "vfov_deg": 0.0}, 1e6, strategies=["mis"], spp=2,
                          width=1, height=1)


def shapes(c):
    """Quadrics of .ray files, from within and without, and far from their natural size."""
    light = "material = { diffuse = (1, 1, 1); }"
    for name in ("sphere", "cylinder", "cone", "box"):
        for size in (1.0, 1e-3, 1e6):
            block = f"scale({size!r}, {name} {{ {light} }})"
            value = {"value": 1.0, "each_pixel": True} if name in ("sphere", "box") else {"value": 1.0, "relation": "at-most"}
            c.add(f"shape-{name}-{size:g}", f"A white {name} of .ray, {size:g} large", c.ray(f"shape_{name}_{size:g}", block),
                  FURNACE + "ρ = 1." + ("" if "each_pixel" in value else " What is open or concave sees itself."), value,
                  {"eye": [3 * size, 2 * size, 4 * size], "target": [0, 0, 0], "height": 0.5 * size}, WHITE,
                  strategies=["bsdf", "mis"], spp=16, max_depth=64)


def thin(c):
    sheet = lambda z: quad((-1, -1, z), (1, -1, z), (1, 1, z), (-1, 1, z))
    for gap in (1e-2, 1e-4, 1e-6):
        front, back = {"Kd": (0, 0, 0), "Ke": (1, 0, 0)}, {"Kd": (0, 0, 0), "Ke": (0, 0, 1)}
        scene = c.obj(f"leaves_{gap}", (back, [t[::-1] for t in sheet(-gap)]), (front, sheet(0)))
        for name, z, value in (("front", 3, [1, 0, 0]), ("back", -3, [0, 0, 1])):
            c.add(f"thin-leaves-{gap}-{name}", f"Two leaves {gap} apart, from the {name}", scene, "Each side shows its own leaf.",
                  {"value": value, "each_pixel": True}, pencil((0.3, 0.2, z), (0.1, 0.2, 0)), strategies=["mis"], spp=16)
    dull, glow = {"Kd": (0.5,) * 3}, {"Kd": (0, 0, 0), "Ke": (1, 1, 1)}
    scene = c.obj("decal", (glow, sheet(0)), (dull, quad((-.5, -.5, 0), (.5, -.5, 0), (.5, .5, 0), (-.5, .5, 0))))
    c.add("coincident-surfaces", "A decal in the plane of a surface that comes first in the file", scene,
          "Of surfaces at the same distance the first in the file is seen, in every pixel alike.", {"value": 1.0, "each_pixel": True},
          {"eye": [0.3, 0.2, 3], "target": [0.1, 0, 0], "height": 0.8}, strategies=["mis"], spp=16)
    # Occlusion right above the ground: a plate that floats over a floor at a millionth of its size.
    floor, plate = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)), quad((-.25, -.25, 1e-5), (.25, -.25, 1e-5), (.25, .25, 1e-5), (-.25, .25, 1e-5))
    scene = c.gltf("contact", {"triangles": floor, "material": lambert(1.0, double_sided=False)},
                   {"triangles": [t[::-1] for t in plate], "material": lambert(0.0, double_sided=False)},
                   lights=[({"type": "directional", "intensity": 3.0}, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])])
    c.add("contact-shadow", "The shadow of a plate that floats 0.00001 over a floor 2 wide", scene,
          "The camera does not see the plate's back, but the light does: exactly 0 under it.", {"value": 0.0, "each_pixel": True},
          {"eye": [0, 0, 3], "target": [0, 0, 0], "height": 0.4}, max_depth=1, spp=16)


def touching(c):
    """Light that touches the surface that it lights, close to the line of contact."""
    rho, glow = 0.5, 2.0
    panel = quad((0, -1, 0), (0, 1, 0), (0, 1, 2), (0, -1, 2))
    panel = [t[::-1] for t in panel]
    floor = quad((-90, -90, 0), (90, -90, 0), (90, 90, 0), (-90, 90, 0))
    scene = c.obj("touching", ({"Kd": (rho,) * 3}, floor), ({"Kd": (0, 0, 0), "Ke": (glow,) * 3}, panel))
    for distance in (1e-1, 1e-3, 1e-5):
        lit = [panel, [t[::-1] for t in panel]]
        value = rho / pi * max(irradiance(t, (-distance, 0.1, 0), (0, 0, 1), glow) for t in lit)
        c.add(f"area-touching-{distance:g}", f"A panel that stands on the floor, {distance:g} from their line of contact", scene,
              "ρ/π · E by Lambert's contour integral in double precision.", {"value": value, "relative": 1e-4},
              pencil((-distance - 1, 0.1, 2), (-distance, 0.1, 0)), strategies=["cosine", "bsdf", "mis"], spp=1024, max_depth=1)


def maps(c):
    """Normal maps that lean, seen from the side."""
    uvs = [((0, 1), (1, 1), (1, 0)), ((0, 1), (1, 0), (0, 0))]
    for lean in (30, 60, 85):
        n = (sin(radians(lean)), 0.0, cos(radians(lean)))
        texel = tuple(round((x + 1) / 2 * 255) for x in n)
        decoded = [b / 255 * 2 - 1 for b in texel]
        length = sum(x * x for x in decoded) ** 0.5
        to_light = (0.0, 0.0, 1.0)
        scene = c.gltf(f"lean_{lean}", {"triangles": FLAT, "material": lambert(0.5, normalTexture={"index": 0}), "uvs": uvs,
                                        "normals": [[(0, 0, 1)] * 3] * 2}, images=[png(1, 1, [[texel]])],
                       lights=[({"type": "directional", "intensity": 2.0}, facing(to_light))])
        c.add(f"normal-map-lean-{lean}", f"A normal map that leans {lean}°, lit from above", scene,
              "ρ/π · E · cos, with the normal of the 8-bit texel.", {"value": 0.5 / pi * 2 * decoded[2] / length, "relative": 1e-4},
              pencil((2.9, 0.2, 1), (0.1, 0.2, 0)), spp=4)
        glossy = material(metallic=1, roughness=0.2, normalTexture={"index": 0})
        scene = c.gltf(f"lean_{lean}_metal", {"triangles": FLAT, "material": glossy, "uvs": uvs, "normals": [[(0, 0, 1)] * 3] * 2},
                       images=[png(1, 1, [[texel]])])
        for side, x in (("towards", 1), ("away", -1)):
            c.add(f"normal-map-lean-{lean}-grazing-{side}", f"Metal under a normal map that leans {lean}°, seen at 2° above the surface",
                  scene, "Passive: at most 1 in a white world (the table of multiple scattering may be 0.005 too low), and finite.",
                  {"value": 1.0, "relation": "at-most", "relative": 0.005, "resolution": 0.2},
                  pencil((0.1 + 3 * x * cos(radians(2)), 0.2, 3 * sin(radians(2))), (0.1, 0.2, 0)), WHITE, strategies=["bsdf", "mis"], spp=64)


def stretched_normals(c):
    """A smooth sphere under a transform that flattens it: normals go by the inverse transpose."""
    sphere = icosphere(2)
    squeeze = (1.0, 2.0, 0.25)
    weights = (0.5, 0.3, 0.2)
    face = max(sphere, key=lambda t: min(p[2] + 0.5 * p[0] for p in t))
    point = tuple(sum(w * p[k] for w, p in zip(weights, face)) for k in range(3))
    normal = tuple(x / s for x, s in zip(point, squeeze))
    normal = tuple(x / sum(y * y for y in normal) ** 0.5 for x in normal)
    at = tuple(x * s for x, s in zip(point, squeeze))
    to_light = (0.6, 0.0, 0.8)
    matrix = [[squeeze[r] if r == k else 0 for k in range(4)] if r < 3 else [0, 0, 0, 1] for r in range(4)]
    scene = c.gltf("squeezed", {"triangles": sphere, "normals": sphere, "material": lambert(0.5), "matrix": matrix},
                   lights=[({"type": "directional", "intensity": 2.0}, facing(to_light))])
    c.add("normals-squeezed", "Smooth normals under a transform that is not uniform", scene,
          "ρ/π · E · cos with the normal by the inverse transpose of the transform.",
          {"value": 0.5 / pi * 2 * sum(a * b for a, b in zip(normal, to_light)), "relative": 1e-4, "each_pixel": True},
          pencil([a + 3 * n for a, n in zip(at, normal)], at), spp=4)


def sums(c):
    nothing = "speck.obj"
    c.add("film-sum", "65536 samples of a tenth", f"{nothing}", "The mean of equal numbers is that number: sums in f32 would drift by 1e-4.",
          {"value": 0.10000000149011612, "each_pixel": True, "relative": 1e-9}, pencil((0, 0, 0), (1, 0, 0)), 0.1,
          strategies=["mis"], spp=65536, width=1, height=1)


def write(c):
    white_walls(c)
    grazing(c)
    mixtures(c)
    directions(c)
    shapes(c)
    thin(c)
    touching(c)
    maps(c)
    stretched_normals(c)
    sums(c)
