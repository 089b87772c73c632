#!/usr/bin/env bash
# Reads the layers of an EXR file with programs that are not ours: tests/compositing/layers.py says what is looked at.
# Usage: layers.sh KILN PYTHON. The Python needs OpenImageIO (with its oiiotool) and cryptomatte-api from PyPI.
set -euo pipefail
kiln=$(realpath "$1")
python=$2
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$kiln" render "$here/scenes/samples/frosted_dice.gltf" -o "$work/dice.exr" --width 96 --spp 16 --quiet --no-config \
    --layers albedo,normal,depth,object,material
"$(dirname "$python")/oiiotool" --info -v "$work/dice.exr" >"$work/told.txt"
"$python" "$here/tests/compositing/layers.py" "$work/dice.exr" "$work/told.txt"
