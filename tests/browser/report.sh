#!/usr/bin/env bash
# Opens the report of a small study in a real browser, without a network, and looks whether all of it is there:
# every picture decoded, every plot with a size, nothing wider than the page, no error of a script, in light and in dark.
# Usage: report.sh KILN [FOLDER FOR SCREENSHOTS]. Needs chromium.
set -euo pipefail
kiln=$(realpath "$1")
screenshots=${2:-}
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$kiln" study "$here/scenes/samples/cornell_box.glb" "$here/scenes/samples/frosted_dice.gltf" --out "$work/study" \
    --width 64 --budget 4 --reference-spp 128 --quiet

# The page reports on itself in an attribute of its root.
python3 - "$work/study/report.html" "$work/probe.html" <<'PYTHON'
import sys
report = open(sys.argv[1], encoding="utf-8").read()
probe = """<script>
addEventListener("load", () => {
  const pictures = [...document.images], plots = [...document.querySelectorAll("svg.plot")];
  document.querySelectorAll("details").forEach(d => d.open = true);
  const root = document.documentElement;
  root.dataset.probe = JSON.stringify({
    pictures: pictures.length, decoded: pictures.filter(p => p.naturalWidth == 64 && p.alt).length,
    plots: plots.length, drawn: plots.filter(p => p.getBoundingClientRect().width > 300 && p.querySelector(".mark")).length,
    verdicts: [...document.querySelectorAll(".verdict")].filter(v => v.textContent.includes("levels")).length,
    rows: document.querySelectorAll("tbody tr").length, headed: document.querySelectorAll("tbody th[scope=row]").length,
    overflow: root.scrollWidth - root.clientWidth,
    requests: performance.getEntriesByType("resource").filter(r => !r.name.startsWith("data:")).length,
    ink: getComputedStyle(document.body).color,
  });
});
</script>"""
open(sys.argv[2], "w", encoding="utf-8").write(report.replace("</body>", probe + "</body>"))
PYTHON

browser=(chromium --headless --no-sandbox --disable-gpu --user-data-dir="$work/profile" --hide-scrollbars
    --host-resolver-rules="MAP * ~NOTFOUND" --virtual-time-budget=4000)
for scheme in light dark; do
    [ $scheme = dark ] && theme=(--blink-settings=preferredColorScheme=0) || theme=(--blink-settings=preferredColorScheme=1)
    for width in 1280 420; do
        "${browser[@]}" "${theme[@]}" --window-size=$width,1000 --dump-dom "file://$work/probe.html" >"$work/dom.html" 2>/dev/null
        if [ -n "$screenshots" ]; then
            mkdir -p "$screenshots"
            "${browser[@]}" "${theme[@]}" --window-size=$width,3200 --screenshot="$screenshots/report-$scheme-$width.png" \
                "file://$work/study/report.html" 2>/dev/null
        fi
        python3 - "$work/dom.html" $scheme $width <<'PYTHON'
import html, json, re, sys
found = re.search(r'data-probe="([^"]*)"', open(sys.argv[1], encoding="utf-8").read())
assert found, "the page did not load"
probe = json.loads(html.unescape(found[1]))
dark = sum(map(int, re.findall(r"\d+", probe["ink"])[:3])) > 384
assert dark == (sys.argv[2] == "dark"), probe
assert probe["pictures"] >= 20 and probe["decoded"] == probe["pictures"], probe
assert probe["plots"] == 6 and probe["drawn"] == 6, probe
assert probe["verdicts"] == 2 and probe["rows"] > 40 and probe["rows"] == probe["headed"], probe
assert probe["overflow"] <= 0 and probe["requests"] == 0, probe
print("report in", sys.argv[2], sys.argv[3], "pixels wide:", probe)
PYTHON
    done
done
