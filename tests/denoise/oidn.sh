#!/usr/bin/env bash
# Removes noise with the real Open Image Denoise, and looks whether the picture comes nearer to the converged one.
# Usage: oidn.sh KILN PYTHON. The Python needs pyoidn from PyPI, which brings the program along.
set -euo pipefail
kiln=$(realpath "$1")
python=$2
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
denoiser=$("$python" -c 'import importlib.util, os; print(os.path.dirname(importlib.util.find_spec("pyoidn").origin))')/oidn/bin/oidnDenoise
chmod +x "$denoiser"
asset=$here/scenes/samples/kintsugi.glb
options=(--width 128 --quiet --no-config --background '#ffffff')
"$kiln" render "$asset" "${options[@]}" --spp 4 --denoise="$denoiser" -o "$work/few.png"
"$kiln" render "$asset" "${options[@]}" --spp 1024 --seed 1 -o "$work/many.png"
rmse() { "$kiln" compare "$work/$1" "$work/many.png" --json | "$python" -c 'import json, sys; print(json.load(sys.stdin)["rmse"])'; }
noisy=$(rmse few.png)
denoised=$(rmse few.denoised.png)
echo "RMS levels of 255 from the converged picture: $noisy with 4 samples, $denoised denoised"
"$python" -c "import sys; sys.exit(not $denoised < 0.6 * $noisy)"
grep -aq 'Open Image Denoise 2' "$work/few.denoised.png"
