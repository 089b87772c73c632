"""A small writer of Wavefront OBJ with a material library."""


class Obj:
    """Objects of one material each; vertices and normals that print alike are shared within the file."""

    def __init__(self, digits=3):
        self.digits = digits
        self.lines, self.materials = [], []
        self.seen = {"v": {}, "vt": {}, "vn": {}}

    def material(self, name, **statements):
        """Statements as in MTL: colours are tuples, pictures names, the rest numbers."""
        text = [f"newmtl {name}"]
        for key, value in statements.items():
            numbers = value if isinstance(value, tuple) else (value,)
            text.append(f"{key} " + " ".join(v if isinstance(v, str) else f"{float(v):.4g}" for v in numbers))
        self.materials.append("\n".join(text))

    def _index(self, kind, row, digits):
        text = " ".join(f"{v:.{digits}f}".replace("-0." + "0" * digits, "0." + "0" * digits) for v in row)
        known = self.seen[kind]
        if text not in known:
            known[text] = len(known) + 1
            self.lines.append(f"{kind} {text}")
        return known[text]

    def add(self, name, material, *meshes, uv=False):
        """Meshes as one object; pairs of triangles that came from a quadrilateral are written as one."""
        self.lines += [f"o {name}", f"usemtl {material}"]
        for mesh in meshes:
            v = [self._index("v", row, self.digits) for row in mesh.pos]
            n = [self._index("vn", row, 2) for row in mesh.nrm]
            t = [self._index("vt", (a, 1 - b), 4) for a, b in mesh.uv] if uv else [""] * len(v)
            tri, k = mesh.tri.tolist(), 0
            while k < len(tri):
                face = tri[k]
                k += 1
                if k < len(tri) and (shared := joined(face, tri[k])):
                    face = shared
                    k += 1
                corners = list(dict.fromkeys(f"{v[i]}/{t[i]}/{n[i]}" for i in face))
                if len({v[i] for i in face}) >= 3:
                    self.lines.append("f " + " ".join(corners))

    def save(self, path):
        path.with_suffix(".mtl").write_text("\n\n".join(self.materials) + "\n")
        path.write_text(f"# Kiln sample, CC0-1.0\nmtllib {path.stem}.mtl\n" + "\n".join(self.lines) + "\n")


def joined(t, s):
    """The quadrilateral of two triangles as `grid_triangles` makes them, or None."""
    if t[0] == s[0] and t[2] == s[1]:
        return [*t, s[2]]
    if t[2] == s[2] and t[0] == s[1]:  # the same, turned over
        return [t[0], t[1], t[2], s[0]]
    return None
