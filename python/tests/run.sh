#!/usr/bin/env bash
# Tests the Python package with a program, and builds and installs its wheel. Usage: python/tests/run.sh [PROGRAM].
# Where pip reaches no packages it says so, and is no error.
set -euo pipefail
cd "$(dirname "$0")/../.."

program=$(realpath "${1:-${CARGO_TARGET_DIR:-target}/release/batch-render}")
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

packages=(numpy pytest mypy "maturin>=1.7,<2")
if ! { python3 -m venv "$out/venv" && "$out/venv/bin/pip" install -q "${packages[@]}"; } >"$out/pip.log" 2>&1; then
    echo "the Python package was not tested: pip does not install ${packages[*]}"
    exit 0
fi
bin=$out/venv/bin

"$bin/mypy" --strict --cache-dir "$out/mypy" python/batch_render
BATCH_RENDER=$program PYTHONPATH=python PYTHONDONTWRITEBYTECODE=1 "$bin/python" -m pytest -q -p no:cacheprovider python/tests

# The wheel, of the features with which the program is built already. That of a release has no viewer and is smaller.
(cd python && "$bin/maturin" build --release --locked --features default --out "$out/wheels") >"$out/maturin.log" 2>&1 || {
    cat "$out/maturin.log"
    exit 1
}
wheel=("$out"/wheels/*.whl)
echo "${wheel[0]##*/}: $(wc -c <"${wheel[0]}") bytes"
"$bin/pip" install -q --no-deps "${wheel[0]}"
cd "$out"
"$bin/python" - <<'PYTHON'
import batch_render

scene = {
    "render": {"width": 16, "height": 16, "samples": 1},
    "camera": {"perspective": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov": 30}},
    "background": {"color": [0.25, 0.5, 1]},
}
frame = next(batch_render.render(scene))
assert frame["rgba"].shape == (16, 16, 4) and (frame["rgba"][..., 2] == 1).all()
PYTHON
