#!/usr/bin/env python3
"""Breaks one numerical remedy at a time and tells which checks notice: `python3 scripts/mutate_checks.py WORK [NAME …|build|fit]`.

`fit` only looks whether the code still has what they change. Works on a copy of HEAD in the folder WORK, where every mutation of scripts/mutations.py is compiled in behind a switch (the
variable KILN_MUTATION), so that one build serves all. Prints a Markdown table. Checks that take long run only for the
mutations that name them; where mutations are asked for by name, only the checks that these name. Both integrators run them: paths one by one, and side by side in lanes. Named checks must fail by both.
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from fnmatch import fnmatch
from pathlib import Path

from mutations import MUTATIONS

SWITCH = '''//! Switches of mutations; only in the copy that scripts/mutate_checks.py makes.
use std::sync::LazyLock;
static ON: LazyLock<u64> = LazyLock::new(|| std::env::var("KILN_MUTATION").ok().and_then(|v| v.parse().ok()).unwrap_or(0));
/// Whether a mutation is on.
#[inline(always)]
pub fn on(bit: u32) -> bool { *ON >> bit & 1 == 1 }
'''
# Checks that take more CPU seconds run only for the mutations that name them.
LONG = 0.04
ROOT = Path(__file__).resolve().parent.parent


def mutated(work):
    """A copy of the code with every mutation behind its switch."""
    copy = work / "kiln"
    subprocess.run(["rm", "-rf", copy], check=True)
    copy.mkdir(parents=True)
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, check=True, capture_output=True).stdout
    subprocess.run(["tar", "-x", "-C", copy], input=archive, check=True)
    (copy / "src/mutants.rs").write_text(SWITCH)
    lib = copy / "src/lib.rs"
    lib.write_text(lib.read_text().replace("pub mod batch;", "pub mod batch;\npub mod mutants;"))
    for bit, (name, _, edits, _) in enumerate(MUTATIONS):
        condition = f"crate::mutants::on({bit})"
        for file, before, after in edits:
            path = copy / "src" / file
            text = path.read_text()
            if text.count(before) == 0:
                sys.exit(f"{name}: '{before}' is not in {file}")
            changed = re.sub(r"\bON\b", f"if {condition}", re.sub(r"\bIS\b", condition, after))
            path.write_text(text.replace(before, changed))
    return copy


def build(work):
    """The program with every mutation behind its switch."""
    copy = mutated(work)
    settings = ["--config", "profile.release.package.kiln.codegen-units=16"]
    subprocess.run(["cargo", *settings, "build", "--release", "--quiet"], cwd=copy, check=True,
                   env={**os.environ, "CARGO_TARGET_DIR": str(work / "target")})
    return work / "target/release/kiln"


def rows(kiln, bits, folder, integrator):
    env = {**os.environ, "KILN_MUTATION": str(bits)}
    command = [kiln, "check", folder, "--json", "--integrator", integrator]
    out = subprocess.run(command, env=env, capture_output=True, text=True)
    if out.stdout:
        return json.loads(out.stdout)["rows"]
    return [{"case": f"(it stops: {out.stderr.strip().splitlines()[-1][:60]})", "verdict": "fail", "cpu_seconds": 0.0}]


def failing(rows):
    """Checks that are not as expected, in order."""
    return list(dict.fromkeys(row["case"] for row in rows if row["verdict"] not in ("pass", "known")))


def named(case, expected):
    return any(fnmatch(case, pattern) for pattern in expected.split())


def table(kiln, checks, names):
    print("| mutation | remedy taken away | checks that fail | in lanes | named ones among both |\n| --- | --- | --- | --- | --- |", flush=True)
    if names:
        patterns = " ".join(expected for name, _, _, expected in MUTATIONS if name in names)
        for file in checks.glob("*.toml"):
            if not named(file.stem, patterns):
                file.unlink()
    untouched = rows(kiln, 0, checks, "plain")
    bad = failing(untouched)
    print(f"| (none) | | {len(bad)} | | {'yes' if not bad else 'NO: ' + ', '.join(bad)} |", flush=True)
    seconds = {}
    for row in untouched:
        seconds[row["case"]] = seconds.get(row["case"], 0.0) + row["cpu_seconds"]
    good = not bad
    for bit, (name, remedy, _, expected) in enumerate(MUTATIONS):
        if names and name not in names:
            continue
        wanted = [case for case, cpu in seconds.items() if cpu < LONG or (expected != "*" and named(case, expected))]
        with tempfile.TemporaryDirectory() as folder:
            for case in wanted:
                shutil.copy(checks / f"{case}.toml", folder)
            os.symlink(checks / "scenes", Path(folder) / "scenes")
            bad = failing(rows(kiln, 1 << bit, folder, "plain"))
            in_lanes = failing(rows(kiln, 1 << bit, folder, "path"))
        hit = [n for n in bad if named(n, expected)]
        noticed = bool(hit) and any(named(n, expected) for n in in_lanes)
        good &= noticed
        shown = ", ".join(f"`{n}`" for n in (hit + [n for n in bad if n not in hit])[:4])
        more = f" and {len(bad) - 4} more" if len(bad) > 4 else ""
        print(f"| `{name}` | {remedy} | {shown}{more} | {len(in_lanes)} | {'yes' if noticed else '**no**'} |", flush=True)
    return good


if __name__ == "__main__":
    work = Path(sys.argv[1]).resolve()
    if sys.argv[2:] == ["fit"]:
        mutated(work)
        sys.exit(0)
    program = build(work)
    if sys.argv[2:] == ["build"]:
        sys.exit(0)
    # A copy: the folder may change while this runs.
    shutil.rmtree(work / "checks", ignore_errors=True)
    checks = shutil.copytree(ROOT / "scenes" / "checks", work / "checks")
    sys.exit(0 if table(program, checks, sys.argv[2:]) else 1)
