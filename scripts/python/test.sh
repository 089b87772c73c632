#!/usr/bin/env bash
# Builds the wheel, installs it into a virtual environment of its own and runs the package's tests.
# Usage: test.sh FOLDER FOR THE ENVIRONMENT [WHAT PYTEST TAKES]. Needs Rust, python3 and PyPI.
set -euo pipefail
cd "$(dirname "$0")"
environment=$1
shift
[ -x "$environment/bin/pip" ] || python3 -m venv "$environment"
bin=$(realpath "$environment")/bin
"$bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9,<2' 'numpy>=1.23' 'pytest>=8' 'jsonschema>=4' pillow mypy
# The versions of the main workspace, and what it has compiled already; optimised a little less, which is quicker to build.
cp ../../Cargo.lock Cargo.lock
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$(realpath ../..)/target}
wheels=$(mktemp -d)
trap 'rm -rf "$wheels"' EXIT
"$bin/maturin" build --release --quiet --interpreter "$bin/python" --out "$wheels" --config profile.release.package.kiln.codegen-units=16
"$bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps "$wheels"/kiln-*-abi3-*.whl
"$bin/mypy" --strict python/kiln
PYTHONDONTWRITEBYTECODE=1 "$bin/python" -m pytest -q -p no:cacheprovider "$@"
"$bin/python" examples/contact_sheet.py ../../scenes/samples "$wheels/sheet.png" --size 48 --error 40 >"$wheels/told.txt"
grep -q cornell_box.glb "$wheels/told.txt" && [ -s "$wheels/sheet.png" ]
