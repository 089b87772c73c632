"""OBJ samples: pieces on a chess board, a corner to read in, painted dolls."""
import numpy as np

from .obj import Obj
from .pictures import bytes_of, mix, png, smoothstep, srgb
from .shapes import arc, curve, cylinder, lathe, quad, rounded_box, sphere, torus, tube


def base_run(r, y0=0.0):
    """The moulded foot of a piece: flat below, a torus, a fillet; ends at 0.62 r."""
    return [np.array([(0, y0), (r * 0.96, y0)]), np.vstack([arc(r * 0.9, y0 + 0.13, 0.13, -80, 90, 6)]),
            arc(r * 0.76, y0 + 0.34, 0.08, -90, 80, 5)]


def piece(kind):
    """One turned chess piece, about as wide at the foot as its square allows; the board's squares are 2 wide."""
    r = {"pawn": 0.56, "rook": 0.64, "bishop": 0.64, "queen": 0.70, "king": 0.72}[kind]
    top = {"pawn": 1.15, "rook": 1.45, "bishop": 1.8, "queen": 2.35, "king": 2.6}[kind]
    stem = curve([(r * 0.7, 0.43), (r * 0.46, 0.75), (r * 0.33, 0.55 * top + 0.2), (r * 0.36, top)], 9)
    collar = [arc(r * 0.5, top + 0.07, 0.07, -100, 90, 6)]
    if kind == "pawn":
        head = [arc(0, top + 0.48, 0.36, -62, 90, 12)]
    elif kind == "rook":
        head = [curve([(r * 0.42, top + 0.14), (r * 0.56, top + 0.3), (r * 0.62, top + 0.45)], 6),
                np.array([(r * 0.62, top + 0.45), (r * 0.66, top + 0.5), (r * 0.66, top + 0.86)]),
                np.array([(r * 0.66, top + 0.86), (r * 0.48, top + 0.86)]), np.array([(r * 0.48, top + 0.86), (r * 0.48, top + 0.62)]),
                np.array([(r * 0.48, top + 0.62), (0, top + 0.62)])]
    elif kind == "bishop":
        head = [curve([(r * 0.3, top + 0.14), (r * 0.54, top + 0.45), (r * 0.4, top + 0.85), (r * 0.1, top + 1.12)], 14),
                arc(0, top + 1.2, 0.11, -40, 90, 6)]
    elif kind == "queen":
        head = [curve([(r * 0.34, top + 0.14), (r * 0.44, top + 0.5), (r * 0.7, top + 0.92)], 10),
                np.array([(r * 0.7, top + 0.92), (r * 0.56, top + 0.92)]), curve([(r * 0.56, top + 0.92), (r * 0.3, top + 1.06), (0.06, top + 1.1)], 6),
                arc(0, top + 1.2, 0.12, -50, 90, 6)]
    else:
        head = [curve([(r * 0.34, top + 0.14), (r * 0.46, top + 0.5), (r * 0.64, top + 0.94)], 10),
                curve([(r * 0.64, top + 0.94), (r * 0.5, top + 1.04), (r * 0.12, top + 1.12), (0, top + 1.12)], 6)]
    parts = [lathe([*base_run(r), stem, *collar, *head], 22)]
    if kind == "rook":
        for k in range(6):
            parts.append(rounded_box(0.2, 0.16, 0.12, 0.02, 1).moved(y=top + 0.93, z=r * 0.57).turned(60 * k))
    if kind == "king":
        parts += [rounded_box(0.14, 0.5, 0.12, 0.03, 1).moved(y=top + 1.34), rounded_box(0.4, 0.14, 0.12, 0.03, 1).moved(y=top + 1.4)]
    return parts


def chess(path):
    """The end of a game: turned pieces in two woods, PBR fields Pr and Pm, no light (so the studio's)."""
    o = Obj()
    o.material("maple", Kd=srgb("#dcb67e"), Pr=0.32, Pm=0)
    o.material("walnut", Kd=srgb("#3d2317"), Pr=0.25, Pm=0)
    o.material("light_square", Kd=srgb("#e3d3b4"), Pr=0.45, Pm=0)
    o.material("dark_square", Kd=srgb("#6f8f83"), Pr=0.45, Pm=0)
    o.material("frame", Kd=srgb("#4a2a1a"), Pr=0.4, Pm=0)
    o.material("brass", Kd=(0.88, 0.68, 0.36), Pr=0.28, Pm=1)
    size = 3
    o.add("frame", "frame", rounded_box(7.2, 0.7, 7.2, 0.14, 3).moved(y=-0.4))
    o.add("inlay", "brass", rounded_box(6.24, 0.06, 6.24, 0.01, 1).moved(y=-0.05))
    for colour in (0, 1):
        squares = [rounded_box(1.98, 0.1, 1.98, 0.02, 1).moved((i - 1) * 2, -0.05, (j - 1) * 2)
                   for i in range(size) for j in range(size) if (i + j) % 2 == colour]
        o.add(f"squares_{colour}", ("dark_square", "light_square")[colour], *squares)
    at = lambda kind, i, j: [m.turned(25).moved((i - 1) * 2, 0.0, (j - 1) * 2) for m in piece(kind)]
    o.add("white_king", "maple", *at("king", 0, 0))
    o.add("white_bishop", "maple", *at("bishop", 0, 1))
    o.add("white_pawn", "maple", *at("pawn", 0, 2))
    o.add("white_rook", "maple", *at("rook", 1, 1))
    o.add("black_queen", "walnut", *at("queen", 1, 0))
    o.add("black_rook", "walnut", *at("rook", 2, 0))
    fallen = [m.turned(-90, "x").moved(y=0.53, z=0.3).turned(63).moved(1.1, 0.0, 2.0) for m in piece("pawn")]
    o.add("black_pawn_fallen", "walnut", *fallen)
    o.save(path)


def reading_corner(path):
    """A room cut open: emissive lamp, shade and window (Ke), soft furniture; made for the automatic view."""
    o = Obj()
    for name, colour, rough in (("wall", "#dfd3bd", 0.95), ("wall_edge", "#efe9df", 0.9), ("floor", "#c89a6a", 0.45),
                                ("skirting", "#efe9df", 0.6), ("cushion", "#d9a441", 0.9), ("armchair", "#c4533f", 0.95),
                                ("wood", "#6b452b", 0.5), ("rug", "#e9dfcc", 1.0), ("rug_ring", "#39586b", 1.0),
                                ("pot", "#e6dccb", 0.5), ("leaf", "#4d7a46", 0.7), ("paper", "#f2ece0", 0.9),
                                ("navy", "#2c4257", 0.6), ("ochre", "#d09a3c", 0.6), ("brick", "#a84a3a", 0.6), ("sage", "#8fa383", 0.6)):
        o.material(name, Kd=srgb(colour), Pr=rough, Pm=0)
    o.material("brass", Kd=(0.85, 0.62, 0.32), Pr=0.3, Pm=1)
    o.material("shade", Kd=srgb("#f3dfb6"), Ke=(9.0, 6.0, 3.0))
    o.material("lantern", Kd=(0, 0, 0), Ke=(36.0, 28.5, 19.0))
    o.material("window", Kd=(0, 0, 0), Ke=(7.5, 9.0, 11.0))
    s, h, t = 1.7, 2.7, 0.07  # half the room, its height, the walls' thickness
    box = lambda sx, sy, sz, x, y, z, r=0.0: rounded_box(sx, sy, sz, r, 2).moved(x, y, z)
    o.add("floor", "floor", *[box(2 * s / 10 - 0.008, 0.1, 2 * s, -s + (k + 0.5) * 2 * s / 10, -0.05, 0) for k in range(10)])
    o.add("underfloor", "wall_edge", box(2 * s + t, t, 2 * s + t, -t / 2, -0.1 - t / 2, -t / 2))
    o.add("back_wall", "wall", box(2 * s, h, 0.02, 0, h / 2, -s - 0.01))
    y0, y1, z0, z1 = 0.9, 2.25, -0.75, 0.85  # the window
    o.add("left_wall", "wall", box(0.02, y0, 2 * s, -s - 0.01, y0 / 2, 0), box(0.02, h - y1, 2 * s, -s - 0.01, (h + y1) / 2, 0),
          box(0.02, y1 - y0, z0 + s, -s - 0.01, (y0 + y1) / 2, (z0 - s) / 2), box(0.02, y1 - y0, s - z1, -s - 0.01, (y0 + y1) / 2, (z1 + s) / 2))
    o.add("shell", "wall_edge", box(2 * s + t, h + 0.22, t - 0.02, -t / 2, h / 2 - 0.11, -s - 0.02 - (t - 0.02) / 2),
          box(t - 0.02, h + 0.22, 2 * s + t, -s - 0.02 - (t - 0.02) / 2, h / 2 - 0.11, -t / 2))
    o.add("skirting", "skirting", box(2 * s, 0.12, 0.025, 0, 0.06, -s + 0.0125, 0.008), box(0.025, 0.12, 2 * s, -s + 0.0125, 0.06, 0, 0.008))
    o.add("window", "window", quad((-s - 0.01, y0, z1), (-s - 0.01, y0, z0), (-s - 0.01, y1, z0), (-s - 0.01, y1, z1)))
    bars = [box(0.05, 0.06, z1 - z0 + 0.1, -s + 0.01, y, (z0 + z1) / 2) for y in (y0, y1)]
    bars += [box(0.05, y1 - y0 + 0.06, 0.06, -s + 0.01, (y0 + y1) / 2, z) for z in (z0, z1)]
    bars += [box(0.03, 0.035, z1 - z0, -s + 0.004, y0 + 0.62 * (y1 - y0), (z0 + z1) / 2), box(0.03, y1 - y0, 0.035, -s + 0.004, (y0 + y1) / 2, (z0 + z1) / 2)]
    o.add("window_frame", "skirting", *bars, box(0.16, 0.04, z1 - z0 + 0.2, -s + 0.07, y0 - 0.04, (z0 + z1) / 2, 0.01))
    o.add("rug", "rug", cylinder(1.12, 0.0, 0.022, 48).moved(0.25, 0, 0.3))
    o.add("rug_rings", "rug_ring", *[lathe([[(a, 0.022), (b, 0.022)], ], 64).moved(0.25, 0.002, 0.3) for a, b in ((1.06, 1.0), (0.94, 0.72), (0.4, 0.34))])
    chair = [rounded_box(0.86, 0.26, 0.8, 0.09).moved(y=0.33), rounded_box(0.92, 0.74, 0.24, 0.11).turned(-9, "x").moved(y=0.66, z=-0.36),
             rounded_box(0.2, 0.44, 0.82, 0.09).moved(-0.47, 0.42, 0.02), rounded_box(0.2, 0.44, 0.82, 0.09).moved(0.47, 0.42, 0.02)]
    place = lambda meshes: [m.turned(30).moved(-0.35, 0.02, -0.62) for m in meshes]
    o.add("armchair", "armchair", *place(chair))
    o.add("seat", "armchair", *place([rounded_box(0.74, 0.18, 0.72, 0.08).moved(y=0.5, z=0.06)]))
    o.add("cushion", "cushion", *place([rounded_box(0.46, 0.4, 0.16, 0.08).turned(-18, "x").moved(0.08, 0.77, -0.16)]))
    o.add("chair_legs", "wood", *place([cylinder(0.028, -0.02, 0.22, 12, top=0.035).moved(x, 0, z) for x in (-0.36, 0.36) for z in (-0.3, 0.32)]))
    lamp = (0.72, 0.0, -1.22)
    o.add("lamp_stand", "brass", cylinder(0.17, 0.0, 0.03, 28).moved(*lamp), cylinder(0.014, 0.03, 1.62, 8).moved(*lamp))
    shade = lathe([[(0.27, 1.5), (0.18, 1.86)]], 48)
    inner = lathe([[(0.177, 1.858), (0.267, 1.502)]], 48)
    o.add("lamp_shade", "shade", shade.moved(*lamp), inner.moved(*lamp))
    hook = curve([(0.5, 2.3, -s), (0.5, 2.62, -s + 0.12), (0.5, 2.66, -0.6), (0.5, 2.6, 0.25)], 24)
    o.add("lantern_arm", "brass", tube(hook, 0.014, 8), tube([(0.5, 2.6, 0.25), (0.5, 2.3, 0.25)], 0.009, 6))
    o.add("lantern", "lantern", sphere(0.24, 10, 20).scaled(1, 0.9, 1).moved(0.5, 2.09, 0.25))
    table = (0.98, 0.0, -0.42)
    o.add("side_table", "wood", cylinder(0.27, 0.46, 0.49, 32).moved(*table), cylinder(0.025, 0.02, 0.46, 8).moved(*table), cylinder(0.17, 0.0, 0.025, 24).moved(*table))
    cup = lathe([[(0, 0.49), (0.045, 0.49)], curve([(0.045, 0.49), (0.06, 0.53), (0.062, 0.59)], 6), curve([(0.055, 0.59), (0.05, 0.53), (0.0, 0.505)], 6)], 14)
    o.add("cup", "navy", cup.moved(0.9, 0, -0.34), torus(0.03, 0.008, 12, 5).turned(90, "x").moved(0.965, 0.545, -0.34))
    o.add("book_on_table", "brick", box(0.2, 0.03, 0.14, 1.06, 0.505, -0.48, 0.004))
    o.add("book_on_top", "sage", rounded_box(0.18, 0.025, 0.13, 0.004, 1).turned(14).moved(1.06, 0.533, -0.48))
    o.add("shelves", "wood", *[box(1.3, 0.035, 0.24, -0.55, y, -s + 0.12, 0.006) for y in (1.42, 1.86)])
    rng = np.random.RandomState(12)
    books = {c: [] for c in ("navy", "ochre", "brick", "sage", "paper")}
    for y, stop in ((1.4375, -0.25), (1.8775, -0.05)):
        x, k = -1.15, 0
        while x < stop:
            w, tall, deep = rng.uniform(0.028, 0.06), rng.uniform(0.2, 0.31), rng.uniform(0.15, 0.2)
            name = list(books)[rng.randint(5)]
            books[name].append(box(w - 0.003, tall, deep, x + w / 2, y + tall / 2, -s + 0.02 + deep / 2))
            x, k = x + w, k + 1
    for name, meshes in books.items():
        o.add(f"books_{name}", name, *meshes)
    o.add("vase", "pot", lathe([[(0, 0), (0.05, 0)], curve([(0.05, 0), (0.09, 0.09), (0.05, 0.18), (0.03, 0.21), (0.045, 0.25)], 14), [(0.045, 0.25), (0.03, 0.22)]], 18).moved(-0.08, 1.4375, -s + 0.12))
    o.add("globe", "ochre", sphere(0.11, 9, 18).moved(0.03, 1.99, -s + 0.12))
    o.add("picture_frame", "wood", box(0.62, 0.8, 0.035, 1.12, 1.95, -s + 0.018, 0.008))
    o.add("picture", "paper", box(0.55, 0.73, 0.01, 1.12, 1.95, -s + 0.035))
    o.add("picture_sun", "brick", cylinder(0.12, 0, 0.006, 28).turned(90, "x").moved(1.16, 2.06, -s + 0.041))
    o.add("picture_hill", "navy", box(0.55, 0.2, 0.01, 1.12, 1.69, -s + 0.038))
    pot = (-1.2, 0.0, 1.1)
    o.add("pot", "pot", lathe([[(0, 0), (0.16, 0)], curve([(0.16, 0), (0.22, 0.2), (0.23, 0.38)], 10), [(0.23, 0.38), (0.2, 0.38)], [(0.2, 0.38), (0.19, 0.33), (0, 0.33)]], 28).moved(*pot))
    leaves = []
    for k in range(11):
        turn, lean = 137.5 * k, 0.08 + 0.016 * k
        rib = curve([(0, 0.3, 0), (0.3 * lean, 0.62, 0), (0.9 * lean, 0.98 - 0.2 * lean, 0), (1.5 * lean, 1.02 - 0.62 * lean, 0)], 8)
        blade = tube(rib, 0.055 * np.sin(np.linspace(0.25, np.pi, 8)) + 0.004, 6)
        leaves.append(blade.turned(turn).moved(*pot))
    o.add("leaves", "leaf", *leaves)
    o.save(path)


DOLL = [curve([(0.40, 0.0), (0.47, 0.06), (0.56, 0.45), (0.5, 0.85), (0.40, 1.08), (0.42, 1.28), (0.36, 1.5), (0.2, 1.66), (0.0, 1.71)], 30)]
DOLL[0][-1, 0] = 0.0


def doll_picture(coat, scarf, width=640, height=448):
    """A doll's painting round its lathe: u = 5/6 is the front, rows run down from the crown."""
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(DOLL[0], axis=0), axis=1))])
    length = (length + 0.40) / (length[-1] + 0.40)  # the flat bottom comes first
    v, u = (np.mgrid[0:height, 0:width] + 0.5) / np.array([height, width]).reshape(2, 1, 1)
    y = np.interp(1 - v, length, DOLL[0][:, 1])
    x = ((u - 5 / 6 + 0.5) % 1 - 0.5) * 2 * np.pi * 0.46  # along the belly's circumference
    ellipse = lambda cx, cy, rx, ry: np.sqrt(((x - cx) / rx) ** 2 + ((y - cy) / ry) ** 2)
    paint = lambda colour, code, edge, soft=0.03: mix(colour, bytes_of(code), smoothstep(1 + soft, 1 - soft, edge)[..., None])
    picture = np.broadcast_to(bytes_of(coat), (height, width, 3))
    scalloped = 1.04 + 0.035 * np.cos(x * 30)
    picture = np.where((y > scalloped)[..., None], bytes_of(scarf), picture)
    dots = (np.hypot((x * 9 + 0.5 * np.floor(y * 11 % 2)) % 1 - 0.5, (y * 11) % 1 - 0.5) < 0.17) & (y > scalloped + 0.04)
    picture = np.where(dots[..., None], bytes_of("#f6e7c4"), picture)
    picture = paint(picture, "#f6e7c4", ellipse(0, 1.31, 0.30, 0.245))
    picture = paint(picture, "#5a3420", ellipse(0, 1.32, 0.272, 0.222))
    picture = paint(picture, "#f7d9bd", ellipse(0, 1.285, 0.235, 0.195))
    for side in (-1, 1):
        fringe = np.maximum(ellipse(0.15 * side, 1.47, 0.15, 0.10), ellipse(0, 1.32, 0.272, 0.222))
        picture = paint(picture, "#5a3420", fringe)
        picture = paint(picture, "#f0a08c", ellipse(0.135 * side, 1.235, 0.052, 0.045), 0.4)
        picture = paint(picture, "#ffffff", ellipse(0.085 * side, 1.315, 0.042, 0.034))
        picture = paint(picture, "#2d4a63", ellipse(0.08 * side, 1.313, 0.024, 0.029))
        picture = paint(picture, "#5a3420", ellipse(0.085 * side, 1.375, 0.05, 0.010))
    picture = paint(picture, "#c23b33", ellipse(0, 1.185, 0.042, 0.018))
    picture = paint(picture, "#f6e7c4", ellipse(0, 0.52, 0.36, 0.40))
    picture = paint(picture, coat, ellipse(0, 0.52, 0.335, 0.375))
    for cx, cy, r, code in ((0, 0.55, 0.15, "#e9b44c"), (-0.17, 0.34, 0.1, "#f3e3d3"), (0.17, 0.34, 0.1, "#f3e3d3"), (0, 0.80, 0.08, "#f3e3d3")):
        a = np.arctan2(y - cy, x - cx)
        for leaf in (-0.9, 4.0):
            picture = paint(picture, "#4f8a5b", ellipse(cx + 1.25 * r * np.cos(leaf), cy + 1.25 * r * np.sin(leaf), 0.6 * r, 0.38 * r))
        picture = paint(picture, code, np.hypot(x - cx, y - cy) / (r * (0.78 + 0.22 * np.cos(6 * a))))
        picture = paint(picture, "#a3422f", np.hypot(x - cx, y - cy) / (0.34 * r))
    stripe = (np.abs(y - 0.06) < 0.018) | (np.abs(y - 0.12) < 0.008)
    return png(np.where(stripe[..., None], bytes_of("#f6e7c4"), picture), 64)


def dolls(path):
    """Three lacquered dolls whose faces are textures (map_Kd)."""
    o = Obj()
    body = lathe([np.array([(0.0, 0.0), (0.40, 0.0)]), *DOLL], 30)
    for name, coat, scarf, place, size in (("poppy", "#b8322e", "#e0a032", (-0.62, 0, -0.3), 1.0), ("teal", "#23696f", "#c9503c", (0.38, 0, 0.1), 0.78),
                                           ("plum", "#6d3a63", "#5e9a82", (-0.12, 0, 0.78), 0.54)):
        picture = f"{path.stem}_{name}.png"
        (path.parent / picture).write_bytes(doll_picture(coat, scarf))
        o.material(name, Kd=(1, 1, 1), map_Kd=picture, Pr=0.16, Pm=0)
        o.add(name, name, body.scaled(size).moved(*place), uv=True)
    o.save(path)
