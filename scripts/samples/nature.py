"""A pot plant with alpha-masked leaves, balloons in vertex colours, a globe with external resources."""
import numpy as np

from .gltf import Gltf
from .pictures import bytes_of, fractal, mix, noise, png, smoothstep, srgb
from .shapes import arc, curve, cylinder, lathe, merge, octasphere, oriented, rounded_box, rotation, sphere, surface, torus, tube


def monstera_picture(size=512):
    """A split leaf from its stem (bottom) to its tip (top): RGBA, alpha a mask with slits and holes."""
    v, u = (np.mgrid[0:size, 0:size] + 0.5) / size
    x, y = (u - 0.5) * 2, 1 - v  # y: 0 at the stem, 1 at the tip
    half = 0.94 * np.sin(np.pi * np.clip(y, 0, 1) ** 0.62) ** 0.75
    heart = np.abs(x) < half
    notch = (y < 0.16) & (np.abs(x) < 0.42 * (0.16 - y) / 0.16)
    along = y - 0.30 * np.abs(x)  # side veins rise outwards
    phase = along * 8.5 + 0.13 * np.sign(x)
    band = np.abs(phase - np.round(phase))  # 0 at a slit's middle, 0.5 on a vein
    reach = np.abs(x) / np.maximum(half, 1e-3)
    slit = (band < 0.17 * smoothstep(0.42, 0.75, reach)) & (along > 0.02) & (y < 0.93)
    hole = (band / 0.13) ** 2 + ((reach - 0.26) / 0.09) ** 2 < 1
    mask = heart & ~notch & ~slit & ~(hole & (along > 0.1) & (y < 0.8))
    p = np.stack([u * 6, v * 6, 0 * u], -1)
    tone = 0.5 * fractal(p, 4, 2) + 0.5 * (0.5 - np.abs(band - 0.25)) * 2
    colour = mix(bytes_of("#235c34"), bytes_of("#5d9a48"), smoothstep(0.3, 0.9, tone)[..., None])
    vein = np.maximum(smoothstep(0.035, 0.012, np.abs(x)), 0.7 * smoothstep(0.46, 0.495, band) * (reach < 0.95))
    colour = mix(colour, bytes_of("#a5c878"), vein[..., None])
    return png(np.concatenate([colour, np.where(mask, 255.0, 0.0)[..., None]], -1), 64)


def leaf_blade(length=1.0, width=0.92):
    """A card that arches along its length and folds along its middle; the stem's end is at the origin."""
    t, s = np.meshgrid(np.linspace(0, 1, 13), np.linspace(-1, 1, 9), indexing="ij")
    angle = 0.35 - 1.25 * t
    z = np.cumsum(np.cos(angle), 0) / 13
    y = np.cumsum(np.sin(angle), 0) / 13
    pos = np.stack([s * width / 2, length * (y - y[0]) + 0.14 * np.abs(s) ** 1.5 - 0.05 * s ** 2, length * (z - z[0])], -1)
    blade = surface(pos)
    blade.uv = np.stack([(s + 1) / 2, 1 - t], -1).reshape(-1, 2)
    return blade


def monstera(path):
    """Alpha mask: every leaf is the same card; stems, pot and earth are solid."""
    g = Gltf()
    leaf = g.material("leaf", roughness=0.45, maps={"baseColor": g.texture("leaf", monstera_picture(), 33071)},
                      alphaMode="MASK", alphaCutoff=0.5, doubleSided=True)
    stem = g.material("stem", srgb("#5b8a47"), roughness=0.6)
    blade = g.mesh("leaf", (g.geometry(leaf_blade(), uv=True), leaf))
    stems = []
    for k in range(13):
        turn = 137.508 * k + 20
        lean = 0.12 + 0.068 * k
        tall = 2.15 - 0.105 * k
        path_ = curve([(0.04, 0.75, 0), (0.12 + 0.2 * lean, 0.75 + 0.5 * tall, 0), (0.1 + 0.85 * lean, 0.75 + 0.8 * tall, 0)], 14)
        m = rotation(turn)
        stems.append(tube(path_, np.linspace(0.032, 0.018, 14), 8).turned(turn))
        a, tilt = np.radians(turn + 90), np.radians(-6 + 3.2 * k)
        yaw, pitch = (0, np.sin(a / 2), 0, np.cos(a / 2)), (np.sin(tilt / 2), 0, 0, np.cos(tilt / 2))
        size = 0.98 - 0.028 * ((k * 5) % 13)
        g.node(name=f"leaf {k}", mesh=blade, translation=tuple(m @ path_[-1]), rotation=product(yaw, pitch), scale=(size,) * 3)
    g.put("stems", merge(*stems), stem)
    pot = lathe([[(0, 0), (0.42, 0)], curve([(0.42, 0), (0.47, 0.03), (0.6, 0.62)], 12), [(0.6, 0.62), (0.66, 0.62)],
                 curve([(0.66, 0.62), (0.675, 0.7), (0.67, 0.82)], 8), arc(0.64, 0.82, 0.03, 0, 180, 7), [(0.61, 0.82), (0.58, 0.6)]], 72)
    g.put("pot", pot, g.material("terracotta", srgb("#c07250"), roughness=0.85))
    g.put("saucer", lathe([[(0, -0.06), (0.62, -0.06)], curve([(0.62, -0.06), (0.72, -0.02), (0.76, 0.06)], 8), arc(0.745, 0.06, 0.015, 0, 180, 5), curve([(0.73, 0.06), (0.7, 0.0), (0.6, -0.03)], 6), [(0.6, -0.03), (0, -0.03)]], 72),
          g.material("glazed saucer", srgb("#a85f42"), roughness=0.35))
    rng = np.random.RandomState(4)
    earth = cylinder(0.6, 0.6, 0.74, 48)
    crumbs = [octasphere(1).scaled(rng.uniform(0.03, 0.06)).moved(0.55 * np.sqrt(q) * np.cos(w), 0.745, 0.55 * np.sqrt(q) * np.sin(w))
              for q, w in zip(rng.uniform(0, 1, 70), rng.uniform(0, 2 * np.pi, 70))]
    g.put("earth", merge(earth, *crumbs), g.material("earth", srgb("#4a3426"), roughness=1.0))
    g.save_glb(path)


def product(a, b):
    """Hamilton product of quaternions (x, y, z, w)."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def envelope(colour, gores=18, rings=24, sub=2):
    """A balloon's envelope: gores bulge between their seams; `colour(gore, height 0–1)` paints cell by cell."""
    profile = curve([(0.2, -1.32), (0.34, -1.12), (0.78, -0.55), (1.0, 0.12), (0.86, 0.66), (0.48, 0.96), (0.0, 1.06)], rings + 1)
    profile[-1, 0] = 0.0
    pos, col = [], []
    for k in range(gores):
        s = np.linspace(0, 1, sub + 1)
        angle = (k + s) / gores * 2 * np.pi
        bulge = 1 - 0.045 * (2 * s - 1) ** 2
        r = profile[:, :1] * np.where(profile[:, 1:] < 0.98, bulge, 1.0)
        pos.append(np.stack([r * np.cos(angle), np.broadcast_to(profile[:, 1:], r.shape), -r * np.sin(angle)], -1))
        col.append([colour(k, (j + 0.5) / rings) for j in range(rings)])
    parts = []
    for lattice, colours in zip(pos, col):
        smooth = surface(lattice)
        n = smooth.nrm.reshape(lattice.shape)
        n[-1] = (0, 1, 0)
        for j, rgb in enumerate(colours):
            patch = surface(lattice[j:j + 2], n[j:j + 2])
            parts.append(patch.coloured(rgb))
    return merge(*parts)


def basket(colour):
    """Basket, rim and ropes below an envelope."""
    wicker, rim, rope = srgb("#a8733f"), srgb("#5e3b22"), srgb("#d8c7a4")
    parts = [rounded_box(0.3, 0.24, 0.3, 0.05).moved(y=-1.82).coloured(wicker), torus(0.17, 0.022, 4, 8).turned(45).scaled(1.02).moved(y=-1.7).coloured(rim),
             torus(0.2, 0.02, 32, 8).moved(y=-1.32).coloured(colour)]
    for k in range(4):
        a = np.radians(45 + 90 * k)
        parts.append(tube([(0.17 * np.cos(a), -1.7, 0.17 * np.sin(a)), (0.2 * np.cos(a), -1.32, 0.2 * np.sin(a))], 0.008, 6).coloured(rope))
    return merge(*parts)


def cloud(seed, count=7):
    """A heap of balls, its underside a little rosy."""
    rng = np.random.RandomState(seed)
    balls = []
    for k in range(count):
        f = (k + 0.5) / count * 2 - 1
        r = 0.45 * (1 - 0.6 * f * f) + rng.uniform(-0.05, 0.06)
        balls.append(octasphere(3).scaled(r).moved(f * 1.05, 0.5 * r + rng.uniform(-0.04, 0.12), rng.uniform(-0.22, 0.22)))
    whole = merge(*balls)
    y = (whole.pos[:, 1] - whole.pos[:, 1].min()) / np.ptp(whole.pos[:, 1])
    rgb = mix(np.array(srgb("#e8c9c4")), np.array(srgb("#fbf7f0")), smoothstep(0.0, 0.6, y)[:, None])
    whole.col = np.concatenate([rgb, np.ones((len(rgb), 1))], 1)
    return whole


def balloons(path):
    """Everything is painted in vertex colours over one white material."""
    g = Gltf()
    white = g.material("painted cloth", roughness=0.7)
    red, cream, navy, teal, gold, rose = (srgb(c) for c in ("#c8402f", "#f3e7cf", "#24405f", "#3f8f8b", "#e2a93b", "#e58f82"))

    def stripes(k, t):
        return gold if 0.50 < t < 0.56 else (red, cream)[k % 2] if t > 0.16 else red

    def zigzag(k, t):
        tooth = 2 * min(k % 6, 6 - k % 6)  # 0 … 6 … 0 over six gores
        bands = (navy, teal, cream, gold, cream, teal, navy)
        return bands[int(np.clip((24 * t + tooth - 5) // 4.0, 0, 6))]

    def sunrise(k, t):
        return tuple(mix(np.array(rose), np.array(cream), smoothstep(0.2, 0.75, t))) if k % 3 else gold

    for name, paint, rim, place, size in (("striped", stripes, red, (-0.2, 0.45, 0.0), 1.0), ("zigzag", zigzag, navy, (1.32, -0.42, -0.5), 0.62),
                                          ("sunrise", sunrise, rose, (-1.28, -0.62, 0.75), 0.5)):
        parts = merge(envelope(paint), basket(rim))
        g.put(name, parts, white, translation=place, scale=(size,) * 3)
    puff = g.material("cloud", roughness=1.0, specular={"specularFactor": 0.0})
    for k, (place, size) in enumerate((((0.95, -1.72, 0.45), 0.74), ((-0.75, -1.95, 0.2), 0.86))):
        g.put(f"cloud {k}", cloud(k + 1), puff, translation=place, scale=(size,) * 3)
    g.save_glb(path)


def planet_map(width=896, height=448):
    """An antique map of a world that isn't: seas with depth lines, land by noise, graticule."""
    v, u = (np.mgrid[0:height, 0:width] + 0.5) / np.array([height, width]).reshape(2, 1, 1)
    lat, lon = (0.5 - v) * np.pi, u * 2 * np.pi
    p = np.stack([np.cos(lat) * np.cos(lon), np.sin(lat), -np.cos(lat) * np.sin(lon)], -1)
    warp = np.stack([fractal(p * 2.2 + 7 * k, 3, 50 + k) - 0.5 for k in range(3)], -1)
    h = fractal(p * 1.55 + 0.9 * warp + 4.2, 6, 31) - 0.50
    coast = smoothstep(-0.002, 0.002, h)
    sea = mix(bytes_of("#4a8894"), bytes_of("#7fb0ab"), smoothstep(-0.07, 0.0, h)[..., None])
    lines = (np.abs((h * 60) % 1 - 0.5) < 0.1) & (h < 0) & (h > -0.06)
    sea = mix(sea, bytes_of("#e4e8d8"), (0.45 * lines)[..., None])
    dry = fractal(p * 4 + 9, 4, 40)
    land = mix(bytes_of("#e6c98c"), bytes_of("#b5b877"), smoothstep(0.44, 0.56, dry)[..., None])
    land = mix(land, bytes_of("#b98550"), smoothstep(0.05, 0.13, h)[..., None])
    land = mix(land, bytes_of("#f7f2e4"), smoothstep(1.36, 1.4, np.abs(lat) + 0.25 * dry)[..., None])
    colour = mix(sea, land, coast[..., None])
    colour = mix(colour, bytes_of("#5b4630"), (0.9 * smoothstep(0.009, 0.005, np.abs(h)))[..., None])
    degrees = lambda a, step: np.abs((np.degrees(a) / step + 0.5) % 1 - 0.5) * step
    thin = (degrees(lat, 15) < 0.16) | (degrees(lon, 15) < 0.16 / np.maximum(np.cos(lat), 0.1))
    colour = mix(colour, bytes_of("#6b5538"), (0.45 * (thin & (np.abs(np.degrees(lat)) < 76)))[..., None])
    equator = np.abs(np.degrees(lat)) < 0.5
    return png(mix(colour, bytes_of("#a03d2c"), (0.9 * equator)[..., None]), 128)


def globe(path):
    """A .gltf whose buffer and texture lie in a folder with a space and an accent in its name."""
    g = Gltf()
    paper = g.material("varnished map", roughness=0.3, maps={"baseColor": g.texture("world map", planet_map())})
    brass = g.material("brass", (0.87, 0.65, 0.33), 1.0, 0.27)
    wood = g.material("walnut", srgb("#54301c"), roughness=0.3)
    tilt = -23.4
    half = np.radians(tilt) / 2
    axis = g.node(name="axis", translation=(0, 1.62, 0), rotation=(0, 0, np.sin(half), np.cos(half)))
    spin = np.radians(-40) / 2
    g.node(axis, name="globe", rotation=(0, np.sin(spin), 0, np.cos(spin)), mesh=g.mesh("globe", (g.geometry(sphere(1.0, 32, 64), uv=True), paper)))
    a = np.radians(np.linspace(-97, 97, 64))
    outward = np.stack([np.cos(a), np.sin(a), 0 * a], -1)[:, None]
    edge = lambda r, z: 1.13 * r * outward + (0, 0, z)
    strip = lambda p, q, n: surface(np.concatenate([p, q], 1), np.broadcast_to(n, (64, 2, 3)))
    faces = [strip(edge(0.97, z), edge(1.03, z), (0, 0, np.sign(z))) for z in (0.05, -0.05)]
    rims = [strip(edge(r, -0.05), edge(r, 0.05), np.sign(r - 1) * outward) for r in (0.97, 1.03)]
    pins = merge(cylinder(0.04, 0.98, 1.24, 24), cylinder(0.04, -1.24, -0.98, 24), sphere(0.075, 16, 32).moved(y=1.27))
    g.node(axis, name="meridian", mesh=g.mesh("meridian", (g.geometry(merge(*faces, *rims, pins)), brass)))
    stem = lathe([curve([(0.3, 0.2), (0.12, 0.28), (0.09, 0.36), (0.15, 0.43), (0.08, 0.5)], 24)], 48)
    g.put("stem", stem, brass)
    foot = lathe([[(0, 0), (0.78, 0)], [(0.78, 0), (0.78, 0.05)], arc(0.72, 0.05, 0.06, 0, 90, 6), curve([(0.72, 0.11), (0.66, 0.115), (0.5, 0.14), (0.4, 0.2)], 10), [(0.4, 0.2), (0, 0.22)]], 64)
    g.put("foot", foot, wood)
    g.save_gltf(path, "desk globe – données", "géométrie.bin")
