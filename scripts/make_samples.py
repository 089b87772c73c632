#!/usr/bin/env python3
"""Writes the sample assets below scenes/samples, the same bytes on every run. All geometry and pictures come from
this script and scripts/samples/; the .ray files beside them are written by hand.

    python3 -m venv samples-venv
    samples-venv/bin/pip install numpy==2.4.6 pillow==13.0.0
    samples-venv/bin/python scripts/make_samples.py [NAME…]

Other versions of NumPy and Pillow make the same assets, but perhaps not the same bytes.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from samples import lit, models, nature, tabletop  # noqa: E402

SAMPLES = {
    "balloons.glb": nature.balloons,
    "chess.obj": models.chess,
    "coloured_spots.glb": lit.coloured_spots,
    "cornell_box.glb": lit.cornell_box,
    "desk_globe.gltf": nature.globe,
    "dolls.obj": models.dolls,
    "frosted_dice.gltf": tabletop.frosted_dice,
    "kintsugi.glb": tabletop.kintsugi,
    "metal_stairs.glb": tabletop.metal_stairs,
    "monstera.glb": nature.monstera,
    "reading_corner.obj": models.reading_corner,
    "tinted_glass.glb": tabletop.tinted_glass,
    "tree_of_lights.glb": lit.tree_of_lights,
}


def main(wanted):
    folder = Path(__file__).resolve().parent.parent / "scenes" / "samples"
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in SAMPLES.items():
        if not wanted or Path(name).stem in wanted or name in wanted:
            make(folder / name)
            print(f"{name}: {(folder / name).stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])
