"""The package, on small assets of its own and on the project's samples."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import kiln

ROOT = Path(__file__).resolve().parents[3]
SAMPLES = ROOT / "scenes" / "samples"
SQUARE = "v -0.5 0 0\nv 0.5 0 0\nv 0.5 1 0\nv -0.5 1 0\nv 0 0 1\nf 1 2 3 4\nf 1 2 5\n"


@pytest.fixture
def square(tmp_path):
    path = tmp_path / "square é椅.obj"
    path.write_text(SQUARE, encoding="utf-8")
    return path


def test_inspect_tells_what_is_there(square):
    scene = kiln.load(square)
    assert scene.path == str(square)
    assert scene.inspect()["triangles"] == 3
    assert scene.inspect()["light"] == "studio"
    assert scene.warnings == []
    assert "3 triangles" in repr(scene)


def test_a_picture_is_an_array_with_layers(square):
    picture = kiln.render(kiln.load(square), width=24, height=16, spp=8)
    assert isinstance(picture, np.ndarray)
    assert (picture.shape, picture.dtype) == ((16, 24, 4), np.float32)
    assert 0.1 < picture[..., 3].mean() < 0.9, "the asset covers a part of it"
    assert picture.layers["variance"].shape == (16, 24, 3) and (picture.layers["variance"] >= 0).all()
    assert (picture.layers["samples"] == 8).all()
    assert np.shares_memory(picture, picture.layers["beauty"])
    assert 0 < picture.record["error"] <= picture.record["error_bound"]
    assert (picture * 2).max() == 2 * picture.max()


def test_surfaces_are_layers(square):
    picture = kiln.render(square, width=16, spp=4, surfaces=True)
    plain = kiln.render(square, width=16, spp=4)
    assert (picture == plain).all() and "albedo" not in plain.layers
    covered = picture[..., 3] == 1
    lengths = np.linalg.norm(picture.layers["normal"][covered], axis=-1)
    assert covered.any() and (lengths > 0.5).all() and (lengths < 1.001).all()
    assert np.isfinite(picture.layers["depth"][covered]).all()
    assert np.isinf(picture.layers["depth"][picture[..., 3] == 0]).all()


def test_pixels_repeat_and_follow_the_seed(square):
    scene = kiln.load(square)
    one = kiln.render(scene, width=16, spp=4)
    assert (one == kiln.render(scene, width=16, spp=4)).all()
    assert (one == kiln.render(square, width=16, spp=4)).all()
    assert (one != kiln.render(scene, width=16, spp=4, seed=1)).any()


def test_display_is_what_the_program_writes(square, tmp_path):
    image = pytest.importorskip("PIL.Image")
    (result,) = kiln.batch(tmp_path, tmp_path / "out", width=32, spp=16, formats=["png"])
    written = np.asarray(image.open(tmp_path / "out" / result["outputs"][0]["path"]))
    shown = kiln.render(square, width=32, spp=16).display()
    assert (shown.dtype, shown.shape) == (np.uint8, (32, 32, 4))
    assert (shown == written).all()
    white = kiln.render(square, width=8, spp=1).display(background="#ffffff")
    assert (white[..., 3] == 255).all()


def test_an_error_can_be_asked_for(square):
    picture = kiln.render(square, width=32, error=6)
    assert picture.record["ended"] == "error"
    assert picture.record["target_met"] and picture.record["error_bound"] <= 6


def test_time_can_be_asked_for():
    begin = time.monotonic()
    picture = kiln.render(SAMPLES / "frosted_dice.gltf", width=128, time=0.5)
    assert picture.record["ended"] == "deadline" and picture.record["spp"] >= 1
    assert time.monotonic() - begin < 5


def test_a_turntable_turns(square):
    frames = list(kiln.turntable(square, 3, width=16, spp=1))
    assert len(frames) == 3
    assert (frames[0] != frames[1]).any()
    with pytest.raises(IndexError):
        kiln.render(square, turntable=3, frame=3, width=16, spp=1)


def test_what_is_wrong_is_named(square, tmp_path):
    broken = tmp_path / "broken.obj"
    broken.write_text("f 1 2 3\n")
    with pytest.raises(kiln.AssetError, match="vertex that does not exist") as caught:
        kiln.load(broken)
    assert caught.value.code == "invalid"
    for wrong in [{"width": 0}, {"error": -1}, {"spp": 0}, {"strategy": "guess"}, {"env": "constant:1,2"}, {"up": "x"}]:
        with pytest.raises(ValueError, match=next(iter(wrong))):
            kiln.render(square, **wrong)
    with pytest.raises(TypeError):
        kiln.render(square, wdth=3)
    with pytest.raises(TypeError, match="wdth"):
        kiln.batch(tmp_path, tmp_path / "out", wdth=3)


def test_a_batch_yields_manifest_lines(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    for name in ["a.obj", "b.obj", "椅子.obj"]:
        (folder / name).write_text(SQUARE)
    (folder / "broken.obj").write_text("f 1 2 3\n")
    batch = kiln.batch(folder, out, width=8, spp=2, formats=["exr"], exclude=["b.*"])
    assert len(batch) == 3
    results = sorted(batch, key=lambda result: result["input"])
    assert [(r["input"], r["status"]) for r in results] == [("a.obj", "ok"), ("broken.obj", "failed"), ("椅子.obj", "ok")]
    lines = [json.loads(line) for line in (out / "manifest.jsonl").read_text(encoding="utf-8").splitlines()]
    assert sorted(lines, key=lambda line: line["input"]) == results
    again = sorted(kiln.batch(folder, out, width=8, spp=2, formats=["exr"], exclude=["b.*"]), key=lambda r: r["input"])
    assert [r["seconds"] for r in again] == [r["seconds"] for r in results], "all of it was up to date"
    assert (out / "a.obj.exr").stat().st_size > 0 and (out / "index.html").stat().st_size > 0


def test_manifest_lines_are_what_the_schema_says(tmp_path):
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads((ROOT / "docs" / "manifest.schema.json").read_text(encoding="utf-8"))

    def closed(part):
        """The same schema without room for fields that it does not tell of."""
        if isinstance(part, list):
            return [closed(item) for item in part]
        if not isinstance(part, dict):
            return part
        more = {"additionalProperties": False} if "properties" in part and "required" in part else {}
        return {**{key: closed(value) for key, value in part.items()}, **more}

    validator = jsonschema.Draft202012Validator(closed(schema))
    jsonschema.Draft202012Validator.check_schema(schema)
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "good.obj").write_text(SQUARE)
    (folder / "warned.obj").write_text("mtllib gone.mtl\nusemtl none\n" + SQUARE)
    (folder / "broken.obj").write_text("f 1 2 3\n")
    lines = list(kiln.batch(folder, tmp_path / "out", width=8, error=20, time=30, clamp=1))
    assert {line["status"] for line in lines} == {"ok", "warned", "failed"}
    for line in lines:
        validator.validate(line)
    for wrong in [{"status": "fine"}, {"novel": 1}, {"seconds": {}}, {"content": "md5:00"}]:
        with pytest.raises(jsonschema.ValidationError):
            validator.validate({**lines[0], **wrong})


def test_a_batch_can_be_left(tmp_path):
    folder = tmp_path / "in"
    folder.mkdir()
    for k in range(20):
        (folder / f"{k}.obj").write_text(SQUARE)
    with kiln.batch(folder, tmp_path / "out", width=64, spp=64, jobs=1) as batch:
        assert next(batch)["status"] == "ok"
    lines = [json.loads(line) for line in (tmp_path / "out/manifest.jsonl").read_text().splitlines()]
    assert len(lines) == 20 and any(line["status"] == "skipped" for line in lines)


def test_other_threads_run_meanwhile(square):
    ticks = []
    done = threading.Event()

    def tick():
        while not done.wait(0.005):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    kiln.render(SAMPLES / "frosted_dice.gltf", width=128, time=1)
    end = time.monotonic()
    done.set()
    thread.join()
    assert len([t for t in ticks if begin < t < end]) > 20


@pytest.mark.skipif(os.name == "nt", reason="signals are sent as POSIX does")
@pytest.mark.parametrize("work", [
    "kiln.render(asset, width=512, spp=1 << 20)",
    "list(kiln.batch(asset.parent, out, width=512, spp=1 << 20, include=['frosted_dice.gltf']))",
])
def test_ctrl_c_stops_it(work, tmp_path):
    program = f"""
import kiln, pathlib, signal
# Shells start what is in the background with the signal ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
asset, out = pathlib.Path({str(SAMPLES / "frosted_dice.gltf")!r}), {str(tmp_path / "out")!r}
print("ready", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("stopped", flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    try:
        assert process.communicate(timeout=20)[0] == "stopped\n"
    finally:
        process.kill()
    assert process.returncode == 0
