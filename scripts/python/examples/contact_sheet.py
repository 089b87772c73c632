#!/usr/bin/env python3
"""A contact sheet of every asset below a folder, with its name and its error. Needs Pillow.

    contact_sheet.py FOLDER SHEET.png [--size 192] [--error 6]
"""

# %% What is asked for.
import argparse
import math
from pathlib import Path

from PIL import Image, ImageDraw

import kiln

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("folder", type=Path)
parser.add_argument("sheet", type=Path)
parser.add_argument("--size", type=int, default=192)
parser.add_argument("--error", type=float, default=6.0)
arguments = parser.parse_args()

# %% Each asset becomes an array; what cannot be rendered is told and left out.
endings = {".gltf", ".glb", ".obj", ".ray"}
pictures = []
for path in sorted(p for p in arguments.folder.rglob("*") if p.suffix.lower() in endings):
    try:
        picture = kiln.render(path, width=arguments.size, error=arguments.error)
    except kiln.AssetError as error:
        print(f"{path}: {error} ({error.code})")
        continue
    print(f"{path}: error {picture.record['error']:.1f}, {picture.record['spp']} samples, {picture.record['seconds']:.2f} s")
    pictures.append((path.name, picture))

# %% The sheet: as wide as it is high, about.
columns = max(1, math.ceil(math.sqrt(len(pictures))))
line = arguments.size + 28
sheet = Image.new("RGB", (columns * arguments.size, math.ceil(len(pictures) / columns) * line or 1), "#f4f2ee")
draw = ImageDraw.Draw(sheet)
for number, (name, picture) in enumerate(pictures):
    x, y = number % columns * arguments.size, number // columns * line
    shown = Image.fromarray(picture.display())
    sheet.paste(shown, (x, y), shown)
    draw.text((x + 8, y + arguments.size + 4), f"{name}  ±{picture.record['error_bound']:.1f}", fill="#333")
sheet.save(arguments.sheet)
