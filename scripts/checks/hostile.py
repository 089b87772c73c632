"""What the text of the promise names and a hostile reader would try: layers on layers, lamps that are half there, deep nests, views from within."""
from math import cos, pi, sin, sqrt

from .forms import glowing_box, irradiance
from .geometry import SERIES, scaled
from .outside import BOTH, OBLIQUE
from .surfaces import FLAT, FURNACE, WHITE, at_angle, pencil
from .writers import box, glass, icosphere, lambert, material, png, quad, ray_mesh

FLOOR = quad((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0))
LOOK = pencil((0.05, -0.1, 0.02), (0, 0, 0))
CONTOUR = "ρ/π · E with the irradiance by Lambert's contour integral in double precision"
PASSIVE = FURNACE + "Passive: at most 1, but for tables of albedo (0.005 too low at most)."


def layers(c):
    """Every layer of glTF on what it is seldom put on."""
    coat = {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.2}
    sheen = {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.3}
    film = lambda most: {"iridescenceFactor": 1, "iridescenceThicknessMaximum": most}
    cases = [
        # The scale for multiple scattering comes from isotropic tables; where the roughnesses are far apart it is too low.
        ("anisotropic-metal", 0.8, dict(metallic=1, roughness=0.5, anisotropy={"anisotropyStrength": 1.0, "anisotropyRotation": 0.7})),
        ("anisotropic-smooth", 0.8, dict(metallic=1, roughness=0.02, anisotropy={"anisotropyStrength": 1.0})),
        ("film-on-metal", 0.85, dict(metallic=1, roughness=0.3, iridescence=film(1200))),
        ("film-of-nothing", 0.85, dict(metallic=1, roughness=0.3, iridescence=film(0))),
        ("sheen-on-metal", 0.9, dict(metallic=1, roughness=0.4, sheen=sheen)),
        ("sheen-smooth", 0.9, dict(sheen={"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.0})),
        ("coat-on-wall", 0.9, dict(roughness=0.3, transmission={"transmissionFactor": 1}, clearcoat=coat)),
        ("all-layers", 0.5, dict(metallic=0.5, roughness=0.4, clearcoat=coat, sheen=sheen, iridescence=film(400),
                                 anisotropy={"anisotropyStrength": 0.5}, diffuse_transmission={"diffuseTransmissionFactor": 0.3})),
        ("index-of-1000", 0.9, dict(roughness=0.3, ior={"ior": 1000.0})),
        ("index-of-1", 0.99, dict(roughness=0.3, ior={"ior": 1.0})),
    ]
    for name, least, parameters in cases:
        scene = c.gltf("layers_" + name, {"triangles": FLAT, "material": material(**parameters), "uvs": [((0, 1), (1, 1), (1, 0)), ((0, 1), (1, 0), (0, 0))]})
        for degrees in (20, 85):
            c.add(f"furnace-{name}-at-{degrees}", f"White: {name.replace('-', ' ')}, seen from {degrees}°", scene, PASSIVE,
                  [{"value": 1.0, "relation": "at-most", "relative": 0.01, "resolution": 0.05}, {"value": least, "relation": "at-least", "resolution": 0.05}],
                  at_angle(degrees), WHITE, strategies=BOTH, spp=256)


def glass_of_extremes(c):
    for name, body, low in (("rough-index-1", glass(1.0, 1.0), 0.999), ("dispersing-index-1", glass(1.0, dispersion={"dispersion": 20}), 0.999),
                            ("dispersing", glass(1.5, dispersion={"dispersion": 20}), 0.99), ("index-100", glass(100.0), 0.9)):
        scene = c.gltf(f"glass_{name}", {"triangles": box(), "material": body})
        c.add(f"furnace-glass-{name}", f"A box of glass: {name.replace('-', ' ')}", scene, FURNACE + "Clear glass absorbs nothing; what is caught for 256 bounces is lost.",
              [{"value": 1.0, "relation": "at-most", "relative": 0.005, "resolution": 0.05}, {"value": low, "relation": "at-least", "resolution": 0.05}],
              OBLIQUE, WHITE, strategies=BOTH, max_depth=256, spp=256)
    tints = [[0.9 - 0.1 * k, 0.5, 0.4 + 0.08 * k] for k in range(7)]
    slabs = [{"triangles": box((-1, -1, k / 8 - 1), (1, 1, 1 - k / 8)), "material": glass(1.0, attenuation=tint)} for k, tint in enumerate(tints)]
    value = [1.0] * 3
    for k, tint in enumerate(tints):
        length = 0.25 if k < 6 else 0.5
        value = [v * t**length for v, t in zip(value, tint)]
    c.add("absorption-nested-in-seven", "Seven bodies, each within the one before", c.gltf("absorbing_in_seven", *slabs),
          "A quarter unit of each but the innermost, half a unit of that. Each of the thirteen rays within begins up to 1.8e-6 beyond its surface.",
          {"value": value, "relative": 2e-5}, pencil((0.1, 0.2, 3), (0.1, 0.2, 0)), WHITE, spp=256)
    c.add("absorption-nested-from-within", "The camera in the innermost of seven bodies", "absorbing_in_seven.gltf",
          "From the middle: half of the way through all of them.", [sqrt(v) for v in value], pencil((0.1, 0.2, 0), (0.1, 0.2, 1)), WHITE, spp=256)
    rod = box((-0.02, -0.02, -2), (0.02, 0.02, 2))
    c.add("furnace-glass-fibre", "Into the end of a glass fibre a hundred times longer than wide", c.gltf("glass_fibre", {"triangles": rod, "material": glass(1.5)}),
          FURNACE + "Light that total reflection leads along the fibre comes out of its other end.", 1.0, pencil((0.9, 0.4, 3.3), (0.004, 0.003, 2)), WHITE,
          strategies=BOTH, max_depth=512, spp=256)


def half_there(c):
    """Lamps with coverage, textures, transparency before them."""
    lamp = quad((-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1))
    full = 0.5 / pi * irradiance(lamp, (0, 0, 0), (0, 0, 1), 3.0)
    floor = {"triangles": FLOOR, "material": lambert(0.5)}
    uvs = [((0, 0), (0, 1), (1, 1)), ((0, 0), (1, 1), (1, 0))]
    glow = dict(emission=3.0, color=(0, 0, 0), specular={"specularFactor": 0}, double_sided=False)
    find = ["cosine", "bsdf", "light", "mis"]
    for name, share, more in (("blended", 0.3, dict(alpha=0.3, alphaMode="BLEND")), ("cut-out", 0.0, dict(alpha=0.3, alphaMode="MASK", alphaCutoff=0.5)),
                              ("whole", 1.0, dict(alpha=0.3, alphaMode="OPAQUE"))):
        scene = c.gltf(f"lamp_{name}", floor, {"triangles": lamp, "material": material(**glow, **more)})
        c.add(f"area-alpha-{name}", f"A square lamp of alpha 0.3, {name}", scene, f"{share:g} · {CONTOUR}.",
              {"value": share * full, "absolute": 0.0 if share else 1e-9}, LOOK, strategies=find, spp=2048, max_depth=1)
    small = quad((-.15, -.15, 1), (-.15, .15, 1), (.15, .15, 1), (.15, -.15, 1))
    through = 0.5 / pi * irradiance(small, (0, 0, 0), (0, 0, 1), 30.0)
    for name, at in (("before-the-lamp", (0, 0, .6)), ("beside-the-lamp", (.5, 0, .5))):
        ball = [tuple(tuple(.25 * x + o for x, o in zip(p, at)) for p in t) for t in icosphere(2)]
        scene = c.gltf(f"caster_{name}", floor, {"triangles": small, "material": material(**{**glow, "emission": 30.0})},
                       {"triangles": ball, "material": glass(1.0)})
        c.add(f"caustic-{name}", f"A small lamp, and a ball of index 1 {name.replace('-', ' ')} to aim at", scene,
              CONTOUR + ": light goes straight through.", through, LOOK, strategies=find, spp=8192, max_depth=4)
    halves = material(**{**glow, "emission": 3.0})
    halves["emissiveTexture"] = {"index": 0}
    scene = c.gltf("lamp_textured", floor, {"triangles": lamp, "material": halves, "uvs": uvs}, images=[png(2, 1, [[(255, 255, 255), (0, 0, 0)]])])
    left = quad((-1, -1, 1), (-1, 1, 1), (0, 1, 1), (0, -1, 1))
    c.add("area-half-black", "A square lamp whose texture is half black", scene, CONTOUR + " of the half that is white.",
          0.5 / pi * irradiance(left, (0, 0, 0), (0, 0, 1), 3.0), LOOK, strategies=find, spp=2048, max_depth=1)
    scene = c.gltf("lamp_veiled", floor, {"triangles": lamp, "material": material(**glow)},
                   {"triangles": quad((-9, -9, .5), (9, -9, .5), (9, 9, .5), (-9, 9, .5)), "material": material((0, 0, 0), alpha=0.25, alphaMode="BLEND", specular={"specularFactor": 0})})
    c.add("area-behind-a-veil", "A square lamp behind a black veil of opacity 0.25", scene, f"0.75 · {CONTOUR}.", 0.75 * full, LOOK, strategies=find, spp=2048, max_depth=1)
    for k in (-30, 30):
        scene = c.obj(f"lamp_1e{k}", ({"Kd": (0.5,) * 3}, FLOOR), ({"Kd": (0, 0, 0), "Ke": (10.0**k,) * 3}, lamp))
        c.add(f"area-radiance-1e{k:+d}", f"A square lamp of radiance 1e{k}", scene, CONTOUR + ".", full / 3 * 10.0**k, LOOK, strategies=find, spp=1024, max_depth=1)
    near = quad((-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1))
    far = [tuple((x * 1e3, y * 1e3, z * 1e3) for x, y, z in t) for t in near]
    for name, order in (("near-first", (near, far)), ("far-first", (far, near))):
        scene = c.obj(f"lamps_{name}", ({"Kd": (0.5,) * 3}, FLOOR), *(({"Kd": (0, 0, 0), "Ke": (e,) * 3}, lamp) for lamp, e in zip(order, (1.0, 2.0) if order[0] is near else (2.0, 1.0))))
        c.add(f"area-eclipse-{name}", "A lamp exactly before another one, a thousand times larger and further", scene,
              CONTOUR + " of the near one, which hides the other all but exactly.", {"value": 0.5 / pi * irradiance(near, (0, 0, 0), (0, 0, 1), 1.0), "relative": 1e-3},
              LOOK, strategies=["bsdf", "mis"], spp=1024, max_depth=1)


def from_within(c):
    """The camera in the middle of what glows."""
    ball = ("sphere { material = { diffuse = (0.5, 0.5, 0.5); emissive = (0.25, 0.25, 0.25); } }")
    c.add("shape-sphere-from-within", "The camera in a glowing sphere of a .ray file", c.ray("sphere_within", ball), SERIES, glowing_box(0.25, 0.5, 16),
          {"eye": [0.3, 0.2, -0.4], "target": [1, 0.4, 0.3], "vfov_deg": 60.0}, strategies=["bsdf", "light", "mis"], spp=256)
    room = ray_mesh(box(), "diffuse = (0, 0, 0); reflective = (0.5, 0.5, 0.5); emissive = (1, 1, 1);")
    c.add("mirror-room-that-glows", "The camera in a closed room of mirrors that glow", c.ray("mirror_room_glows", room), "Le · Σ 0.5^k, k = 0 … 16, on every path.",
          {"value": glowing_box(1.0, 0.5, 16), "relative": 1e-5}, {"eye": [0.3, 0.2, -0.4], "target": [1, 0.4, 0.3], "vfov_deg": 90.0}, strategies=BOTH, spp=1024)
    sphere = [t[::-1] for t in icosphere(3)]
    inward = [tuple(tuple(-x for x in p) for p in t) for t in sphere]
    for albedo in (0.5, 0.95):
        glow = lambert(albedo, emission=1 - albedo, double_sided=False)
        scene = c.gltf(f"ball_within_{albedo}", {"triangles": sphere, "normals": inward, "material": glow})
        c.add(f"box-smooth-{albedo}", f"The camera in a glowing ball of albedo {albedo} with smooth normals", scene,
              SERIES + " What interpolated normals send below a facet is lost: under 1 %.",
              [{"value": glowing_box(1 - albedo, albedo, 256), "relation": "at-most", "relative": 1e-3}, {"value": 0.99 * glowing_box(1 - albedo, albedo, 256), "relation": "at-least"}],
              {"eye": [0.3, 0.2, -0.4], "target": [1, 0.4, 0.3], "vfov_deg": 60.0}, strategies=["bsdf", "light", "mis"], spp=256, max_depth=256)
    for metal in (0.3, 0.9):
        scene = c.gltf(f"box_metal_{metal}", {"triangles": box(inward=True), "material": material((metal,) * 3, metallic=0.0, roughness=0.5, emission=1.0, double_sided=False)})
        c.add(f"box-plastic-{metal}", f"A closed box of glowing plastic of albedo {metal}", scene, "Between Le and the series of a wall that reflects 0.04 more than the base, with half as much again for its directions.",
              [{"value": 1.0, "relation": "at-least", "resolution": 0.1}, {"value": glowing_box(1.0, 0.04 + 0.96 * metal, 32), "relation": "at-most", "relative": 0.5}],
              {"eye": [0.3, 0.2, -0.4], "target": [1, 0.4, 0.3], "vfov_deg": 60.0}, strategies=["bsdf", "light", "mis"], spp=256, max_depth=32)


def frames(c):
    """Tangents that are not there, colours beyond 1, transforms that cancel."""
    tilted = png(1, 1, [[(200, 100, 220)]])
    same = [((0.5, 0.5),) * 3] * 2
    scene = c.gltf("map_without_area", {"triangles": FLAT, "material": lambert(0.5, normalTexture={"index": 0}), "uvs": same}, images=[tilted])
    c.add("normal-map-without-area", "A normal map on texture coordinates that are all the same", scene, FURNACE + "ρ · 1, whatever the tangents are.",
          {"value": 0.5, "relation": "at-most"}, at_angle(30), WHITE, strategies=BOTH)
    over = png(1, 1, [[(255, 255, 128)]])
    uvs = [((0, 1), (1, 1), (1, 0)), ((0, 1), (1, 0), (0, 0))]
    for scale in (100.0, 1e30):
        scene = c.gltf(f"map_scaled_{scale:g}", {"triangles": FLAT, "material": lambert(0.5, normalTexture={"index": 0, "scale": scale}), "uvs": uvs}, images=[over])
        c.add(f"normal-map-scale-{scale:g}", f"A normal map of scale {scale:g}", scene, FURNACE + "At most ρ · 1.", {"value": 0.5, "relation": "at-most"},
              at_angle(30), WHITE, strategies=BOTH)
    for name, factor, value in (("black", (0, 0, 0, 1), 0.0), ("grey", (0.5, 0.5, 0.5, 1), 0.25), ("twice", (2, 2, 2, 1), 1.0)):
        scene = c.gltf(f"coloured_{name}", {"triangles": FLAT, "colors": [[factor] * 3] * 2, "material": lambert(0.5)})
        c.add(f"vertex-colours-{name}", f"Vertex colours of {factor[0]:g}", scene, FURNACE + "ρ · 1, and never more than 1.", {"value": value, "absolute": 1e-6}, at_angle(30), WHITE,
              strategies=BOTH)
    half = lambert(0.5, emission=1.0, double_sided=False)
    big = [tuple(tuple(1e15 * x for x in p) for p in t) for t in box(inward=True)]
    scene = c.gltf("box_scaled_back", {"triangles": big, "material": half, "matrix": scaled(1e-15)})
    view = {"eye": [0.3, 0.2, -0.4], "target": [1, 0.4, 0.3], "vfov_deg": 60.0}
    c.add("transform-back-from-1e+15", "A glowing box of 1e15, scaled back to 1", scene, SERIES, glowing_box(1.0, 0.5, 8), view, max_depth=8, strategies=BOTH, spp=256)
    turn = [[cos(1), -sin(1), 0, 1e-3], [sin(1), cos(1), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    for name, z in (("+0", 0.0), ("-0", -0.0)):
        corners = [tuple((x, y, z if k == 0 else w) for k, (x, y, w) in enumerate(t)) for t in FLOOR]
        scene = c.gltf(f"floor_{name}", {"triangles": corners, "matrix": turn, "material": lambert(1.0)})
        c.add(f"zero-with-sign-{name}", f"A floor at z = {name}", scene, FURNACE + "ρ · 1.", 1.0, pencil((0.1, 0.2, 1), (0.1, 0.2, 0)), WHITE, strategies=BOTH)


def environments(c):
    """One texel that outshines all the rest."""
    rows = [[[1e-3] * 3] * 32 for _ in range(16)]
    rows[3][5] = [1e6] * 3
    scene = c.obj("floor_of_sun", ({"Kd": (0.5,) * 3}, quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1))))
    total = 0.0
    steps = 64
    for i in range(3 * steps):  # rows 2 … 4 by bilinear interpolation between texels' centres
        v = 2.0 + (i + 0.5) / steps
        for j in range(3 * steps):
            u = 4.0 + (j + 0.5) / steps
            tent = max(0.0, 1 - abs(v - 3.5)) * max(0.0, 1 - abs(u - 5.5))
            theta = v / 16 * pi
            total += 1e6 * tent * max(0.0, cos(theta)) * sin(theta) * (pi / 16 / steps) * (2 * pi / 32 / steps)
    c.add("environment-sun", "A world whose light comes from one texel, a thousand million times brighter than the rest", scene,
          "ρ/π ∫ L cos of the texel's tent of bilinear interpolation, and ρ · 0.001.", {"value": 0.5 / pi * total + 0.5e-3, "relative": 2e-3}, pencil((0.3, 2, 0.2), (0.1, 0, 0.2)),
          {"rows": rows}, strategies=["light", "mis"], spp=1024)


def write(c):
    layers(c)
    glass_of_extremes(c)
    half_there(c)
    from_within(c)
    frames(c)
    environments(c)
