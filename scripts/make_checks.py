#!/usr/bin/env python3
"""Writes scenes/checks: `python3 scripts/make_checks.py`. The same files whenever it runs."""
from pathlib import Path

from checks import extremes, geometry, hostile, light, outside, outside_matter, remedies, surfaces, writers

FOLDER = Path(__file__).resolve().parent.parent / "scenes" / "checks"


class Checks:
    """Collects checks; a scene may serve several."""

    def __init__(self):
        (FOLDER / "scenes").mkdir(parents=True, exist_ok=True)
        for old in (*FOLDER.glob("*.toml"), *(FOLDER / "scenes").iterdir()):
            old.unlink()
        self.scenes = FOLDER / "scenes"
        self.names = set()

    def obj(self, name, *parts):
        return writers.write_obj(self.scenes, name, parts)

    def gltf(self, name, *parts, **more):
        return writers.write_gltf(self.scenes, name, parts, **more)

    def ray(self, name, *blocks):
        return writers.write_ray(self.scenes, name, *blocks)

    def add(self, name, title, scene, derivation, expect, camera=None, environment=None, known=None, **render):
        """`expect`: a value, or a dict of the [[expect]] table, or a list of those."""
        assert name not in self.names, name
        self.names.add(name)
        tables = {"title": title, "scene": f"scenes/{scene}", "derivation": derivation}
        if known:
            tables["known_failure"] = known
        if camera:
            tables["camera"] = camera
        if environment is not None:
            tables["environment"] = environment if isinstance(environment, dict) else {"constant": environment}
        if render:
            tables["render"] = render
        many = isinstance(expect, list) and isinstance(expect[0], dict)
        expect = expect if many else [expect]
        tables["expect"] = [e if isinstance(e, dict) else {"value": e} for e in expect]
        (FOLDER / f"{name}.toml").write_text(writers.toml(tables))


if __name__ == "__main__":
    checks = Checks()
    surfaces.write(checks)
    light.write(checks)
    geometry.write(checks)
    extremes.write(checks)
    remedies.write(checks)
    outside.write(checks)
    outside_matter.write(checks)
    hostile.write(checks)
    print(f"{len(checks.names)} checks")
