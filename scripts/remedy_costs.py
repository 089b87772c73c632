#!/usr/bin/env python3
"""What remedies cost: instructions with each taken away, `python3 scripts/remedy_costs.py WORK SCENE VIEW.json [SPP]`, after
mutate_checks.py WORK build.

Counted by Valgrind's callgrind, less what the same program counts at 1 sample a pixel; one thread, 24×24 pixels. Remedies whose
absence changes where paths go, or what has no part in the scene, are not comparable and left out.
"""
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from mutations import MUTATIONS

COMPARABLE = ("no-offset no-plane-error edges-in-f32 strict-edges limit-too-near tie-by-order no-lift unbent-normal "
              "sums-in-f32 ggx-by-alpha2-1 single-scattering solid-angle-never").split()


def instructions(kiln, scene, view, spp, bits):
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", kiln, "render", scene, "--view", view,
               "-o", os.path.join(tempfile.gettempdir(), "cost.exr"), "--spp", str(spp), "--width", "24", "--height", "24", "--threads", "1", "--quiet"]
    out = subprocess.run(command, env={**os.environ, "KILN_MUTATION": str(bits)}, capture_output=True, text=True).stderr
    return int(re.search(r"Collected : (\d+)", out).group(1))


def main(work, scene, view, spp=9):
    kiln = work / "target" / "release" / "kiln"
    base = instructions(kiln, scene, view, 1, 0)
    whole = instructions(kiln, scene, view, spp, 0) - base
    print(f"{Path(scene).stem}: {whole / (24 * 24 * (spp - 1)):.0f} instructions a path\n\n| remedy taken away | instructions |\n| --- | --- |", flush=True)
    for bit, (name, *_) in enumerate(MUTATIONS):
        if name in COMPARABLE:
            without = instructions(kiln, scene, view, spp, 1 << bit) - base
            print(f"| `{name}` | {100 * (without / whole - 1):+.2f} % |", flush=True)
    every = sum(1 << bit for bit, (name, *_) in enumerate(MUTATIONS) if name in COMPARABLE and name not in ("solid-angle-never", "single-scattering"))
    print(f"| all but the last two | {100 * ((instructions(kiln, scene, view, spp, every) - base) / whole - 1):+.2f} % |")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3], int(sys.argv[4]) if len(sys.argv) > 4 else 9)
