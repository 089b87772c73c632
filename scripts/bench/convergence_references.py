"""Converged pictures that `convergence.py` measures errors against."""

import json
from dataclasses import dataclass

import numpy

from convergence_renderers import CACHE, read_exr

EPSILON = 0.01
# Material models differ between renderers here, so that each is measured against its own converged picture.
OWN = ("studio_knot", "studio_helmet")
# Samples per pixel of one render towards a reference of our own; each is kept as it is done.
SLICE = 1024


@dataclass
class Reference:
    """A converged picture, its relMSE to the truth, and where it comes from."""

    pixels: numpy.ndarray
    noise: float
    source: str

    def errors(self, pixels):
        """relMSE less the reference's noise, and the same without the worst 0.1 % of pixels (its noise included)."""
        squares = ((pixels - self.pixels) ** 2 / (self.pixels**2 + EPSILON)).mean(axis=2).ravel()
        squares.sort()
        kept = squares[: len(squares) - max(1, len(squares) // 1000)]
        return max(float(squares.mean()) - self.noise, 1e-9), float(kept.mean())


def stored(folder, name):
    """A picture of the shared folder and its noise."""
    facts = json.loads((folder / f"{name}.json").read_text())
    assert facts["relmse_eps"] == EPSILON
    return read_exr(folder / f"{name}.exr"), facts["noise_relmse"]


def own(scene, kiln, spp):
    """Kiln's own picture of at least `spp` samples, from two halves of different seeds. Slices that are there already are
    used again: remove the folder after a change of the light transport that is meant to change pictures."""
    folder = CACHE / "references" / scene.name
    folder.mkdir(parents=True, exist_ok=True)
    count = max(2, -(-spp // SLICE))
    slice_spp = min(SLICE, spp // 2)
    halves = [[], []]
    for k in range(count):
        path = folder / f"{slice_spp}.{k}.npy"
        if not path.exists():
            print(f"reference of {scene.name}: {slice_spp} spp, {k + 1} of {count}", flush=True)
            # Saved in single precision: its rounding is far below the noise.
            numpy.save(path, kiln.render(scene, slice_spp, 1_000_000 + k).pixels.astype(numpy.float32))
        halves[k % 2].append(numpy.load(path).astype(numpy.float64))
    a, b = (numpy.mean(half, axis=0) for half in halves)
    mean = (a + b) / 2
    # The variance of the mean is a quarter of that of the halves' difference.
    noise = float(((a - b) ** 2 / (mean**2 + EPSILON)).mean() / 4)
    return Reference(mean, noise, f"our own, {slice_spp * count} spp")


def reference(scene, kiln, spp, peer=None):
    """The reference of a scene for `peer`, or for Kiln; `kiln` renders it where it has to be our own."""
    folder = kiln.shared / "references"
    if scene.name in OWN and peer:
        return Reference(*stored(folder, f"{scene.name}.{peer}"), f"{peer}'s own for {peer}")
    if scene.name in OWN:
        return own(scene, kiln, spp)
    if (folder / f"{scene.name}.ref.exr").exists():
        pixels, noise = stored(folder, f"{scene.name}.ref")
        return Reference(pixels, noise, "mean of Mitsuba and Cycles")
    # Both weighted by how sure they are.
    found = [stored(folder, f"{scene.name}.{renderer}") for renderer in ("mitsuba", "cycles")]
    weights = [1 / noise for _, noise in found]
    mean = sum(weight * pixels for weight, (pixels, _) in zip(weights, found)) / sum(weights)
    return Reference(mean, 1 / sum(weights), "mean of Mitsuba and Cycles")
