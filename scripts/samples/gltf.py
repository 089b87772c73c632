"""A small deterministic writer of glTF 2.0, as one .glb, as .gltf with its resources in a folder, or as .gltf alone."""
import json
import struct
from base64 import b64encode
from urllib.parse import quote

import numpy as np

from .shapes import unit


class Gltf:
    """Collects meshes, materials, pictures, lights and nodes; `save_…` writes them."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0", "generator": "Kiln scripts/make_samples.py", "copyright": "CC0-1.0"},
                     "scene": 0, "scenes": [{"nodes": []}], "nodes": []}
        self.bin = bytearray()
        self.used = set()
        self.pictures = []

    def _add(self, kind, item):
        self.json.setdefault(kind, []).append(item)
        return len(self.json[kind]) - 1

    def _view(self, data, target=None):
        self.bin += b"\0" * (-len(self.bin) % 4)
        view = {"buffer": 0, "byteOffset": len(self.bin), "byteLength": len(data)}
        if target:
            view["target"] = target
        self.bin += data
        return self._add("bufferViews", view)

    def _accessor(self, values, kind, target=34962, normalized=False):
        values = np.ascontiguousarray(values)
        component = {"float32": 5126, "uint32": 5125, "uint16": 5123, "uint8": 5121}[values.dtype.name]
        item = {"bufferView": self._view(values.tobytes(), target), "componentType": component,
                "count": len(values), "type": kind}
        if normalized:
            item["normalized"] = True
        if kind == "VEC3" and target == 34962:
            item["min"], item["max"] = values.min(0).tolist(), values.max(0).tolist()
        return self._add("accessors", item)

    def geometry(self, mesh, uv=False):
        """Uploads a mesh once; several materials may then share it through `mesh`."""
        quantised = lambda a: np.round(a, 5).astype(np.float32) + np.float32(0)
        attributes = {"POSITION": self._accessor(quantised(mesh.pos), "VEC3"),
                      "NORMAL": self._accessor(unit(np.round(mesh.nrm, 5)).astype(np.float32), "VEC3")}
        if uv:
            attributes["TEXCOORD_0"] = self._accessor(quantised(mesh.uv), "VEC2")
        if mesh.col is not None:
            colour = np.round(np.clip(mesh.col, 0, 1) * 255).astype(np.uint8)
            attributes["COLOR_0"] = self._accessor(colour, "VEC4", normalized=True)
        index = mesh.tri.reshape(-1).astype(np.uint16 if len(mesh.pos) < 65535 else np.uint32)
        return {"attributes": attributes, "indices": self._accessor(index, "SCALAR", 34963)}

    def mesh(self, name, *primitives):
        """A glTF mesh of (geometry, material) pairs."""
        return self._add("meshes", {"name": name, "primitives": [dict(g, material=m) for g, m in primitives]})

    def texture(self, name, png, wrap=10497):
        """A PNG with linear filtering."""
        samplers = self.json.setdefault("samplers", [])
        sampler = {"magFilter": 9729, "minFilter": 9987, "wrapS": wrap, "wrapT": wrap}
        if sampler not in samplers:
            samplers.append(sampler)
        self.pictures.append((name, png))
        image = self._add("images", {"name": name})
        return {"index": self._add("textures", {"source": image, "sampler": samplers.index(sampler)})}

    def material(self, name, color=(1, 1, 1), metallic=0.0, roughness=1.0, emission=None, maps=None, **more):
        """`maps`: baseColor, metallicRoughness, normal → texture. `more`: KHR extensions by short name, or core fields."""
        pbr = {"baseColorFactor": [round(float(c), 5) for c in color] + [1.0], "metallicFactor": metallic,
               "roughnessFactor": roughness}
        item = {"name": name, "pbrMetallicRoughness": pbr}
        for key, texture in (maps or {}).items():
            (item if key == "normal" else pbr)[key + "Texture"] = texture
        extensions = {}
        if emission is not None:
            peak = max(1.0, *emission)
            item["emissiveFactor"] = [round(c / peak, 5) for c in emission]
            if peak > 1:
                extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": peak}
        for key, value in more.items():
            if isinstance(value, dict):
                extensions["KHR_materials_" + key] = value
            else:
                item[key] = value
        if extensions:
            item["extensions"] = extensions
            self.used |= set(extensions)
        return self._add("materials", item)

    def node(self, parent=None, **fields):
        """A node, below `parent` or at the root; fields as in glTF, tuples welcome."""
        item = {k: [round(float(x), 6) for x in v] if isinstance(v, (tuple, list, np.ndarray)) else v
                for k, v in fields.items()}
        index = self._add("nodes", item)
        above = self.json["scenes"][0]["nodes"] if parent is None else self.json["nodes"][parent].setdefault("children", [])
        above.append(index)
        return index

    def put(self, name, mesh, material, uv=False, **fields):
        """A mesh with one material, placed once."""
        return self.node(name=name, mesh=self.mesh(name, (self.geometry(mesh, uv), material)), **fields)

    def camera(self, eye, target, vertical_degrees, name="camera"):
        camera = {"type": "perspective", "perspective": {"yfov": round(float(np.radians(vertical_degrees)), 6), "znear": 0.01}}
        self.node(name=name, camera=self._add("cameras", camera), matrix=looking(eye, target))

    def light(self, name, kind, color, intensity, eye, target=(0, 0, 0), **spot):
        """KHR_lights_punctual at `eye`, shining at `target`."""
        light = {"name": name, "type": kind, "color": list(color), "intensity": intensity}
        if spot:
            light["spot"] = spot
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(light)
        self.used.add("KHR_lights_punctual")
        self.node(name=name, matrix=looking(eye, target), extensions={"KHR_lights_punctual": {"light": len(lights) - 1}})

    def _finish(self):
        self.bin += b"\0" * (-len(self.bin) % 4)
        self.json["buffers"] = [{"byteLength": len(self.bin)}]
        if self.used:
            self.json["extensionsUsed"] = sorted(self.used)

    def save_glb(self, path):
        for image, (_, png) in zip(self.json.get("images", []), self.pictures):
            image.update(bufferView=self._view(png), mimeType="image/png")
        self._finish()
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        path.write_bytes(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(self.bin))
                         + struct.pack("<II", len(text), 0x4E4F534A) + text
                         + struct.pack("<II", len(self.bin), 0x004E4942) + self.bin)

    def save_gltf(self, path, folder, buffer_name):
        """Resources go to `folder` beside the file; URIs are percent-encoded as RFC 3986 wants."""
        (path.parent / folder).mkdir(exist_ok=True)
        for image, (name, png) in zip(self.json.get("images", []), self.pictures):
            image["uri"] = quote(f"{folder}/{name}.png")
            (path.parent / folder / f"{name}.png").write_bytes(png)
        self._finish()
        self.json["buffers"][0]["uri"] = quote(f"{folder}/{buffer_name}")
        (path.parent / folder / buffer_name).write_bytes(self.bin)
        path.write_text(json.dumps(self.json, indent=1) + "\n")

    def save_embedded(self, path):
        """A .gltf without companions: its buffer is a data: URI. For assets without pictures."""
        self._finish()
        self.json["buffers"][0]["uri"] = "data:application/octet-stream;base64," + b64encode(self.bin).decode()
        path.write_text(json.dumps(self.json, indent=1) + "\n")


def looking(eye, target):
    """Column-major matrix of a node at `eye` whose −Z looks at `target`."""
    eye, target = np.asarray(eye, float), np.asarray(target, float)
    z = unit(eye - target)
    x = unit(np.cross((0, 1, 0) if abs(z[1]) < 0.999 else (0, 0, -1), z))
    return [round(float(v), 6) for v in (*x, 0, *np.cross(z, x), 0, *z, 0, *eye, 1)]
