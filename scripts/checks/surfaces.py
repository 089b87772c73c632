"""Checks of materials: furnaces, glass, mirrors, coverage, textures."""
from math import cos, pi, radians, sin, tan

from .forms import compensated_furnace, dispersing_prism, irradiance, layers, linear_of_srgb, slab
from .writers import box, glass, icosphere, lambert, material, png, quad, ray_mesh

FLAT = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))
WHITE = 1.0


def pencil(eye, target, **more):
    """Every sample follows the same ray."""
    return {"eye": list(eye), "target": list(target), "vfov_deg": 0.0, **more}


def at_angle(degrees):
    """A pencil onto FLAT, `degrees` from its normal."""
    return pencil((0.11 + 3 * sin(radians(degrees)), 0.23, 3 * cos(radians(degrees))), (0.11, 0.23, 0))


FURNACE = "White furnace: the environment sends 1 from everywhere and a convex body sees nothing else. "
MATTE = "A Lambert surface reflects albedo · 1."


def furnaces(c):
    for albedo in (0.0, 0.5, 1.0):
        scene = c.obj(f"cube_{albedo}", ({"Kd": (albedo,) * 3}, box()))
        c.add(f"furnace-lambert-{albedo}", f"A Lambert cube of albedo {albedo} in a white furnace", scene,
              FURNACE + MATTE, albedo, {"eye": [5, 4, 3], "target": [0, 0, 0], "height": 1.0}, WHITE)
    scene = c.obj("sphere_faceted", ({"Kd": (0.8, 0.4, 0.1)}, icosphere(2)))
    c.add("furnace-lambert-sphere", "A faceted, coloured Lambert sphere in a white furnace", scene, FURNACE + MATTE,
          [0.8, 0.4, 0.1], {"eye": [0, 0, 4], "target": [0, 0, 0], "height": 1.0}, WHITE)
    for degrees, roughnesses in ((30, (0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 1.0)), (80, (0.0, 0.1, 0.3, 0.5, 1.0))):
        for roughness in roughnesses:
            scene = c.gltf(f"metal_{roughness}", {"triangles": FLAT, "material": material(metallic=1, roughness=roughness)})
            alpha = roughness**2
            smooth = alpha < 1e-3
            why = ("A perfect mirror (α below 0.001 is one)." if smooth else
                   f"GGX, α = {alpha:g}, {degrees}° from the normal, F = 1: what one bounce loses is made up for, by a table "
                   "that is documented to be at most 0.005 too low and 0.01 too high.")
            expect = ({"value": 1.0, "relative": 1e-5} if smooth else
                      [{"value": 1.0, "relative": 0.005, "relation": "at-most"},
                       {"value": 1.0, "relative": 0.01, "relation": "at-least"}])
            strategies = ["hemisphere", "cosine", "bsdf", "light", "mis"] if roughness >= 0.5 else ["bsdf", "mis"]
            c.add(f"furnace-metal-{roughness}-at-{degrees}", f"White metal of roughness {roughness}, seen from {degrees}°",
                  scene, FURNACE + why, expect, at_angle(degrees), WHITE,
                  strategies=strategies,
                  # The little that a nearly smooth metal loses is lost by few samples, whose spread must be seen.
                  spp=4096 if roughness == 0.1 else 1024 if len(strategies) > 2 else 64)
    gold = [1.0, 0.7, 0.3]
    scene = c.gltf("gold", {"triangles": FLAT, "material": material(gold, metallic=1, roughness=0.6)})
    c.add("furnace-gold", "Coloured metal of roughness 0.6, seen from 60°", scene,
          FURNACE + "∫ f cos with Schlick's F = F0 + (1 − F0)(1 − cos)⁵ in double precision, scaled for multiple scattering "
          "(compensated_furnace in scripts/checks/forms.py); the renderer's table may be off by 0.01.",
          {"value": [compensated_furnace(0.36, 60, f0) for f0 in gold], "relative": 0.01}, at_angle(60), WHITE, spp=256)
    for roughness in (0.0, 0.3, 0.6, 1.0):
        scene = c.gltf(f"plastic_{roughness}", {"triangles": FLAT, "material": material(roughness=roughness)})
        for degrees in (20, 75):
            c.add(f"furnace-plastic-{roughness}-at-{degrees}", f"White plastic of roughness {roughness} from {degrees}°", scene,
                  FURNACE + "Energy-conserving layering: white base under a coat gives back everything; the coat's albedo "
                  "comes from a table that is documented to be at most 0.005 too low and 0.01 too high.",
                  [{"value": 1.0, "relative": 0.005, "relation": "at-most"},
                   {"value": 1.0, "relative": 0.01, "relation": "at-least"}], at_angle(degrees), WHITE,
                  strategies=["cosine", "bsdf", "light", "mis"] if roughness > 0.5 else ["bsdf", "mis"], spp=256)


def layers_of_gltf(c):
    """Each extension that puts a layer on or into a white surface."""
    conserves = "What a layer reflects to the viewer is taken from what lies below it, so that nothing is gained"
    sand = {"diffuseRoughnessFactor": 1.0}
    cases = [
        # name, title, bounds, derivation, material
        ("clearcoat-smooth", "white plastic under a polished coat", 0.99, 1.005, " and hardly anything lost.",
         dict(roughness=0.5, clearcoat={"clearcoatFactor": 1})),
        ("clearcoat-rough", "white metal under a rough coat", 0.99, 1.005, " and hardly anything lost.",
         dict(metallic=1, roughness=0.5, clearcoat={"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.5})),
        ("sheen", "white cloth with white sheen", 0.98, 1.01, "; the table of sheen is right to 0.01.",
         dict(sheen={"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.5})),
        ("iridescence", "white plastic with a thin film", 0.85, 1.02,
         "; a film takes the most that any channel reflects from all.",
         dict(roughness=0.4, iridescence={"iridescenceFactor": 1, "iridescenceThicknessMaximum": 380})),
        ("diffuse-transmission", "a white leaf", 0.99, 1.005, " and hardly anything lost, on whichever side.",
         dict(roughness=0.6, diffuse_transmission={"diffuseTransmissionFactor": 0.5})),
        ("diffuse-roughness", "white sandstone", 0.985, 1.005, "; EON's polynomial is right to 0.001.",
         dict(roughness=0.6, diffuse_roughness=sand)),
    ]
    for name, title, least, most, rest, parameters in cases:
        scene = c.gltf(name.replace("-", "_"), {"triangles": FLAT, "material": material(**parameters)})
        for degrees in (20, 70):
            c.add(f"furnace-{name}-at-{degrees}", f"{title[0].upper()}{title[1:]}, seen from {degrees}°", scene,
                  FURNACE + conserves + rest, [{"value": most, "relation": "at-most"}, {"value": least, "relation": "at-least"}],
                  at_angle(degrees), WHITE, strategies=["bsdf", "mis"], spp=512)
    green = [0.2, 0.9, 0.4]
    leaf = material((0, 0, 0), specular={"specularFactor": 0},
                    diffuse_transmission={"diffuseTransmissionFactor": 0.5, "diffuseTransmissionColorFactor": green})
    c.add("diffuse-transmission-colour", "A black leaf lets half of what comes from behind through, green",
          c.gltf("leaf", {"triangles": FLAT, "material": leaf}),
          "The environment is white at z < 0, black at z > 0: half of 1, times the colour; the border between is soft, which "
          "takes a little over 1 %.", {"value": [0.5 * x for x in green], "relative": 0.02},
          at_angle(30), {"rows": [[[1, 1, 1]] * 4 + [[0, 0, 0]] * 4] * 4}, strategies=["bsdf", "mis"], spp=512)


def clear_glass(c):
    through = FURNACE + "Clear smooth glass absorbs nothing: every path leads to the environment with weight 1."
    both = ["bsdf", "light", "mis"]
    above = {"eye": [0.3, 0.2, 4], "target": [0, 0, 0], "height": 1.6}
    oblique = {"eye": [3, 2, 4], "target": [0, 0, 0], "height": 1.0}
    sphere = icosphere(2)
    for ior in (1.0, 1.0000001, 1.5, 2.4):
        scene = c.gltf(f"glass_sphere_{ior}", {"triangles": sphere, "material": glass(ior)})
        c.add(f"furnace-glass-sphere-{ior}", f"A faceted glass sphere of index {ior}", scene,
              through + " Up to 0.2 % may be caught inside by total reflection for more than 256 bounces.",
              {"value": 1.0, "relative": 2e-3}, above, WHITE, strategies=both, max_depth=256, spp=256)
        scene = c.gltf(f"glass_box_{ior}", {"triangles": box(), "material": glass(ior)})
        c.add(f"furnace-glass-box-{ior}", f"A glass box of index {ior}", scene, through, 1.0, oblique, WHITE,
              strategies=both, max_depth=128, spp=256)
    for index in (0.8, 1.3):
        body = ray_mesh(box(), f"transmissive = (1, 1, 1); index = {index};")
        c.add(f"furnace-ray-glass-{index}", f"A .ray body of index {index}", c.ray(f"glass_{index}", body), through, 1.0,
              oblique, WHITE, strategies=both, max_depth=128, spp=256)
    mirrored = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    scene = c.gltf("glass_mirrored", {"triangles": box(), "material": glass(1.5), "matrix": mirrored})
    c.add("furnace-glass-box-mirrored", "A glass box under a reflecting transform", scene, through, 1.0, oblique, WHITE,
          strategies=both, max_depth=128, spp=256)
    scene = c.gltf("glass_nested", {"triangles": box(), "material": glass(1.5)},
                   {"triangles": box((-.5,) * 3, (.5,) * 3), "material": glass(1.5)})
    c.add("furnace-glass-nested", "A glass box in a glass box", scene, through, 1.0, oblique, WHITE, strategies=both,
          max_depth=128, spp=256)
    scene = c.gltf("thin_wall", {"triangles": FLAT, "material": material(roughness=0, transmission={"transmissionFactor": 1})})
    for degrees in (0, 60, 85):
        c.add(f"furnace-thin-wall-at-{degrees}", f"A clear thin wall, seen from {degrees}°", scene,
              FURNACE + "What is not reflected goes straight through.", 1.0, at_angle(degrees), WHITE, strategies=both)
    for roughness in (0.3, 1.0):
        scene = c.gltf(f"glass_rough_{roughness}", {"triangles": box(), "material": glass(1.5, roughness)})
        c.add(f"furnace-rough-glass-{roughness}", f"A box of rough glass, roughness {roughness}, neither makes nor loses light", scene,
              FURNACE + "What one encounter with a microfacet loses is made up for by a table that is at most 0.005 too low and "
              "0.05 too high, at each of a few encounters.",
              [{"value": 1.0, "relation": "at-most", "resolution": 0.05},
               {"value": 1.0, "relation": "at-least", "relative": 0.07, "resolution": 0.05}], oblique, WHITE,
              strategies=["bsdf", "mis"], max_depth=64, spp=128)


def inside_glass(c):
    box_15 = c.gltf("glass_box_1.5_inside", {"triangles": box(), "material": glass(1.5)})
    c.add("inside-glass", "The camera inside a glass box", box_15,
          "In equilibrium with a white world radiance in glass is n² = 2.25: what the camera sees through a face.",
          2.25, pencil((0.1, 0.2, 0.3), (0.15, 0.1, -1)), WHITE, strategies=["bsdf", "mis"], max_depth=128, spp=256)
    columns = [[0, 0, 0]] * 4 + [[1, 1, 1]] * 4
    half = {"rows": [columns] * 4}
    top, bottom = [(-1, 1, 0), (1, 1, 0), (0, 1, -1)], [(-1, -1, 0), (0, -1, -1), (1, -1, 0)]
    (a, b, d), (e, g, f) = top, bottom
    prism = [tuple(top), tuple(bottom), *quad(e, f, b, a), *quad(f, g, d, b), *quad(g, e, a, d)]
    scene = c.gltf("prism", {"triangles": prism, "material": glass(1.5)})
    c.add("total-reflection-prism", "A right-angled prism sends light back", scene,
          "The environment is white at z > 0, black at z < 0. Light into the long face meets the short ones at 45°, beyond "
          "the critical angle of 41.8°: all of it, and all that the long face reflects, returns to z > 0.",
          1.0, pencil((0.3, 0.1, 5), (0.3, 0.1, 0)), half, strategies=["bsdf", "light", "mis"], spp=256, max_depth=64)
    run = 2 * tan(radians(41))
    (a, b, d), (e, f, g) = [[(-1, y, 0), (1, y, 0), (-1, y, -run)] for y in (1, -1)]
    wedge = [(a, b, d), (e, g, f), *quad(e, f, b, a), *quad(f, g, d, b), *quad(g, e, a, d)]
    scene = c.gltf("prism_dispersing", {"triangles": wedge, "material": glass(1.5, dispersion={"dispersion": 5})})
    c.add("dispersion-prism", "A prism lets red through where it reflects blue", scene,
          "Light into the front face meets the second one at 41°, beyond the critical angle of indices above 1.524: the integral "
          "over the wavelengths of F₁ + (1 − F₁)(1 − F₂), each weighted as in linear sRGB; two scatterings.",
          [round(x, 5) for x in dispersing_prism(41, 1.5, 5)], pencil((0.5, 0.1, 5), (0.5, 0.1, 0)), WHITE,
          strategies=["bsdf", "light", "mis"], spp=8192, max_depth=2)
    c.add("dispersion-white", "All that a dispersing prism reflects and lets through is white again", scene,
          "Every wavelength finds its way out into the white world.", 1.0, pencil((0.5, 0.1, 5), (0.5, 0.1, 0)), WHITE,
          strategies=["bsdf", "light", "mis"], spp=1024, max_depth=64)
    tint = [0.25, 0.5, 0.75]
    low, high = (-1, -1, -0.25), (1, 1, 0.25)
    straight = pencil((0.1, 0.2, 3), (0.1, 0.2, 0))
    scene = c.gltf("absorbing_1", {"triangles": box(low, high), "material": glass(1.0, attenuation=tint)})
    c.add("absorption-straight", "A slab of index 1 absorbs by Beer and Lambert", scene,
          "Half a unit of what lets through c per unit: √c.", [t**0.5 for t in tint], straight, WHITE)
    scene = c.gltf("absorbing_1.5", {"triangles": box(low, high), "material": glass(1.5, attenuation=tint)})
    c.add("absorption-slab", "An absorbing slab of index 1.5 at normal incidence", scene,
          "R + T²a/(1 − Ra) with R = ((n − 1)/(n + 1))² = 0.04, T = 1 − R and a = √c: the sum over all inner reflections.",
          [slab(0.04, t**0.5) for t in tint], straight, WHITE, spp=256, max_depth=32)
    scene = c.gltf("absorbing_nested", {"triangles": box(low, high), "material": glass(1.0, attenuation=tint)},
                   {"triangles": box((-.5, -.5, -.125), (.5, .5, .125)), "material": glass(1.0, attenuation=tint[::-1])})
    c.add("absorption-nested", "An absorbing slab within another", scene,
          "A quarter unit of the outer and a quarter of the inner body: c_outer^¼ · c_inner^¼.",
          [(s * t) ** 0.25 for s, t in zip(tint, tint[::-1])], straight, WHITE)
    second, third = tint[::-1], [0.6, 0.3, 0.9]
    slab_of = lambda z, colour, ior=1.0: {"triangles": box((-1, -1, z[0]), (1, 1, z[1])), "material": glass(ior, attenuation=colour)}
    scene = c.gltf("absorbing_in_three", slab_of((-.5, .5), tint), slab_of((-.3, .3), second), slab_of((-.1, .1), third))
    c.add("absorption-nested-in-three", "A body in a body in a body", scene, "0.4 units of the outer, 0.4 of the second, 0.2 of the third.",
          [(a * b) ** 0.4 * d**0.2 for a, b, d in zip(tint, second, third)], straight, WHITE)
    scene = c.gltf("absorbing_overlap", slab_of((-.2, 1), tint), slab_of((-1, .2), second))
    c.add("absorption-overlap", "Two bodies that overlap: the one entered last counts", scene,
          "0.8 units of the first body, then 1.2 of the second.", [a**0.8 * b**1.2 for a, b in zip(tint, second)], straight, WHITE)
    scene = c.gltf("nested_same", slab_of((-.5, .5), tint, 1.5), slab_of((-.25, .25), second, 1.5))
    c.add("nested-same-index", "Glass in glass of the same index has no surface of its own", scene,
          "A slab of index 1.5 whose half unit each of two colours takes √c₁·√c₂: R + T²a/(1 − Ra), R = 0.04.",
          [slab(0.04, (a * b) ** 0.5) for a, b in zip(tint, second)], straight, WHITE, spp=1024, max_depth=32)
    water = [slab_of((-.5, .5), tint, 1.5), slab_of((-.25, .25), second, 1.33)]
    takes = lambda k: [tint[k] ** 0.25, second[k] ** 0.5, tint[k] ** 0.25]
    c.add("nested-liquid", "Water in glass", c.gltf("nested_liquid", *water),
          "At the inner faces the index counts relative to the glass, 1.33/1.5: the plates are added one by one "
          "(layers in scripts/checks/forms.py).", [layers([1, 1.5, 1.33, 1.5, 1], takes(k)) for k in range(3)], straight, WHITE,
          spp=1024, max_depth=64, strategies=["bsdf", "light", "mis"])
    filled = [slab_of((.2, .5), tint, 1.5), slab_of((-.5, .25), second, 1.33)]
    c.add("nested-overlap", "Water that reaches a little into the glass before it", c.gltf("nested_overlap", *filled),
          "One boundary between glass and water, where the water is entered; the end of the glass within it is none.",
          [layers([1, 1.5, 1.33, 1], [a**0.25, b**0.75]) for a, b in zip(tint, second)], straight, WHITE,
          spp=1024, max_depth=64, strategies=["bsdf", "light", "mis"])
    body = ray_mesh(box(low, high), "transmissive = (0.25, 0.5, 0.75); index = 1;")
    c.add("absorption-ray", "A .ray body lets k_t through per unit", c.ray("absorbing", body), "k_t^0.5.",
          [t**0.5 for t in tint], straight, WHITE)
    for size in (1e-6, 1e6):
        matrix = [[size, 0, 0, 0], [0, size, 0, 0], [0, 0, size, 0], [0, 0, 0, 1]]
        scene = c.gltf(f"absorbing_{size:g}", {"triangles": box(low, high), "matrix": matrix,
                                               "material": glass(1.0, attenuation=tint) })
        thick = 0.5 * size
        value = [t**thick for t in tint]
        c.add(f"absorption-scale-{size:g}", f"Absorption counts world units: a slab of {thick:g}", scene, "c^thickness.",
              {"value": value, "absolute": 1e-6}, pencil([size * x for x in (0.1, 0.2, 3)], [size * x for x in (0.1, 0.2, 0)]), WHITE)


def mirrors(c):
    corridor = [*quad((.5, -9, 0), (.5, -9, -20), (.5, 9, -20), (.5, 9, 0))[::-1],
                *quad((-.5, -9, 0), (-.5, -9, -20), (-.5, 9, -20), (-.5, 9, 0))]
    for share in (0.8, 0.9, 0.99):
        scene = c.ray(f"corridor_{share}", ray_mesh(corridor, f"reflective = ({share}, {share}, {share});"))
        c.add(f"mirror-corridor-{share}", f"Twenty reflections between mirrors of {share}", scene,
              "At 45° in a corridor 1 wide and 20 long the ray meets a mirror at z = −0.5, −1.5 … −19.5, then the white world.",
              {"value": share**20, "resolution": 0.05}, pencil((0, 0.3, 0), (1, 0.3, -1)), WHITE, max_depth=32, spp=1024,
              strategies=["bsdf", "mis"])


def coverage(c):
    sheet = lambda z: quad((-1, -1, z), (1, -1, z), (1, 1, z), (-1, 1, z))
    front = pencil((0.1, 0.2, 3), (0.1, 0.2, 0))
    glow = {"Kd": (0, 0, 0), "Ke": (1, 2, 3), "d": 0.25}
    c.add("alpha-blend", "A glowing sheet of opacity 0.25", c.obj("blend", (glow, sheet(0))),
          "0.25 · Le + 0.75 · environment.", [0.25 * e + 0.75 * 4 for e in (1, 2, 3)], front, 4.0, spp=1024)
    c.add("alpha-blend-twice", "Two sheets of opacity 0.25", c.obj("blend_twice", (glow, sheet(0)), (glow, sheet(-0.5))),
          "0.25 · Le + 0.75 · 0.25 · Le + 0.75² · environment.",
          [e * (0.25 + 0.1875) + 0.5625 * 4 for e in (1, 2, 3)], front, 4.0, spp=1024)
    for alpha, shown in ((0.6, 2.0), (0.4, 5.0)):
        masked = material(alpha=alpha, alphaMode="MASK", alphaCutoff=0.5, emission=2.0, specular={"specularFactor": 0}, color=(0, 0, 0))
        c.add(f"alpha-mask-{alpha}", f"A mask of alpha {alpha} with cutoff 0.5", c.gltf(f"mask_{alpha}", {"triangles": sheet(0), "material": masked}),
              "Whole from the cutoff on, else not there.", {"value": shown, "each_pixel": True}, front, 5.0)
    floor, shade = quad((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)), quad((-3, -3, 1), (3, -3, 1), (3, 3, 1), (-3, 3, 1))
    lit = {"name": "p", "type": "point", "intensity": 16.0}
    matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]
    scene = c.gltf("blend_shadow", {"triangles": floor, "material": lambert(0.5)},
                   {"triangles": shade, "material": material((0, 0, 0), alpha=0.25, alphaMode="BLEND", specular={"specularFactor": 0})},
                   lights=[(lit, matrix)])
    c.add("alpha-shadow", "The shadow of a sheet of opacity 0.25", scene, "0.75 · ρ/π · I / d².",
          0.75 * 0.5 / pi * 16 * 4 / 18**1.5, pencil((1, 1, 0.5), (1, -1, 0)), spp=1024)
    c.add("alpha-shadow-on-edge", "The same shadow, by rays through the edge between the sheet's two triangles", scene,
          "0.75 · ρ/π · I / d².", 0.75 * 0.5 / pi, pencil((0, 0.1, 0.5), (0, 0, 0)), spp=1024)
    walls(c)


def walls(c):
    """Light samples through smooth walls without inside: what passes is the colour times what a single reflection leaves."""
    tint, glass = (0.2, 0.5, 1.0), lambda cos: 1 - (0.04 + 0.96 * (1 - cos) ** 5)
    floor, pane = quad((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)), lambda z: quad((-9, -9, z), (9, -9, z), (9, 9, z), (-9, 9, z))
    wall = material(tint, roughness=0.0, transmission={"transmissionFactor": 1.0})
    lamp = ({"name": "p", "type": "point", "intensity": 16.0}, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]])
    ground, panes = {"triangles": floor, "material": lambert(0.5)}, [{"triangles": pane(z), "material": wall} for z in (1, 2)]
    # The point seen is √2 beside the lamp's foot: 18 is its distance squared, 4/√18 the cosine. What the panes reflect of the floor is deeper than `max_depth`.
    cos = 4 / 18**0.5
    for count in (1, 2):
        scene = c.gltf(f"wall_shadow_{count}", ground, *panes[:count], lights=[lamp])
        c.add(f"wall-shadow-{count}", f"The shadow of {('a pane', 'two panes')[count - 1]} of coloured glass", scene, "(colour · (1 − F))ⁿ · ρ/π · I cos θ / d², F by Schlick.",
              [0.5 / pi * 16 * cos / 18 * (t * glass(cos)) ** count for t in tint], pencil((1, 1, 0.5), (1, -1, 0)), max_depth=count + 1, strategies=["light", "mis", "bsdf"],
              spp=64)
    c.add("wall-shadow-on-edge", "The shadow of two panes, by a ray through the edge between the triangles of each", scene, "(0.96 · colour)² · ρ/π · I / d².",
          [0.5 / pi * (t * 0.96) ** 2 for t in tint], pencil((0, 0.1, 0.5), (0, 0, 0)), max_depth=3, strategies=["light", "mis", "bsdf"], spp=64)
    c.add("wall-shadow-too-deep", "Two panes, and paths too short for both", scene, "None: a path would have to scatter three times.",
          {"value": 0.0, "each_pixel": True}, pencil((1, 1, 0.5), (1, -1, 0)), max_depth=2, spp=64)
    lamp = quad((-1, -1, 2), (-1, 1, 2), (1, 1, 2), (1, -1, 2))
    grey = material((0.6,) * 3, roughness=0.0, specular={"specularFactor": 0}, transmission={"transmissionFactor": 1.0})
    scene = c.gltf("wall_before_lamp", ground, {"triangles": pane(1), "material": grey},
                   {"triangles": lamp, "material": material((0, 0, 0), emission=3.0, specular={"specularFactor": 0}, double_sided=False)})
    c.add("wall-before-lamp", "A square lamp behind a pane that reflects nothing", scene, "0.6 · ρ/π · E with the irradiance by Lambert's contour integral in double precision.",
          0.6 * 0.5 / pi * irradiance(lamp, (0, 0, 0), (0, 0, 1), 3.0), pencil((0, 0.1, 0.5), (0, 0, 0)), max_depth=2, strategies=["bsdf", "light", "mis"], spp=2048)


def textures(c):
    front = {"eye": [0, 0, 3], "target": [0, 0, 0], "height": 2.0}
    uvs = [((0, 1), (1, 1), (1, 0)), ((0, 1), (1, 0), (0, 0))]
    unlit = material(unlit={})
    c.add("unlit", "An unlit surface shows its colour, whatever lights it",
          c.gltf("unlit", {"triangles": FLAT, "material": material((0.1, 0.5, 0.9), unlit={})}), "The base colour.",
          {"value": [0.1, 0.5, 0.9], "each_pixel": True}, front, 7.0)
    ramp = lambda p: (0.5 + 0.5 * p[0], 0.5 + 0.5 * p[1], 0.25, 1)
    scene = c.gltf("vertex_colours", {"triangles": FLAT, "material": unlit, "colors": [[ramp(p) for p in t] for t in FLAT]})
    c.add("vertex-colours", "Vertex colours are interpolated linearly", scene,
          "Red rises from 0 to 1 from left to right, green from below: their means over an edge column or row of pixels.",
          [{"value": [0.5, 0.5, 0.25]}, {"value": [0.0625, 0.5, 0.25], "region": [0, 0, 1, 8]},
           {"value": [0.5, 0.9375, 0.25], "region": [0, 0, 8, 1]}], front, spp=256)
    texels = [[(255, 0, 100), (0, 255, 100)], [(128, 128, 200), (10, 20, 30)]]
    textured = material(unlit={}, base_texture={"index": 0})
    scene = c.gltf("texture", {"triangles": FLAT, "material": textured, "uvs": uvs}, images=[png(2, 2, texels)])
    value = lambda p: [linear_of_srgb(b) for b in p]
    regions = [[0, 0, 4, 4], [4, 0, 8, 4], [0, 4, 4, 8], [4, 4, 8, 8]]
    c.add("texture", "A texture of four texels the right way up", scene,
          "Each quarter of the picture is one sRGB texel, decoded (IEC 61966-2-1); the first row is the upper one.",
          [{"value": value(t), "region": r, "each_pixel": True} for t, r in zip(sum(texels, []), regions)], front)
    tilt = 128 / 255 * 2 - 1
    mapped = lambert(0.5, normalTexture={"index": 0})
    scene = c.gltf("normal_map", {"triangles": FLAT, "material": mapped, "uvs": uvs, "normals": [[(0, 0, 1)] * 3] * 2},
                   images=[png(1, 1, [[(128, 128, 255)]])],
                   lights=[({"type": "directional", "intensity": 2.0}, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])])
    c.add("normal-map-flat", "A flat normal map changes nothing", scene,
          "ρ/π · E · cos; 128/255 is 0.002 more than half, which tilts the normal by 0.3°: cos = 1/√(1 + 2·0.0039²), or 1 where a "
          "flat map is left out.", {"value": 0.5 / pi * 2 / (1 + 2 * tilt**2) ** 0.5, "relative": 2e-5}, pencil((0.1, 0.2, 3), (0.1, 0.2, 0)))


def write(c):
    furnaces(c)
    layers_of_gltf(c)
    clear_glass(c)
    inside_glass(c)
    mirrors(c)
    coverage(c)
    textures(c)
