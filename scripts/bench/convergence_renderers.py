"""The renderers that `convergence.py` lets run: Kiln by its command line, its peers by the scripts of the shared folder."""

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy
import OpenEXR

CACHE = Path.home() / ".cache" / "kiln-bench"


def read_exr(path):
    """Height × width × RGB, double precision."""
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return numpy.stack([channels[c].pixels.astype(numpy.float64) for c in "RGB"], axis=-1)


class Scene:
    """A bench scene: a view file, and the asset that it names."""

    def __init__(self, shared, name):
        self.name = name
        self.view = shared / "scenes" / "bench" / f"{name}.json"
        facts = json.loads(self.view.read_text())
        self.width, self.height = facts["width"], facts["height"]
        self.asset = self.view.parent / facts["file"]
        if name == "large_mesh":
            self._make_large_mesh(shared)

    def _make_large_mesh(self, shared):
        """The asset is too large to be kept: it is made once, its view file beside it."""
        folder = CACHE / "large_mesh"
        self.asset = Path(os.environ.get("KILN_LARGE_MESH", folder / "large_mesh.glb"))
        if not self.asset.exists():
            folder.mkdir(parents=True, exist_ok=True)
            maker = shared / "scenes" / "bench" / "gen_large.py"
            subprocess.run([sys.executable, str(maker), "terrain1m", str(self.asset)], check=True)


@dataclass
class Shot:
    """A picture, and the seconds of its light transport."""

    pixels: numpy.ndarray
    cpu: float
    wall: float


def timed(command, **options):
    """Runs a command to its end; gives wall and CPU seconds of the process, and what it wrote to stdout."""
    start = time.perf_counter()
    with tempfile.TemporaryFile() as out:
        process = subprocess.Popen(command, stdout=out, **options)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        text = out.read().decode()
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} failed with {process.returncode}\n{text}")
    return wall, usage.ru_utime + usage.ru_stime, text


class Kiln:
    """A kiln binary with options."""

    def __init__(self, name, command, shared):
        self.name, self.shared = name, shared
        self.binary, *self.options = command.split()

    def _run(self, scene, spp, seed, output, options=()):
        # Files that assets and views name lie in the shared folder; an asset elsewhere has its own folder.
        root = self.shared if scene.asset.resolve().is_relative_to(self.shared.resolve()) else scene.asset.parent
        command = [self.binary, "render", *self.options, str(scene.asset), "--view", str(scene.view), "--root", str(root)]
        return timed([*command, "--spp", str(spp), "--seed", str(seed), "-q", "--json", "-o", str(output), *options])

    def render(self, scene, spp, seed, options=()):
        """One picture."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "picture.exr"
            _, _, text = self._run(scene, spp, seed, path, options)
            outcome = json.loads(text)
            return Shot(read_exr(path), outcome["cpu_seconds"]["render"], outcome["seconds"]["render"])

    def shoot(self, scene, spp, seeds):
        """Pictures with different seeds."""
        return [self.render(scene, spp, 1 + seed) for seed in range(seeds)]

    def whole(self, scene, spp):
        """Wall and CPU seconds from process start to a PNG on disk."""
        with tempfile.TemporaryDirectory() as folder:
            return self._run(scene, spp, 1, Path(folder) / "picture.png")[:2]


class Peer:
    """A renderer as the shared folder's script of that name runs it."""

    name: str
    options: tuple = ()

    def __init__(self, python, shared):
        self.python, self.script = python, shared / "peers" / f"run_{self.name}.py"

    def _command(self, scene, spp, renders, out):
        command = [self.python, "-W", "ignore", str(self.script), str(self._view(scene)), *self.options, *self.for_scene(scene)]
        return [*command, "--spp", str(spp), "--reps", str(renders), "--out", out]

    def for_scene(self, scene):
        """Options for a scene."""
        return []

    @staticmethod
    def _view(scene):
        if scene.name != "large_mesh":
            return scene.view
        # The scripts look for the asset beside the view file.
        beside = scene.asset.parent / "large_mesh.json"
        beside.write_text(json.dumps({**json.loads(scene.view.read_text()), "file": scene.asset.name}))
        return beside

    def shoot(self, scene, spp, seeds):
        """Pictures with different seeds; the first render of a process, which compiles, is left out."""
        with tempfile.TemporaryDirectory() as out:
            _, _, text = timed(self._command(scene, spp, seeds + 1, out))
            rows = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
            read = lambda rep: numpy.load(next(Path(out).glob(f"*.{spp}.{rep}.npy"))).astype(numpy.float64)
            return [Shot(read(r["rep"]), r["cpu"], r["wall"]) for r in rows if r["phase"] == "warm"]

    def whole(self, scene, spp):
        """Wall and CPU seconds from process start to a picture on disk."""
        with tempfile.TemporaryDirectory() as out:
            return timed(self._command(scene, spp, 1, out))[:2]


class Mitsuba(Peer):
    """Mitsuba 3, AVX-512 LLVM mode with the multijitter sampler."""

    name = "mitsuba"
    # Three, since one of them only waits.
    options = ("--threads", "3", "--sampler", "multijitter")

    def for_scene(self, scene):
        return ["--weight"] if scene.name == "many_lights" else []


class Cycles(Peer):
    """Blender Cycles by `bpy`, with its light tree and its sampler."""

    name = "cycles"
    options = ("--threads", "2")
