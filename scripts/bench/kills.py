#!/usr/bin/env python3
"""Kills `kiln batch` at random moments, again and again, and compares what the last run leaves with an undisturbed one.

    scripts/bench/kills.py KILN ASSETS [KILLS [OPTION...]]

Prints one JSON object. What varies from run to run (times, memory) does not count."""

import json, pathlib, random, shutil, signal, subprocess, sys, tempfile, time


def files(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def timeless(text):
    keys = ("seconds", "cpu_seconds", "peak_bytes")
    return [{k: v for k, v in json.loads(line).items() if k not in keys} for line in text.decode().splitlines()]


def main():
    kiln, assets, kills, options = sys.argv[1], sys.argv[2], int((sys.argv[3:] or ["50"])[0]), sys.argv[4:]
    random.seed(1)
    with tempfile.TemporaryDirectory() as top:
        top = pathlib.Path(top)

        def start(out):
            return subprocess.Popen([kiln, "batch", assets, "--out", str(top / out), "--quiet", *options], stderr=subprocess.DEVNULL)

        begin = time.monotonic()
        code = start("undisturbed").wait()
        usual = time.monotonic() - begin
        killed, fresh, torn, left = 0, 0, 0, 0
        while killed < kills:
            run = start("out")
            time.sleep(random.uniform(0.0, usual))
            run.send_signal(signal.SIGKILL)
            if run.wait() == -signal.SIGKILL:
                killed += 1
            manifest = top / "out/manifest.jsonl"
            text = manifest.read_bytes() if manifest.exists() else b""
            torn += not (text.endswith(b"\n") or not text)
            for line in text.splitlines()[: text.count(b"\n")]:
                for output in json.loads(line)["outputs"]:
                    assert (top / "out" / output["path"]).stat().st_size == output["bytes"], output["path"]
            left += sum(1 for _ in (top / "out").rglob(".kiln-*.tmp")) if (top / "out").exists() else 0
            # One that is done has nothing left to be killed at.
            if len(text.splitlines()) >= 0.9 * len(timeless((top / "undisturbed/manifest.jsonl").read_bytes())):
                shutil.rmtree(top / "out")
                fresh += 1
        last = start("out").wait()
        want, have = files(top / "undisturbed"), files(top / "out")
        same_manifest = timeless(want.pop("manifest.jsonl")) == timeless(have.pop("manifest.jsonl"))
        # The page holds the manifest's times.
        want.pop("index.html", None), have.pop("index.html", None)
        print(json.dumps({
            "kills": killed, "begun anew": fresh, "half lines": torn, "temporary files left by kills": left,
            "exit codes": [code, last], "pictures": len(want), "equal": want == have, "manifest equal but for times": same_manifest,
        }))


main()
