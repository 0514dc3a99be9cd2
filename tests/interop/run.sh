#!/usr/bin/env bash
# Renders files of every kind and checks them with tools that nobody here wrote: OpenImageIO, OpenEXR, NumPy, ffmpeg,
# cryptomatte-api, COLMAP and OpenCV, in a virtual environment of their own. Usage: tests/interop/run.sh [PROGRAM]. Where pip reaches no packages it says so, and is no error.
set -euo pipefail
cd "$(dirname "$0")/../.."

program=$(realpath "${1:-${CARGO_TARGET_DIR:-target}/release/batch-render}")
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

packages=(OpenImageIO==3.2.2.0 OpenEXR==3.5.3 cryptomatte-api==1.0.0 jsonschema==4.26.0 imageio-ffmpeg taplo==0.9.3
    pycolmap==4.2.1 opencv-python-headless==5.0.0.93)
if ! { python3 -m venv "$out/venv" && "$out/venv/bin/pip" install -q "${packages[@]}"; } >"$out/pip.log" 2>&1; then
    echo "no files were checked by other tools: pip does not install ${packages[*]}"
    exit 0
fi

render() {
    local name=$1
    shift
    "$program" scenes/passes/scene.toml --resolution 96x54 --samples 8 --progress none -o "$out/$name.exr" "$@"
}

for compression in none zips zip piz rle; do
    render "$compression" --compression "$compression"
done
render dwaa --compression dwaa --aovs emission,albedo
render float --exr-type float
render parts --multipart
render tiled --tiled
render tiled-piz --tiled --compression piz
render tiled-dwaa --tiled --compression dwaa --aovs emission,albedo
render tiled-parts --tiled --multipart --crop 11,7,96,54
render crop --crop 11,7,60,40
render overscan --overscan 9
render one-level --cryptomatte-levels 2
"$program" tests/interop/names.toml --progress none -o "$out/names.exr"
render arrays --exr-type float -o "$out/stored.npz"
render deflated -o "$out/deflated.npz" --npz-compression deflate
turn=("$program" scenes/passes/scene.toml --resolution 96x54 --samples 8 --progress none --turntable 3 --fps 25)
"${turn[@]}" -o - --output-format y4m >"$out/turn.y4m"
"${turn[@]}" -o "$out/turn.gif" -o "$out/turn.apng" -o "$out/turn.#.jpg"
render shown --show depth -o "$out/shown.png"
render pictures --png-depth="$out/depth.####.png" --png-bits 16 -o "$out/sixteen.png"
for view in raw srgb reinhard aces agx neutral; do
    "$program" scenes/passes/scene.toml --resolution 96x54 --samples 8 --progress none --view "$view" -o "$out/$view.png"
done

"$out/venv/bin/python" tests/interop/check.py "$out" "$out/venv/bin"
"$out/venv/bin/python" tests/interop/schemas.py "$program" "$out"

# An editor's view of scene files: all of them are valid, and a wrong key is not.
lint() {
    "$out/venv/bin/taplo" lint --schema "file://$PWD/docs/schema/scene.json" "$@" >"$out/taplo.log" 2>&1
}
lint scenes/*/*.toml || { cat "$out/taplo.log"; exit 1; }
printf '[render]\nwdith = 4\n' >"$out/wrong.toml"
if lint "$out/wrong.toml" || ! grep -q "'wdith' was unexpected" "$out/taplo.log"; then
    echo "taplo finds no wrong key"
    exit 1
fi
echo "taplo finds all scenes valid"

mkdir "$out/cameras"
"$out/venv/bin/python" tests/interop/cameras.py "$program" "$out/cameras"
