"""Small scenes as text: OBJ, glTF with its buffer inside, .ray, and the TOML file of a check."""
import json
import struct
import zlib
from base64 import b64encode
from math import radians


def quad(a, b, c, d):
    """Two triangles; the front is where the corners run counter-clockwise."""
    return [(a, b, c), (a, c, d)]


def box(low=(-1, -1, -1), high=(1, 1, 1), inward=False):
    """Twelve triangles, fronts outward or inward."""
    triangles = []
    for axis in range(3):
        for side in (0, 1):
            corners = []
            for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = [0, 0, 0]
                for k, s in ((axis, side), ((axis + 1) % 3, p), ((axis + 2) % 3, q)):
                    corner[k] = (low, high)[s][k]
                corners.append(tuple(corner))
            triangles += quad(*(corners if (side == 1) != inward else corners[::-1]))
    return triangles


def icosphere(levels, centre=(0, 0, 0), radius=1.0):
    """A faceted sphere, fronts outward."""
    golden = (1 + 5**0.5) / 2
    unit = lambda p: tuple(x / sum(y * y for y in p) ** 0.5 for x in p)
    corners = [unit(p) for a, b in ((1, golden), (-1, golden), (1, -golden), (-1, -golden))
               for p in ((0, a, b), (a, b, 0), (b, 0, a))]
    dot = lambda p, q: sum(x * y for x, y in zip(p, q))
    cross = lambda p, q: (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])
    faces = []
    for i, p in enumerate(corners):
        for j, q in enumerate(corners[:i]):
            for r in corners[:j]:
                if min(dot(p, q), dot(q, r), dot(r, p)) > 0:
                    faces.append((p, q, r) if dot(cross(p, q), r) > 0 else (p, r, q))
    for _ in range(levels):
        finer = []
        for p, q, r in faces:
            pq, qr, rp = (unit(tuple(x + y for x, y in zip(*e))) for e in ((p, q), (q, r), (r, p)))
            finer += [(p, pq, rp), (pq, q, qr), (rp, qr, r), (pq, qr, rp)]
        faces = finer
    return [tuple(tuple(c + radius * x for c, x in zip(centre, p)) for p in t) for t in faces]


def number(x):
    return repr(float(x)) if not float(x).is_integer() or abs(x) > 1e15 else str(int(x))


def numbers(values):
    return " ".join(number(x) for x in values)


def write_obj(folder, name, parts):
    """`parts`: (material as a dict of MTL statements, triangles). Shared corners are shared vertices."""
    lines, mtl, index = [f"mtllib {name}.mtl"], [], {}
    for k, (material, triangles) in enumerate(parts):
        mtl.append(f"newmtl m{k}")
        for key, value in material.items():
            mtl.append(f"{key} {numbers(value) if isinstance(value, (tuple, list)) else number(value)}")
        faces = []
        for triangle in triangles:
            for corner in triangle:
                if corner not in index:
                    index[corner] = len(index) + 1
                    lines.append(f"v {numbers(corner)}")
            faces.append("f " + " ".join(str(index[c]) for c in triangle))
        lines += [f"usemtl m{k}", *faces]
    (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")
    (folder / f"{name}.mtl").write_text("\n".join(mtl) + "\n")
    return f"{name}.obj"


def png(width, height, rgb_rows):
    """8-bit RGB, stored without compression so that every zlib writes the same bytes."""
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    raw = b"".join(b"\0" + bytes(c for texel in row for c in texel) for row in rgb_rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(raw, 0)) + chunk(b"IEND", b""))


def material(color=(1, 1, 1), alpha=1.0, metallic=0.0, roughness=1.0, emission=0.0, double_sided=True, **extensions):
    """A glTF material; `extensions`: KHR_materials_… by short name, or core fields with a capital-free name."""
    item = {"pbrMetallicRoughness": {"baseColorFactor": [*color, alpha], "metallicFactor": metallic,
                                     "roughnessFactor": roughness}, "doubleSided": double_sided}
    if emission:
        item["emissiveFactor"] = [1, 1, 1]
        extensions["emissive_strength"] = {"emissiveStrength": emission}
    for key, value in extensions.items():
        if key in ("alphaMode", "alphaCutoff", "normalTexture"):
            item[key] = value
        elif key == "base_texture":
            item["pbrMetallicRoughness"]["baseColorTexture"] = value
        else:
            item.setdefault("extensions", {})["KHR_materials_" + key] = value
    return item


def lambert(albedo, **more):
    return material((albedo,) * 3, specular={"specularFactor": 0}, **more)


def glass(ior, roughness=0.0, color=(1, 1, 1), attenuation=None, **more):
    volume = {"thicknessFactor": 1}
    if attenuation:
        volume |= {"attenuationColor": attenuation, "attenuationDistance": 1}
    return material(color, roughness=roughness, transmission={"transmissionFactor": 1}, ior={"ior": ior},
                    volume=volume, **more)


def write_gltf(folder, name, parts, lights=(), images=(), camera=None):
    """`parts`: dicts of triangles, material and optionally matrix (rows), normals, colors, uvs (per corner). `lights`:
    (KHR_lights_punctual light, matrix rows); `camera`: (vertical field of view in degrees, matrix rows). Unindexed, so that
    what has no normals is flat."""
    data, views, accessors, meshes, nodes, materials = bytearray(), [], [], [], [], []

    def accessor(values, kind):
        flat = [x for v in values for x in v]
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": 4 * len(flat)})
        data.extend(struct.pack(f"<{len(flat)}f", *flat))
        item = {"bufferView": len(views) - 1, "componentType": 5126, "count": len(values), "type": kind}
        if kind == "VEC3":
            item["min"], item["max"] = ([f(c) for c in zip(*values)] for f in (min, max))
        accessors.append(item)
        return len(accessors) - 1

    for part in parts:
        corners = lambda key: [c for t in part[key] for c in t]
        attributes = {"POSITION": accessor(corners("triangles"), "VEC3")}
        for key, semantic, kind in (("normals", "NORMAL", "VEC3"), ("colors", "COLOR_0", "VEC4"),
                                    ("uvs", "TEXCOORD_0", "VEC2")):
            if key in part:
                attributes[semantic] = accessor(corners(key), kind)
        if part["material"] not in materials:
            materials.append(part["material"])
        material = materials.index(part["material"])
        meshes.append({"primitives": [{"attributes": attributes, "material": material}]})
        for matrix in part.get("matrices", [part.get("matrix")]):
            node = {"mesh": len(meshes) - 1}
            if matrix:
                node["matrix"] = [row[c] for c in range(4) for row in matrix]
            nodes.append(node)
    document = {"asset": {"version": "2.0", "generator": "Kiln scripts/make_checks.py", "copyright": "CC0-1.0"},
                "scene": 0, "scenes": [{"nodes": []}], "nodes": nodes, "meshes": meshes, "materials": materials,
                "accessors": accessors, "bufferViews": views}
    if lights:
        document["extensions"] = {"KHR_lights_punctual": {"lights": [light for light, _ in lights]}}
        for k, (_, matrix) in enumerate(lights):
            nodes.append({"matrix": [row[c] for c in range(4) for row in matrix],
                          "extensions": {"KHR_lights_punctual": {"light": k}}})
    if camera:
        document["cameras"] = [{"type": "perspective", "perspective": {"yfov": radians(camera[0]), "znear": 1e-3, "aspectRatio": 1}}]
        nodes.append({"camera": 0, "matrix": [row[c] for c in range(4) for row in camera[1]]})
    if images:
        uri = lambda image: "data:image/png;base64," + b64encode(image).decode()
        document["images"] = [{"uri": uri(image)} for image in images]
        document["samplers"] = [{"magFilter": 9728, "minFilter": 9728}]
        document["textures"] = [{"source": k, "sampler": 0} for k in range(len(images))]
    document["scenes"][0]["nodes"] = list(range(len(nodes)))
    used = {e for m in materials for e in m.get("extensions", {})} | ({"KHR_lights_punctual"} if lights else set())
    if used:
        document["extensionsUsed"] = sorted(used)
    document["buffers"] = [{"byteLength": len(data),
                            "uri": "data:application/octet-stream;base64," + b64encode(bytes(data)).decode()}]
    (folder / f"{name}.gltf").write_text(json.dumps(document, indent=1) + "\n")
    return f"{name}.gltf"


def write_ray(folder, name, *blocks):
    (folder / f"{name}.ray").write_text("\n".join(["SBT-raytracer 1.0", *blocks]) + "\n")
    return f"{name}.ray"


def ray_mesh(triangles, words):
    corners = sorted({c for t in triangles for c in t})
    tuple_text = lambda t: "(" + ", ".join(number(x) for x in t) + ")"
    return (f"trimesh {{ points = ({', '.join(tuple_text(c) for c in corners)}); "
            f"faces = ({', '.join(tuple_text([corners.index(c) for c in t]) for t in triangles)}); "
            f"material = {{ {words} }} }}")


def toml_value(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(toml_value(v) for v in value) + "]"
    return repr(value)


def toml(tables):
    """Plain keys first, then tables, then lists of tables."""
    lines = [f"{key} = {toml_value(value)}" for key, value in tables.items()
             if not isinstance(value, dict) and not (isinstance(value, list) and value and isinstance(value[0], dict))]
    for key, value in tables.items():
        many = value if isinstance(value, list) and value and isinstance(value[0], dict) else [value]
        for table in many:
            if isinstance(table, dict):
                lines += ["", f"[[{key}]]" if many is value else f"[{key}]"]
                lines += [f"{k} = {toml_value(v)}" for k, v in table.items()]
    return "\n".join(lines) + "\n"
