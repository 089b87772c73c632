#!/usr/bin/env bash
# Opens galleries of real batches in a real browser and uses them: tests/browser/gallery.py says what is looked at.
# Usage: gallery.sh KILN PYTHON [FOLDER FOR SCREENSHOTS]. Needs chromium, and a Python with Playwright (PyPI: playwright).
set -euo pipefail
kiln=$(realpath "$1")
python=$2
screenshots=${3:-}
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Assets: two good ones, names in several scripts and with everything that HTML and addresses mind, and one broken file.
assets="$work/assets"
mkdir -p "$assets/furniture" "$assets/имена" "$assets/evil<"
cp "$here/scenes/samples/cornell_box.glb" "$here/scenes/samples/frosted_dice.gltf" "$assets/furniture/"
square='v -0.5 0 0\nv 0.5 0 0\nv 0.5 1 0\nv -0.5 1 0\nv 0 0 1\nf 1 2 3 4\nf 1 2 5\n'
# The fourth is one path with "</script>" in it.
for name in '椅子.obj' 'имена/стул № 1.obj' 'كرسي.obj' 'evil</script><script>throw 1<!--.obj' "50% off #1 & \"new\" <b>it's @@@.obj" '😀 ?a=b.obj'; do
    printf "$square" >"$assets/$name"
done
printf 'mtllib missing.mtl\nusemtl gone\n'"$square" >"$assets/warned.obj"
printf 'f 1 2 3\n' >"$assets/broken.obj"

batch() { "$kiln" batch "$assets" --width 96 --format png --quiet "$@" || [ $? = 3 ]; }
batch --out "$work/earlier #1" --spp 1 --turntable 6 --exclude '😀*'
rm "$assets/warned.obj"
batch --out "$work/now" --spp 8 --turntable 6 --against "$work/earlier #1"
"$python" "$here/tests/browser/gallery.py" "$kiln" "$work" "$screenshots"
