"""The native part of Kiln; use the package's own functions."""

import os
from pathlib import Path
from typing import Any

__version__: str

class AssetError(Exception):
    """An asset cannot be rendered; `code` is a stable word for why."""

    code: str

class Scene:
    path: Path
    def facts(self) -> str: ...

class Batch:
    def __len__(self) -> int: ...
    def __iter__(self) -> Batch: ...
    def __next__(self) -> str: ...
    def stop(self) -> None: ...

def set_threads(threads: int) -> None:
    """Chooses how many threads render, before the first render; by default one per core."""

def load(
    path: str | os.PathLike[str],
    root: str | os.PathLike[str] | None = None,
    variant: str | None = None,
    animation: str | None = None,
    time_code: float | None = None,
) -> Scene: ...
def render(scene: Scene, view: int, wants_surfaces: bool, options: dict[str, Any]) -> tuple[str, dict[str, tuple[int, str, bytearray]]]: ...
def develop(pixels: bytes, exposure: float, tonemap: str, background: str) -> bytearray: ...
def batch(
    folders: list[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    include: list[str],
    exclude: list[str],
    jobs: int | None,
    against: str | os.PathLike[str] | None,
    again: tuple[bool, bool],
    options: dict[str, Any],
) -> Batch: ...
