"""What many lamps cost: 1, 100, 1000 and 10 000 lamps over a floor that fills the picture, as points (`KHR_lights_punctual`), as
emissive triangles; and as emissive ones among ten thousand triangles in all, where rays cost the same whatever the number of lamps.
CPU seconds of light transport, 128 x 128, 64 samples, two scatterings, one thread, the least of three.

    python3 scripts/bench/lamps.py KILN [KILN...]
"""
import base64
import json
import math
import random
import struct
import subprocess
import sys
import tempfile
from pathlib import Path


def asset(count: int, kind: str) -> dict:
    """A glTF file with so many lamps."""
    random.seed(5)
    place = lambda: [random.uniform(-5, 5), random.uniform(0.3, 2), random.uniform(-5, 5)]
    data, views, accessors = bytearray(), [], []

    def rows(values: list, component: int, kind: str, **more) -> int:
        packed = struct.pack(f"<{len(values)}{'f' if component == 5126 else 'I'}", *values)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        data.extend(packed)
        width = {"VEC3": 3, "SCALAR": 1}[kind]
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(values) // width, "type": kind, **more})
        return len(accessors) - 1

    def mesh(points: list, indices: list, material: int) -> dict:
        box = {"min": [min(points[k::3]) for k in range(3)], "max": [max(points[k::3]) for k in range(3)]}
        primitive = {"attributes": {"POSITION": rows(points, 5126, "VEC3", **box)}, "material": material}
        return {"primitives": [{**primitive, "indices": rows(indices, 5125, "SCALAR")}]}

    grey = {"pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.7, 0.7, 1], "metallicFactor": 0}}
    lamp = {"emissiveFactor": [1, 1, 1], "doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}
    down = {"camera": 0, "translation": [0, 4.5, 0], "rotation": [-math.sqrt(0.5), 0, 0, math.sqrt(0.5)]}
    scene = {
        "asset": {"version": "2.0"},
        "materials": [grey, lamp, {**lamp, "emissiveFactor": [0, 0, 0]}],
        "meshes": [mesh([-5, 0, -5, 5, 0, -5, 5, 0, 5, -5, 0, 5], [0, 2, 1, 0, 3, 2], 0)],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.01, "aspectRatio": 1}}],
        "nodes": [{"mesh": 0}, down],
    }
    if kind == "points":
        lights = [{"type": "point", "intensity": 100 / count}] * count
        scene |= {"extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": lights}}}
        node = lambda i: {"translation": place(), "extensions": {"KHR_lights_punctual": {"light": i}}}
        scene["nodes"] += [node(i) for i in range(count)]
    else:
        triangles = count if kind == "triangles" else 10_000
        size, points = 0.6 / math.sqrt(triangles), []
        for _ in range(triangles):
            middle = place()
            points += [middle[k] + random.uniform(-size, size) for _ in range(3) for k in range(3)]
        for material, some in ((1, points[: 9 * count]), (2, points[9 * count :])):
            if some:
                scene["nodes"].append({"mesh": len(scene["meshes"])})
                scene["meshes"].append(mesh(some, list(range(len(some) // 3)), material))
    scene |= {"scene": 0, "scenes": [{"nodes": list(range(len(scene["nodes"])))}], "bufferViews": views, "accessors": accessors}
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return scene | {"buffers": [{"byteLength": len(data), "uri": uri}]}


def cpu(kiln: str, path: Path) -> float:
    """CPU seconds of light transport."""
    size = ["--width", "128", "--height", "128", "--spp", "64", "--adaptive", "off", "--max-depth", "2", "--threads", "1"]
    command = [kiln, "render", str(path), *size, "-q", "--json", "-o", str(path.with_suffix(".png"))]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return json.loads(said)["cpu_seconds"]["render"]


def main() -> None:
    kilns = sys.argv[1:]
    if not kilns:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("points", "triangles", "of-10000"):
            for count in (1, 100, 1000, 10_000):
                path = Path(folder) / f"{kind}{count}.gltf"
                path.write_text(json.dumps(asset(count, kind)))
                found = [[cpu(kiln, path) for kiln in kilns] for _ in range(3)]
                print(kind, count, *(f"{min(all):.3f}" for all in zip(*found)), flush=True)


if __name__ == "__main__":
    main()
