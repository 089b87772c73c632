#!/usr/bin/env python3
"""Breaks one numerical remedy at a time and tells which checks notice: `python3 scripts/mutate_checks.py WORK [NAME …]`.

Works on a copy of HEAD in the folder WORK, where every mutation of MUTATIONS is compiled in behind a switch (the
variable KILN_MUTATION), so that one build serves all. Prints a Markdown table.
"""
import json
import os
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

# name, the remedy, file, what stands there, what replaces it (Rust expressions), checks of which at least one must fail.
MUTATIONS = [
    ("no-offset", "spawned rays start beyond the error of the hit", "math/float_error.rs",
     "let distance = normal.abs().dot(error);", "let distance = {ON} {{ return point }} else {{ normal.abs().dot(error) }};",
     "bounce-from-an-edge mesh-coplanar"),
    ("fixed-epsilon", "the offset follows the error, not a fixed epsilon", "math/float_error.rs",
     "else { normal.abs().dot(error) };", "else {{ {ON} {{ 1e-4 }} else {{ normal.abs().dot(error) }} }};", "contact-shadow thin-*"),
    ("no-neighbour-error", "the offset covers the next hit's error on a neighbour", "integrate/vertex.rs",
     "error: rounding + neighbours,", "error: {ON} {{ rounding }} else {{ rounding + neighbours }},", "bounce-from-an-edge"),
    ("edges-in-f32", "edge functions whose signs are exact", "math/triangle.rs",
     "let w = exact(bx, ay) - exact(by, ax);",
     "let w = exact(bx, ay) - exact(by, ax);\n        let (u, v, w) = {ON} {{ (f64::from(cx * by - cy * bx) - 1e-7, f64::from(ax * cy - ay * cx) - 1e-7, "
     "f64::from(bx * ay - by * ax) - 1e-7) }} else {{ (u, v, w) }};", "leak-* ray-direction-*"),
    ("strict-edges", "an edge belongs to both its triangles", "math/triangle.rs",
     "let det = u + v + w;", "if {COND} && (u == 0.0 || v == 0.0 || w == 0.0) {{ return None; }}\n        let det = u + v + w;",
     "leak-grid-* ray-direction-*"),
    ("parallel-unmended", "rays parallel to an axis never multiply 0 by infinity", "prepare/kdtree/slab.rs",
     "if d[axis].abs() < PARALLEL {", "if !({COND}) && d[axis].abs() < PARALLEL {{", "ray-direction-* leak-grid-*"),
    ("limit-too-near", "boxes are left out only beyond the nearest hit and its error", "prepare/kdtree/slab.rs",
     "t * self.scale * GROWTH + f32::MIN_POSITIVE", "t * self.scale * {ON} {{ 0.99 }} else {{ GROWTH }} + f32::MIN_POSITIVE", "thin-* coincident-*"),
    ("world-at-origin", "the world's centre becomes the origin in f64", "geometry/world.rs",
     "Self { center: lo + (hi - lo) * 0.5, scale }", "Self {{ center: {ON} {{ DVec3::ZERO }} else {{ lo + (hi - lo) * 0.5 }}, scale }}",
     "scale-*-at-1e+* leak-ball-far"),
    ("world-unscaled", "the world's extent becomes 1 to 2", "geometry/world.rs",
     "let scale = if extent > 0.0", "let scale = if !({COND}) && extent > 0.0", "scale-* absorption-scale-*"),
    ("no-lift", "the shadow terminator: smooth surfaces reflect from above their facets", "integrate/vertex.rs",
     "let smooth = attributes.normal.is_some() &&", "let smooth = !({COND}) && attributes.normal.is_some() &&", "terminator-below-the-face normals-smooth"),
    ("unbent-normal", "the viewer is above the shading normal's horizon", "integrate/vertex.rs",
     "if cosine >= least {", "if {COND} || cosine >= least {{", "normals-* normal-map-* terminator-*"),
    ("bent-flat-normal", "a flat face is seen by its own normal however grazing", "integrate/vertex.rs",
     "LEAST_COSINE.min(normal.dot(wo))", "{ON} {{ LEAST_COSINE }} else {{ LEAST_COSINE.min(normal.dot(wo)) }}", "furnace-metal-*-at-89.9"),
    ("normals-by-matrix", "normals go by the cofactors of the transform", "geometry/triangles.rs",
     "normal_matrix: Mat3::from_cols(normals[0], normals[1], normals[2]),",
     "normal_matrix: {ON} {{ Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()) }} else {{ Mat3::from_cols(normals[0], normals[1], normals[2]) }},",
     "normals-squeezed"),
    ("winding-kept", "a reflecting transform turns the winding", "geometry/triangles.rs",
     "let winding = if x.cross(y)", "let winding = if !({COND}) && x.cross(y)", "transform-mirrored transform-inverted furnace-glass-box-mirrored"),
    ("coverage-by-triangle", "neighbours decide alike about an edge of a sheet", "integrate/trace.rs",
     "let site = coverage_site(geometry, hit.triangle, b);", "let site = {ON} {{ hit.triangle }} else {{ coverage_site(geometry, hit.triangle, b) }};",
     "alpha-shadow-on-edge"),
    ("one-body", "bodies within bodies are remembered", "integrate/medium.rs",
     "        self.bodies[self.depth] = material;", "        if {COND} {{ self.depth = 0; }}\n        self.bodies[self.depth] = material;",
     "absorption-* nested-*"),
    ("index-outside-1", "the index is relative to what is around", "integrate/medium.rs",
     "        if place.front {\n            index", "        if {COND} {{ 1.0 }} else if place.front {{\n            index", "nested-*"),
    ("roulette-0.95", "roulette amplifies nothing beyond 1", "integrate/walk.rs",
     ".min(MOST_SURVIVAL)", ".min({ON} {{ 0.95 }} else {{ MOST_SURVIVAL }})", "box-0.999 box-1.0"),
    ("sums-in-f32", "film sums in f64", "film/mod.rs",
     "sum[c] += f64::from(rgba[c])", "sum[c] = {ON} {{ f64::from(sum[c] as f32 + rgba[c]) }} else {{ sum[c] + f64::from(rgba[c]) }}", "film-sum"),
    ("no-delta-limit", "α below a limit is a delta lobe", "shading/metal_rough.rs",
     "if alpha < SMALLEST_ALPHA { Lobe::Mirror", "if !({COND}) && alpha < SMALLEST_ALPHA {{ Lobe::Mirror", "furnace-metal-0.0-* mirror-corridor-* furnace-ior-0"),
    ("ggx-by-alpha2-1", "D(h) without 1 − z² or α² − 1", "shading/microfacet.rs",
     "let d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;",
     "let d = {ON} {{ let z2 = h.z * h.z; z2 * (a2 - 1.0) + 1.0 }} else {{ a2 * h.z * h.z + h.x * h.x + h.y * h.y }};",
     "furnace-metal-*"),
    ("refraction-clamped", "beyond the critical angle everything is reflected", "shading/fresnel.rs",
     "if cos2_t <= 0.0 {", "let cos2_t = {ON} {{ cos2_t.max(1e-6) }} else {{ cos2_t }};\n    if cos2_t <= 0.0 {{", "total-reflection-prism furnace-glass-* inside-glass"),
    ("tie-by-order", "of hits at one distance the lowest number wins", "math/triangle.rs",
     "(point.t < self.t || (point.t == self.t && self.hit.is_some_and(|h| point.triangle < h.triangle)))",
     "(point.t < self.t || (point.t == self.t && self.hit.is_some_and(|h| ({COND}) != (point.triangle < h.triangle))))", "coincident-surfaces mesh-coplanar"),
    ("own-triangle", "a ray never meets the triangle that it leaves", "integrate/trace.rs",
     "if asker.leaves == Some(hit.triangle) {", "if !({COND}) && asker.leaves == Some(hit.triangle) {{", "*"),
    ("flat-triangles-kept", "triangles without area are left out", "geometry/triangles.rs",
     "if normal.is_finite() && normal != DVec3::ZERO {", "if {COND} || (normal.is_finite() && normal != DVec3::ZERO) {{", "*"),
]
SWITCH = '''//! Switches of mutations; only in the copy that scripts/mutate_checks.py makes.
use std::sync::LazyLock;
static ON: LazyLock<u64> = LazyLock::new(|| std::env::var("KILN_MUTATION").ok().and_then(|v| v.parse().ok()).unwrap_or(0));
/// Whether a mutation is on.
#[inline(always)]
pub fn on(bit: u32) -> bool { *ON >> bit & 1 == 1 }
'''
# The lanes of the wavefront have code of their own, so the copy follows its paths one by one.
PLAIN = ("settings.rs", "    #[default]\n    Path,", "    Path,", "    Plain,", "    #[default]\n    Plain,")
ROOT = Path(__file__).resolve().parent.parent


def build(work):
    """The program with every mutation behind its switch."""
    copy = work / "kiln"
    subprocess.run(["rm", "-rf", copy], check=True)
    copy.mkdir(parents=True)
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, check=True, capture_output=True).stdout
    subprocess.run(["tar", "-x", "-C", copy], input=archive, check=True)
    (copy / "src/mutants.rs").write_text(SWITCH)
    lib = copy / "src/lib.rs"
    lib.write_text(lib.read_text().replace("pub mod batch;", "pub mod batch;\npub mod mutants;"))
    for bit, (name, _, file, before, after, _) in enumerate(MUTATIONS):
        path = copy / "src" / file
        text = path.read_text()
        if text.count(before) == 0:
            sys.exit(f"{name}: '{before}' is not in {file}")
        condition = f"crate::mutants::on({bit})"
        changed = after.replace("{ON}", f"if {condition}").replace("{COND}", condition).replace("{{", "{").replace("}}", "}")
        path.write_text(text.replace(before, changed))
    file, default, path_alone, plain, plain_default = PLAIN
    text = (copy / "src" / file).read_text()
    assert default in text and plain in text
    (copy / "src" / file).write_text(text.replace(default, path_alone).replace(plain, plain_default))
    settings = ["--config", "profile.release.package.kiln.codegen-units=16"]
    subprocess.run(["cargo", *settings, "build", "--release", "--quiet"], cwd=copy, check=True,
                   env={**os.environ, "CARGO_TARGET_DIR": str(work / "target"), "RUSTFLAGS": "-A warnings"})
    return work / "target/release/kiln"


def failing(kiln, bits, folder):
    """Checks that are not as expected with these mutations, and how many comparisons of them."""
    env = {**os.environ, "KILN_MUTATION": str(bits)}
    out = subprocess.run([kiln, "check", folder, "--json"], env=env, capture_output=True, text=True)
    if not out.stdout:
        return {"(it stops: " + out.stderr.strip().splitlines()[-1][:60] + ")": 1}
    bad = {}
    for row in json.loads(out.stdout)["rows"]:
        if row["verdict"] not in ("pass", "known"):
            bad[row["case"]] = bad.get(row["case"], 0) + 1
    return bad


def table(kiln, names):
    print("| mutation | remedy taken away | checks that fail | expected among them |\n| --- | --- | --- | --- |", flush=True)
    good = True
    untouched = failing(kiln, 0, ROOT / "scenes/checks")
    print(f"| (none) | | {len(untouched)} | {'yes' if not untouched else 'NO: ' + ', '.join(untouched)} |", flush=True)
    for bit, (name, remedy, _, _, _, expected) in enumerate(MUTATIONS):
        if names and name not in names:
            continue
        bad = failing(kiln, 1 << bit, ROOT / "scenes/checks")
        hit = [n for n in bad if any(fnmatch(n, pattern) for pattern in expected.split())]
        good &= bool(hit)
        shown = ", ".join(f"`{n}`" for n in (hit + [n for n in bad if n not in hit])[:4])
        more = f" and {len(bad) - 4} more" if len(bad) > 4 else ""
        print(f"| `{name}` | {remedy} | {shown}{more} | {'yes' if hit else '**no**'} |", flush=True)
    return good


if __name__ == "__main__":
    work = Path(sys.argv[1]).resolve()
    program = build(work)
    sys.exit(0 if table(program, sys.argv[2:]) else 1)
