"""Checks the files of tests/interop/run.sh: check.py FOLDER BIN, where BIN has oiiotool and idiff."""

import json
import pathlib
import subprocess
import sys
import zipfile

import cryptomatte_api
import imageio_ffmpeg
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

channels = OpenEXR.File(str(folder / "arrays.exr"), separate_channels=True).channels()
stored, deflated = (numpy.load(folder / f"{name}.npz") for name in ["stored", "deflated"])
check(stored.files == deflated.files, "the names of the arrays")
metadata = json.loads(stored["metadata"].item())
check(metadata["resolution"] == [96, 54], "the resolution in the metadata")
exr_names = {"rgba": ["R", "G", "B", "A"]}
ORDER = "RXUuAGYVvBZz"
for name in stored.files:
    check(name == "metadata" or numpy.array_equal(stored[name], deflated[name], equal_nan=True), f"deflated {name}")
    array = stored[name].reshape(*stored[name].shape[:2], -1) if stored[name].ndim else None
    of_exr = exr_names.get(name) or [channel for channel in channels if channel.rpartition(".")[0] == name]
    of_exr = of_exr if name in exr_names else sorted(of_exr, key=lambda channel: ORDER.index(channel[-1]))
    if name != "metadata" and not name.startswith("Crypto"):
        check(len(of_exr) == array.shape[2], f"{name} has the channels of the EXR file")
        pairs = [(array[:, :, i], channels[channel].pixels) for i, channel in enumerate(of_exr)]
        check(all(a.dtype == b.dtype and numpy.array_equal(a, b) for a, b in pairs), f"{name} as in the EXR file")
    check(name == "metadata" or stored[name].dtype in ["float32", "uint32"], f"the type of {name}")
ids, coverage = stored["CryptoObject"], stored["CryptoObject_coverage"]
for name, value in metadata["mattes"]["CryptoObject"].items():
    check(coverage[ids == value].sum() > 0.5, f"the matte of {name} in the arrays")
with zipfile.ZipFile(folder / "stored.npz") as archive:
    check(archive.testzip() is None, "the checksums of the archive")
    place = archive.getinfo("depth.npy")
with open(folder / "stored.npz", "rb") as file:
    file.seek(place.header_offset + 26)
    name_length, field_length = (int.from_bytes(file.read(2), "little") for _ in range(2))
    file.seek(place.header_offset + 30 + name_length + field_length)
    numpy.lib.format.read_magic(file)
    shape, order, dtype = numpy.lib.format.read_array_header_1_0(file)
    mapped = numpy.memmap(file, dtype, "r", file.tell(), shape)
check(mapped.ctypes.data % 64 == 0 and numpy.array_equal(mapped, stored["depth"]), "the depth, mapped")



def frames_of(path, *filters):
    """The frames of a moving picture as ffmpeg reads them, in RGB."""
    args = ["-i", str(path), *filters, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run([imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", *args], capture_output=True)
    check(done.returncode == 0, f"{path.name}: ffmpeg: {done.stderr}")
    return numpy.frombuffer(done.stdout, "uint8").reshape(-1, 54, 96, 3).astype(float)


limits = {"turn.apng": 0.0, "turn.gif": 12.0, "turn.y4m": 1.0}
films = {name: frames_of(folder / name) for name in ["turn.apng", "turn.gif"]}
bt709 = ["-vf", "scale=in_color_matrix=bt709:in_range=tv:out_range=pc"]
films["turn.y4m"] = frames_of(folder / "turn.y4m", *bt709)
films["the JPEG files"] = [frames_of(folder / f"turn.{frame}.jpg")[0] for frame in (1, 2, 3)]
for name, film in films.items():
    check(len(film) == 3, f"{name} has three frames")
    off = max(abs(frame - expected).mean() for frame, expected in zip(film, films["turn.apng"]))
    print(f"{name}: off the animated PNG by {off:.2f} of 255")
    check(off <= limits.get(name, 2.0), f"the colours of {name}")

print(f"{len(list(folder.glob('*.exr')))} EXR files, {len(problems)} problems")
sys.exit(bool(problems))
