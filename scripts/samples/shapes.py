"""Triangle meshes from a few generators: lathe, tube, rounded box, sphere, grid. Y is up, outsides face out."""
from dataclasses import dataclass, replace

import numpy as np

TAU = 2 * np.pi


@dataclass
class Mesh:
    """Vertices with unit normals, texture coordinates (v downwards) and optional linear RGBA colours."""

    pos: np.ndarray
    nrm: np.ndarray
    uv: np.ndarray
    tri: np.ndarray
    col: np.ndarray | None = None

    def moved(self, x=0.0, y=0.0, z=0.0):
        return replace(self, pos=self.pos + (x, y, z))

    def scaled(self, x, y=None, z=None):
        s = np.array([x, x if y is None else y, x if z is None else z], float)
        return replace(self, pos=self.pos * s, nrm=unit(self.nrm / s))

    def turned(self, degrees, axis="y"):
        m = rotation(degrees, axis)
        return replace(self, pos=self.pos @ m.T, nrm=self.nrm @ m.T)

    def coloured(self, rgb):
        return replace(self, col=np.tile([*rgb, 1.0], (len(self.pos), 1)))


def rotation(degrees, axis="y"):
    """Right-handed rotation matrix about a coordinate axis."""
    a = np.radians(degrees)
    c, s = np.cos(a), np.sin(a)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    m = np.eye(3)
    m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
    return m


def unit(v):
    v = np.asarray(v, float)
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)


def merge(*meshes):
    """One mesh of several; colours are kept when the first has them."""
    start = np.cumsum([0] + [len(m.pos) for m in meshes])
    col = np.concatenate([m.col for m in meshes]) if meshes[0].col is not None else None
    cat = lambda name: np.concatenate([getattr(m, name) for m in meshes])
    return Mesh(cat("pos"), cat("nrm"), cat("uv"), np.concatenate([m.tri + s for m, s in zip(meshes, start)]), col)


def oriented(pos, nrm, uv, tri):
    """Turns triangles so that they agree with their vertex normals, and drops those without an area."""
    tri = np.asarray(tri)
    face = np.cross(pos[tri[:, 1]] - pos[tri[:, 0]], pos[tri[:, 2]] - pos[tri[:, 0]])
    keep = np.linalg.norm(face, axis=1) > 1e-12
    flip = (face * nrm[tri].sum(1)).sum(1) < 0
    tri = np.where(flip[:, None], tri[:, ::-1], tri)[keep]
    return Mesh(np.asarray(pos, float), unit(nrm), np.asarray(uv, float), tri)


def grid_triangles(rows, cols):
    """Two triangles for each cell of a rows × cols lattice of vertices."""
    i = np.arange(rows - 1)[:, None] * cols + np.arange(cols - 1)[None]
    a, b, c, d = (i + k for k in (0, 1, cols + 1, cols))
    return np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2).reshape(-1, 3)


def surface(points, closed_normals=None):
    """A mesh of a lattice of points (rows, cols, 3); normals by central differences unless given, uv in [0, 1]²."""
    p = np.asarray(points, float)
    rows, cols = p.shape[:2]
    n = np.cross(np.gradient(p, axis=1), np.gradient(p, axis=0)) if closed_normals is None else closed_normals
    v, u = np.mgrid[0:rows, 0:cols] / np.array([rows - 1, cols - 1]).reshape(2, 1, 1)
    return oriented(p.reshape(-1, 3), unit(n).reshape(-1, 3), np.stack([u, v], -1).reshape(-1, 2),
                    grid_triangles(rows, cols))


def curve(points, n):
    """n points of a Catmull–Rom spline (centripetal) through the given ones."""
    p = np.asarray(points, float)
    p = np.vstack([2 * p[0] - p[1], p, 2 * p[-1] - p[-2]])
    t = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1) ** 0.5)])
    out = []
    for x in np.linspace(t[1], t[-2], n):
        k = min(max(int(np.searchsorted(t, x, "right")) - 1, 1), len(p) - 3)
        a, b = [p[k - 1 + i] for i in range(4)], t[k - 1:k + 3]
        lerp = lambda q, r, i, j: (b[j] - x) / (b[j] - b[i]) * q + (x - b[i]) / (b[j] - b[i]) * r
        a1, a2, a3 = lerp(a[0], a[1], 0, 1), lerp(a[1], a[2], 1, 2), lerp(a[2], a[3], 2, 3)
        out.append(lerp(lerp(a1, a2, 0, 2), lerp(a2, a3, 1, 3), 1, 2))
    return np.array(out)


def arc(cr, cy, radius, start, end, n):
    """Points (r, y) of a circle's arc in the profile plane, degrees from +r towards +y."""
    a = np.radians(np.linspace(start, end, n))
    return np.stack([cr + radius * np.cos(a), cy + radius * np.sin(a)], -1)


def lathe(profile, segments=48):
    """A body of revolution around y. `profile` is a list of smooth runs of (r, y) that meet in creases; walked so
    that the outside is on the right hand (up the outside of a body). u goes round, v falls along the profile."""
    runs = [np.asarray(run, float) for run in profile]
    total = sum(np.linalg.norm(np.diff(run, axis=0), axis=1).sum() for run in runs)
    angle = np.linspace(0, TAU, segments + 1)
    cos, sin = np.cos(angle), -np.sin(angle)  # u runs to the right, seen from outside
    cos[-1], sin[-1] = cos[0], sin[0]
    parts, done = [], 0.0
    for run in runs:
        length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(run, axis=0), axis=1))])
        tangent = unit(np.gradient(run, axis=0))
        nr, ny = tangent[:, 1], -tangent[:, 0]
        r, y = np.maximum(run[:, 0], 0.0), run[:, 1]
        pos = np.stack([r[:, None] * cos, np.broadcast_to(y[:, None], (len(r), len(cos))), r[:, None] * sin], -1)
        nrm = np.stack([nr[:, None] * cos, np.broadcast_to(ny[:, None], (len(r), len(cos))), nr[:, None] * sin], -1)
        v = np.broadcast_to(1 - (done + length)[:, None] / total, (len(r), len(cos)))
        u = np.broadcast_to(angle / TAU, (len(r), len(cos)))
        parts.append(oriented(pos.reshape(-1, 3), nrm.reshape(-1, 3), np.stack([u, v], -1).reshape(-1, 2),
                              grid_triangles(len(r), len(cos))))
        done += length[-1]
    return merge(*parts)


def cylinder(radius, y0, y1, segments=48, top=None, bevel=0.0):
    """A capped cylinder (a cone's stump with `top` ≠ radius), its edges bevelled round."""
    top = radius if top is None else top
    if bevel == 0.0:
        return lathe([[(0, y0), (radius, y0)], [(radius, y0), (top, y1)], [(top, y1), (0, y1)]], segments)
    low, high = arc(radius - bevel, y0 + bevel, bevel, -90, 0, 5), arc(top - bevel, y1 - bevel, bevel, 0, 90, 5)
    return lathe([[(0, y0), (radius - bevel, y0)], np.vstack([low, high]), [(top - bevel, y1), (0, y1)]], segments)


def sphere(radius=1.0, rings=24, segments=48):
    """A sphere of latitude and longitude."""
    return lathe([arc(0, 0, radius, -90, 90, rings + 1)], segments)


def octasphere(level):
    """A unit sphere by subdividing an octahedron: 8·4^level triangles."""
    v = [np.array(p, float) for p in [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]]
    f = [(a, c, e) for a, c, e in [(0, 2, 4), (4, 2, 1), (1, 2, 5), (5, 2, 0), (4, 3, 0), (1, 3, 4), (5, 3, 1), (0, 3, 5)]]
    for _ in range(level):
        known, finer = {}, []
        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in known:
                v.append(unit(v[a] + v[b]))
                known[key] = len(v) - 1
            return known[key]
        for a, b, c in f:
            x, y, z = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, x, z), (b, y, x), (c, z, y), (x, y, z)]
        f = finer
    pos = np.array(v)
    return oriented(pos, pos, np.zeros((len(pos), 2)), f)


def tube(path, radius, sides=12, caps=True):
    """A round tube along a path of points; radius is a number or one per point."""
    p = np.asarray(path, float)
    radius = np.broadcast_to(np.asarray(radius, float), (len(p),))
    tangent = unit(np.gradient(p, axis=0))
    side = unit(np.cross(tangent[0], (0, 0, 1) if abs(tangent[0][2]) < 0.9 else (1, 0, 0)))
    sides_of = []
    for t in tangent:  # parallel transport
        side = unit(side - t * (side @ t))
        sides_of.append(side)
    a = np.array(sides_of)
    b = np.cross(tangent, a)
    angle = np.linspace(0, TAU, sides + 1)
    ring = a[:, None] * np.cos(angle)[None, :, None] + b[:, None] * np.sin(angle)[None, :, None]
    body = surface(p[:, None] + radius[:, None, None] * ring, ring)
    if not caps:
        return body
    ends = []
    for k, sign in ((0, -1), (-1, 1)):
        rim = p[k] + radius[k] * ring[k][:-1]
        pos = np.vstack([p[k], rim])
        tri = [(0, 1 + i, 1 + (i + 1) % sides) for i in range(sides)]
        ends.append(oriented(pos, np.tile(sign * tangent[k], (sides + 1, 1)), np.zeros((sides + 1, 2)), tri))
    return merge(body, *ends)


def torus(radius, thickness, segments=48, sides=16):
    """A ring around y."""
    return lathe([arc(radius, 0, thickness, -180, 180, sides + 1)], segments)


def rounded_box(sx, sy, sz, radius=0.02, steps=3):
    """A box around the origin with its edges rounded; a plain one when radius is 0."""
    half = np.array([sx, sy, sz], float) / 2
    radius = min(radius, half.min())
    t = np.array([-1.0, 1.0])
    if radius > 0:
        edge = np.linspace(0, 1, steps + 1)
        t = np.concatenate([-1 - (1 - edge), 1 + edge])  # |t| − 1 walks over the rounding
    parts = []
    for axis in range(3):
        for sign in (-1, 1):
            i, j = [k for k in range(3) if k != axis]
            a, b = np.meshgrid(t, t, indexing="ij")
            d = np.zeros((len(t), len(t), 3))
            over = lambda x: np.sign(x) * np.tan(np.clip(np.abs(x) - 1, 0, 1) * np.pi / 4)
            d[..., i], d[..., j], d[..., axis] = over(a), over(b), sign
            core = np.zeros_like(d)
            core[..., i], core[..., j], core[..., axis] = np.sign(a), np.sign(b), sign
            parts.append(surface(core * (half - radius) + unit(d) * radius, unit(d)))
    return merge(*parts)


def quad(a, b, c, d):
    """A flat parallelogram, counter-clockwise seen from its front."""
    pos = np.array([a, b, c, d], float)
    n = unit(np.cross(pos[1] - pos[0], pos[2] - pos[0]))
    return Mesh(pos, np.tile(n, (4, 1)), np.array([(0, 1), (1, 1), (1, 0), (0, 0)], float), np.array([(0, 1, 2), (0, 2, 3)]))
