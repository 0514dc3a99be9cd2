"""Checks the files of tests/interop/run.sh: check.py FOLDER BIN, where BIN has oiiotool and idiff."""

import json
import pathlib
import subprocess
import sys

import cryptomatte_api
import numpy
import OpenEXR
import OpenImageIO as oiio

folder, tools = map(pathlib.Path, sys.argv[1:3])
problems = []


def check(ok, what):
    if not ok:
        problems.append(what)
        print("WRONG:", what)


def tool(name, *args):
    done = subprocess.run([tools / name, *map(str, args)], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def read(path):
    """The channels of all parts of a file by name, and the header of the first."""
    image = oiio.ImageInput.open(str(path))
    channels, part = {}, 0
    first = image.spec()
    while image.seek_subimage(part, 0):
        spec = image.spec()
        pixels = image.read_image(part, 0, 0, spec.nchannels, "float")
        for i, name in enumerate(spec.channelnames):
            channels[name] = pixels[:, :, i]
        part += 1
    return channels, first


def check_exr(path):
    code, text = tool("oiiotool", "--hash", path)
    check(code == 0, f"{path.name}: oiiotool: {text}")
    check(OpenEXR.InputFile(str(path)).isComplete(), f"{path.name} is not complete")
    header = OpenEXR.InputFile(str(path)).header()
    check(header["software"].startswith(b"batch-render "), f"{path.name}: software")
    if path.name != "shown.exr":
        check("chromaticities" in header, f"{path.name}: chromaticities")
        check(header["colorInteropID"] == b"lin_rec709_scene", f"{path.name}: colorInteropID")
    return header


def check_mattes(path):
    channels, spec = read(path)
    alpha = channels["A"]
    manifests = {a.name: a.value for a in spec.extra_attribs if a.name.endswith("/manifest")}
    names = [set(json.loads(text)) for text in manifests.values()]
    decoded = cryptomatte_api.Cryptomatte.load(str(path))
    check(len(decoded) == len(manifests) > 0, f"{path.name}: {len(decoded)} Cryptomattes")
    for matte in decoded:
        masks = matte.masks()
        check(set(masks) in names, f"{path.name}: the names {sorted(masks)}")
        total = sum(numpy.asarray(mask).reshape(alpha.shape) for mask in masks.values())
        off = float(abs(total - alpha).max())
        kept = matte.num_levels()
        check(off < 6e-4 or kept == 2, f"{path.name}: the mattes miss alpha by {off}")
        print(f"{path.name}: {len(masks)} mattes in {kept} levels, off alpha by {off:.1e}")
        for name, mask in masks.items():
            check(float(numpy.asarray(mask).sum()) > 0.5, f"{path.name}: the matte of {name} is empty")


for path in sorted(folder.glob("*.exr")):
    check_exr(path)
for name in ["zips", "zip", "piz", "rle", "float", "overscan", "crop", "names", "one-level"]:
    check_mattes(folder / f"{name}.exr")

plain, _ = read(folder / "none.exr")
for name in ["zips", "zip", "piz", "rle", "tiled", "tiled-piz"]:
    code, text = tool("idiff", "-a", "-fail", 0, "-warn", 0, folder / "none.exr", folder / f"{name}.exr")
    check(code == 0, f"{name}.exr differs from none.exr: {text}")
parts, _ = read(folder / "parts.exr")
for name, values in plain.items():
    check(name in parts and numpy.array_equal(parts[name], values, equal_nan=True), f"parts.exr: {name}")

_, spec = read(folder / "crop.exr")
check((spec.x, spec.y, spec.width, spec.height) == (11, 7, 49, 33), "the data window of the crop")
_, spec = read(folder / "overscan.exr")
check((spec.x, spec.y, spec.width, spec.height) == (-9, -9, 114, 72), "the data window of the overscan")
check((spec.full_x, spec.full_width, spec.full_height) == (0, 96, 54), "the display window of the overscan")

channels, _ = read(folder / "pictures.exr")
depth = oiio.ImageInput.open(str(folder / "depth.0001.png")).read_image("uint16")[:, :, 0]
expected = numpy.where(channels["depth.Z"] < 1e9, numpy.clip(numpy.round(channels["depth.Z"] * 1000), 1, 65535), 0)
check(abs(depth.astype(float) - expected).max() <= 1, "the depth in millimetres")
straight = oiio.ImageSpec()
straight["oiio:UnassociatedAlpha"] = 1
sixteen = oiio.ImageInput.open(str(folder / "sixteen.png"), straight).read_image("uint16")
eight = oiio.ImageInput.open(str(folder / "srgb.png"), straight).read_image("uint8")
check(abs(sixteen / 257.0 - eight).max() < 0.51, "8 and 16 bits of a picture")

print(f"{len(list(folder.glob('*.exr')))} EXR files, {len(problems)} problems")
sys.exit(bool(problems))
