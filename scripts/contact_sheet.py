#!/usr/bin/env python3
"""Lays the PNG pictures of a folder out as one picture: contact_sheet.py FOLDER OUT.png [--columns N] [--width N]

Needs Pillow. Transparent pictures are laid over the card's colour. The sheet is made narrower until it fits --max-kb.
"""
import argparse
import io
from pathlib import Path

from PIL import Image, ImageDraw

PAPER, CARD = (255, 255, 255), (238, 236, 231)


def rounded_mask(size, radius):
    """A mask with round corners, smoothed by reducing one of four times the size."""
    mask = Image.new("L", (4 * size, 4 * size), 0)
    ImageDraw.Draw(mask).rounded_rectangle((0, 0, 4 * size - 1, 4 * size - 1), 4 * radius, fill=255)
    return mask.resize((size, size), Image.Resampling.LANCZOS)


def sheet(pictures, columns, width, gap):
    """The pictures in reading order, each on a card."""
    size = (width - gap * (columns - 1)) // columns
    rows = -(-len(pictures) // columns)
    out = Image.new("RGB", (columns * size + (columns - 1) * gap, rows * size + (rows - 1) * gap), PAPER)
    mask = rounded_mask(size, 10)
    for k, path in enumerate(pictures):
        card = Image.new("RGBA", (size, size), (*CARD, 255))
        card.alpha_composite(Image.open(path).convert("RGBA").resize((size, size), Image.Resampling.LANCZOS))
        out.paste(card.convert("RGB"), (k % columns * (size + gap), k // columns * (size + gap)), mask)
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--columns", type=int, default=5)
    parser.add_argument("--width", type=int, default=1200)
    parser.add_argument("--gap", type=int, default=8)
    parser.add_argument("--max-kb", type=int, default=900)
    parser.add_argument("--order", default="", help="names without endings, separated by commas; the rest follows")
    args = parser.parse_args()
    order = args.order.split(",")
    name = lambda path: path.name.split(".")[0]
    rank = lambda path: (order.index(name(path)) if name(path) in order else len(order), path.name)
    pictures, width = sorted(args.folder.glob("*.png"), key=rank), args.width
    while True:
        data = io.BytesIO()
        picture = sheet(pictures, args.columns, width, args.gap)
        picture.save(data, "PNG", optimize=True)
        if data.tell() <= args.max_kb * 1000 or width < 200:
            break
        width -= 20
    args.out.write_bytes(data.getvalue())
    print(f"{args.out}: {picture.width}x{picture.height}, {data.tell() / 1000:.0f} kB")


if __name__ == "__main__":
    main()
