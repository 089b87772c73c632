#!/usr/bin/env python3
"""Pruned and full renderer over folders: `python3 scripts/effects_equal.py KILN OUT FOLDER… [-- OPTIONS OF kiln batch]`.

Renders everything twice, as the scenes call for it and with `--effects all`, and compares the EXR files byte for byte, all layers and all
metadata. Then measures both ways on each asset, in turn (`kiln inspect --effects --measure`), and prints a Markdown table. With
`--gains-only` before KILN the pictures of an earlier run are taken.
"""
import json
import statistics
import subprocess
import sys
from pathlib import Path


def batch(kiln, out, folders, options, effects):
    command = [kiln, "batch", *folders, "--out", out, "--effects", effects, "--format", "exr", "--quiet", *options]
    subprocess.run(command, check=False)


def records(out):
    lines = (out / "manifest.jsonl").read_text().splitlines()
    return {record["input"]: record for record in map(json.loads, lines) if "input" in record}


def compare(out):
    sets = {effects: records(out / effects) for effects in ("auto", "all")}
    equal, differ = [], []
    for name, pruned in sorted(sets["auto"].items()):
        full = sets["all"].get(name, {})
        if pruned.get("status") != full.get("status"):
            differ.append(f"{name}: {pruned.get('status')} and {full.get('status')}")
        for file in [o["path"] for o in pruned.get("outputs") or [] if o["path"].endswith(".exr")]:
            same = (out / "auto" / file).read_bytes() == (out / "all" / file).read_bytes()
            (equal if same else differ).append(name)
    print(f"{len(equal)} EXR files are equal byte for byte, {len(differ)} are not" + "".join(f"\n- {d}" for d in differ), flush=True)
    return equal + differ, not differ


def is_plain(name, effects):
    """Diffuse or metal-rough, without texture, alpha, layers, bodies and glass."""
    more = {"textures", "normal-maps", "alpha-cutouts", "alpha-blending", "transmission", "refraction", "clearcoat", "sheen", "iridescence", "anisotropy"}
    more |= {"diffuse-transmission", "diffuse-roughness", "unlit", "mirror"}
    return not name.endswith(".ray") and not more & set(effects)


def measure(kiln, folders, names):
    """Gain, bytes a triangle held and full, effects, for each asset."""
    rows, regions = [], {}
    for name in dict.fromkeys(names):
        path = next((p for p in (Path(folder).parent / name for folder in folders) if p.exists()), None)
        out = path and subprocess.run([kiln, "inspect", path, "--effects", "--measure", "--json"], capture_output=True, text=True).stdout
        if not out:
            continue
        facts = json.loads(out)
        m, held = facts["measured"], facts["attribute_bytes"]
        triangles = max(1, facts["asked"]["triangles"])
        effects = [e["effect"] for e in facts["effects"]]
        rows.append((m["full_cpu_seconds"] / m["pruned_cpu_seconds"], name, m, [held[k] / triangles for k in ("held", "full")], effects))
        print(f"{len(rows)}: {name} {rows[-1][0]:.2f}", file=sys.stderr, flush=True)
        regions[name] = (facts["never_met"], facts["asked"])
    tell_regions(regions)
    return sorted(rows, reverse=True, key=lambda row: row[0])


def tell_regions(regions):
    """Triangles that no ray meets, and those that rays have to ask, over all assets."""
    triangles = sum(asked["triangles"] for _, asked in regions.values())
    print(f"{triangles} triangles in {len(regions)} assets")
    for why in ("without_area", "open", "behind_twin", "behind_turned_twin"):
        of = sorted(((unmet[why], name) for name, (unmet, _) in regions.items() if unmet[why]), reverse=True)
        most = ", ".join(f"{Path(name).name} {count}" for count, name in of[:8])
        print(f"- {why}: {sum(count for count, _ in of)} in {len(of)} assets ({most})")
    asking = [asked for _, asked in regions.values() if asked["coverage"] + asked["culling"]]
    way = [asked for asked in asking if asked["on_the_way"]]
    parts = [a for a in asking if 0 < a["coverage"] < a["triangles"] or not a["coverage"] and 0 < a["culling"] < a["triangles"]]
    print(f"- something to ask: {len(asking)} assets, of which {len(way)} on the way; of some triangles and not of others: {len(parts)}")


def table(rows):
    def figures(rows):
        gains = [row[0] for row in rows]
        low, middle, high = statistics.quantiles(gains, n=4) if len(gains) > 1 else gains * 3
        return f"{len(gains)} | {max(gains):.2f} | {high:.2f} | {middle:.2f} | {low:.2f} | {min(gains):.2f} |"

    bare = [r for r in rows if not {"textures", "alpha-cutouts", "alpha-blending"} & set(r[4])]
    plain = [r for r in rows if is_plain(r[1], r[4])]
    print("| CPU of rendering, full over pruned | assets | best | upper quartile | median | lower quartile | worst |\n| --- | --- | --- | --- | --- | --- | --- |")
    print(f"| all | {figures(rows)}\n| without texture and alpha | {figures(bare)}\n| plain: diffuse or metal-rough alone | {figures(plain)}")
    print(f"\nPlain ones of at least 1.3: {sum(r[0] >= 1.295 for r in plain)} of {len(plain)}")
    print(f"\nNot the same bits: {[r[1] for r in rows if not r[2]['same_bits']] or 'none'}\n")
    print("| asset | gain | pruned, ms | full, ms | attributes, bytes a triangle | all of them | effects |\n| --- | --- | --- | --- | --- | --- | --- |")
    for gain, name, m, (held, full), effects in rows:
        print(f"| {Path(name).name} | {gain:.2f} | {1e3 * m['pruned_cpu_seconds']:.1f} | {1e3 * m['full_cpu_seconds']:.1f} | {held:.0f} | {full:.0f} | {' '.join(effects)} |")


def main(*arguments):
    again = arguments[0] == "--gains-only"
    kiln, out, *rest = arguments[again:]
    cut = rest.index("--") if "--" in rest else len(rest)
    folders, options = rest[:cut], list(rest[cut + 1:])
    for effects in () if again else ("auto", "all"):
        batch(kiln, Path(out) / effects, folders, options, effects)
    names, good = compare(Path(out))
    table(measure(kiln, folders, names))
    return good


if __name__ == "__main__":
    sys.exit(0 if main(*sys.argv[1:]) else 1)
