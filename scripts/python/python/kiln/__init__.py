"""Kiln turns 3D assets (glTF, OBJ, .ray) into path-traced pictures.

>>> import kiln
>>> scene = kiln.load("chair.glb")
>>> picture = kiln.render(scene, width=512, error=4)      # a NumPy array, linear light
>>> picture.shape, picture.record["error"]
((512, 512, 4), 3.81)
>>> picture.display()                                     # 8-bit sRGB, for Pillow and the like

Pixels depend on the asset, the settings and the seed alone: the same numbers as `kiln render` writes to its EXR file, on any
machine and with any number of threads. Renders free the interpreter for other threads and stop on Ctrl-C. Threads do not
survive a fork: with `multiprocessing`, use the start method "spawn".
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from . import _kiln
from ._kiln import AssetError, __version__, set_threads

__all__ = ["AssetError", "Batch", "Picture", "Scene", "__version__", "batch", "load", "render", "set_threads", "turntable"]


class Picture(np.ndarray):
    """Linear Rec. 709 radiance, float32 of shape (height, width, 4), premultiplied by the coverage in the last channel.

    It is an array like any other; arithmetic gives plain arrays' results with the record of this picture.

    Attributes:
        layers: arrays by name: "beauty" (this picture), "variance" (height, width, 3: of the pixel's mean; missing with one
            sample), "samples" (height, width, 1: how many each pixel got).
        record: what is known of the picture: "error" and "error_bound" (RMS as displayed, 0-255 levels, and its upper 95 %
            bound), "relmse", "spp", "exposure" (EV), "ended" ("samples", "error" or "deadline"), "light", "warnings",
            "scene", "seconds".
    """

    layers: dict[str, np.ndarray]
    record: dict[str, Any]

    def __array_finalize__(self, source: Any) -> None:
        self.layers = getattr(source, "layers", {})
        self.record = getattr(source, "record", {})

    def display(self, *, exposure: float | None = None, tonemap: str = "neutral", background: str = "transparent") -> np.ndarray:
        """The picture as a screen shows it: uint8 of shape (height, width, 4), sRGB with straight alpha.

        Args:
            exposure: EV; by default the picture's own.
            tonemap: "neutral" (Khronos PBR Neutral), "aces", "agx" or "none".
            background: "transparent" or a colour as "#rrggbb".
        """
        ev = self.record.get("exposure", 0.0) if exposure is None else exposure
        linear = np.ascontiguousarray(self, dtype="<f4")
        if linear.ndim != 3 or linear.shape[2] != 4:
            raise ValueError(f"a picture has the shape (height, width, 4), not {self.shape}")
        shown = _kiln.develop(linear.tobytes(), float(ev), tonemap, background)
        return np.frombuffer(shown, np.uint8).reshape(linear.shape)


class Scene:
    """An asset that was read; make one with `load`.

    What it takes to render it (lights, kd-tree) is kept from one render to the next.
    """

    def __init__(self, native: _kiln.Scene) -> None:
        self._native = native
        self._facts: dict[str, Any] = json.loads(native.facts())

    @property
    def path(self) -> str:
        """The asset's file."""
        return os.fspath(self._native.path)

    @property
    def warnings(self) -> list[dict[str, str]]:
        """What was mended or left out, each with "code", "place" and "message"."""
        return list(self._facts["warnings"])

    def inspect(self) -> dict[str, Any]:
        """What is in the asset: triangles, materials, textures, lights, cameras, animations, variants, warnings …

        The fields are those of `kiln inspect --json` (docs/inspect.md) without the kd-tree.
        """
        facts: dict[str, Any] = json.loads(self._native.facts())
        return facts

    def __repr__(self) -> str:
        return f"<kiln.Scene {self.path!r}: {self._facts['triangles']} triangles>"


def load(
    path: str | os.PathLike[str],
    *,
    root: str | os.PathLike[str] | None = None,
    variant: str | None = None,
    animation: str | None = None,
    time_code: float | None = None,
) -> Scene:
    """Reads an asset: .gltf, .glb, .obj or .ray.

    Args:
        path: the file.
        root: the folder that references may not leave; by default the parent of the asset's folder.
        variant: the material variant with this name or index.
        animation: the animation with this name or index, or "all".
        time_code: the moment of the animation, seconds.

    Raises:
        AssetError: it cannot be read; the message has the place, `code` is a stable word.
    """
    return Scene(_kiln.load(path, root, variant, animation, time_code))


def _given(**options: Any) -> dict[str, Any]:
    return {key: value for key, value in options.items() if value is not None}


def render(
    scene: Scene | str | os.PathLike[str],
    *,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    error: float | None = None,
    time: float | None = None,
    seed: int = 0,
    camera: str | None = None,
    view: str | os.PathLike[str] | None = None,
    turntable: int | None = None,
    frame: int = 0,
    up: str | None = None,
    env: str | os.PathLike[str] | None = None,
    exposure: float | str | None = None,
    background: str | None = None,
    tonemap: str | None = None,
    max_depth: int | None = None,
    strategy: str | None = None,
    sampler: str | None = None,
    light_samples: int | None = None,
    reuse: str | None = None,
    clamp: float | None = None,
    surfaces: bool = False,
) -> Picture:
    """Renders an asset, or one frame of a turntable around it.

    Without `spp`, `error` or `time`, 64 samples per pixel are taken; what is met first ends the render. The other arguments
    are the flags of `kiln render` of the same names.

    Args:
        scene: a scene, or the path of an asset.
        width, height: pixels; 256 and the width by default.
        spp: camera paths per pixel, at most.
        error: stop when the displayed picture is within so many levels (of 255, RMS) of the converged one, with 95 % confidence.
        time: stop after so many seconds; `record["ended"]` is then "deadline".
        seed: selects the random numbers.
        camera: the asset's camera with this name or index, or "auto".
        view: a JSON file with camera, size, depth and environment.
        turntable, frame: which of so many auto-framed views around the asset.
        up: "auto", "y" or "z".
        env: "auto", "none", "studio", "constant:R,G,B" or the path of an HDR or EXR picture.
        exposure: EV, or "auto".
        background: "transparent", "environment" or "#rrggbb"; what errors are judged on, and whether the environment is seen.
        tonemap: what errors are judged with.
        surfaces: adds the layers "albedo" (height, width, 3), "normal" (height, width, 3: world space) and "depth" (height,
            width, 1: along the camera's axis, infinite where nothing is) of the first surfaces.

    Raises:
        AssetError: it cannot be rendered.
        ValueError: an argument is out of its range.
        KeyboardInterrupt: Ctrl-C; the render is stopped.
    """
    if not isinstance(scene, Scene):
        scene = load(scene)
    options = _given(
        width=width, height=height, spp=spp, error=error, time=time, seed=seed, camera=camera, view=view, turntable=turntable,
        up=up, env=env, exposure=exposure, background=background, tonemap=tonemap, max_depth=max_depth, strategy=strategy,
        sampler=sampler, light_samples=light_samples, reuse=reuse, clamp=clamp,
    )  # fmt: skip
    text, raw = _kiln.render(scene._native, frame, surfaces, options)
    record = json.loads(text)
    size = (record["height"], record["width"])
    layers = {name: np.frombuffer(data, kind).reshape(*size, channels) for name, (channels, kind, data) in raw.items()}
    picture = layers["beauty"].view(Picture)
    picture.record = record
    picture.layers = layers
    return picture


def turntable(scene: Scene | str | os.PathLike[str], frames: int = 24, **options: Any) -> Iterator[Picture]:
    """Renders views around an asset, one after the other; `options` are those of `render`."""
    if not isinstance(scene, Scene):
        scene = load(scene)
    for frame in range(frames):
        yield render(scene, turntable=frames, frame=frame, **options)


class Batch(Iterator[dict[str, Any]]):
    """A batch under way; iterate over it, or leave it by `stop` or the end of a `with` block. `len` counts the assets."""

    def __init__(self, native: _kiln.Batch) -> None:
        self._native = native

    def __len__(self) -> int:
        return len(self._native)

    def __next__(self) -> dict[str, Any]:
        line: dict[str, Any] = json.loads(next(self._native))
        return line

    def stop(self) -> None:
        """Stops it: assets not begun are skipped. Returns when the manifest is written."""
        self._native.stop()

    def __enter__(self) -> Batch:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def batch(
    folders: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    include: Iterable[str] = (),
    exclude: Iterable[str] = (),
    jobs: int | None = None,
    formats: Iterable[str] = ("png", "exr"),
    against: str | os.PathLike[str] | None = None,
    force: bool = False,
    retry_failed: bool = False,
    **options: Any,
) -> Batch:
    """Renders every asset below folders, as `kiln batch` does in one process, and yields results as they finish.

    Each result is a manifest line as a dict: "input", "status" ("ok", "warned", "partial", "failed", "skipped"), "outputs",
    "warnings", "error_message", "seconds" … Pictures, `manifest.jsonl` and `index.html` are in `out`. An asset that fails stops
    no other.

    Args:
        folders: one folder or several.
        out: where pictures, manifest and gallery go.
        include, exclude: globs of paths below the folders.
        jobs: assets worked on at a time; by default one a thread.
        formats: "png", "exr".
        against: the output folder of an earlier run that the gallery compares with.
        force: render what is up to date, too; else its earlier manifest line is yielded.
        retry_failed: render what failed before, though nothing has changed.
        options: those of `render`, `bits`, and `layers` of EXR files ("albedo", "normal", "depth", "object", "material").

    Raises:
        OSError: a folder cannot be searched or `out` cannot be written to.
    """
    if isinstance(folders, (str, os.PathLike)):
        folders = [folders]
    options["formats"] = list(formats)
    native = _kiln.batch(list(folders), out, list(include), list(exclude), jobs, against, (force, retry_failed), _given(**options))
    return Batch(native)
