"""Checks cameras with COLMAP's and OpenCV's own readers and projections: cameras.py PROGRAM FOLDER."""

import pathlib
import subprocess
import sys

import cv2
import numpy
import OpenEXR
import pycolmap

program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
problems = []
size = [96, 64]
MODELS = {
    "SIMPLE_PINHOLE": [80, 47, 33],
    "PINHOLE": [80, 82, 47, 33],
    "SIMPLE_RADIAL": [80, 47, 33, -0.1],
    "RADIAL": [80, 47, 33, -0.1, 0.02],
    "OPENCV": [80, 82, 47, 33, -0.1, 0.02, 0.001, -0.002],
    "FULL_OPENCV": [80, 82, 47, 33, -0.1, 0.02, 0.001, -0.002, 0.01, 0.02, 0.03, 0.001],
    "SIMPLE_FISHEYE": [60, 47, 33],
    "FISHEYE": [60, 61, 47, 33],
    "SIMPLE_RADIAL_FISHEYE": [60, 47, 33, 0.02],
    "RADIAL_FISHEYE": [60, 47, 33, 0.02, 0.001],
    "OPENCV_FISHEYE": [60, 61, 47, 33, 0.02, -0.01, 0.003, 0.001],
}


def check(ok, what):
    if not ok:
        problems.append(what)
        print("WRONG:", what)


def run(*args):
    done = subprocess.run([program, *map(str, args)], capture_output=True, text=True)
    check(done.returncode == 0, f"{args}: {done.stderr}")


def pose(angle):
    """The map from the world to a camera that looks at the middle, along +z with +y down."""
    eye = numpy.array([3 * numpy.cos(angle), 1 + 0.3 * angle, 3 * numpy.sin(angle)])
    forward = numpy.array([0.1, 0, 0.2]) - eye
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(forward, [0, 1, 0])
    right /= numpy.linalg.norm(right)
    rotation = numpy.stack([right, numpy.cross(forward, right), forward])
    return rotation, -rotation @ eye


def cameras(path):
    """The cameras of a reconstruction by the names of pictures, as COLMAP reads them."""
    found = pycolmap.Reconstruction(path)
    of = {}
    for image in found.images.values():
        camera, place = found.cameras[image.camera_id], image.cam_from_world()
        of[image.name] = (camera, place.rotation.matrix(), numpy.array(place.translation))
    return of


def check_points(cameras_of_job, project, name):
    """Renders with these cameras and compares the points of the pass P with their pixels."""
    for old in folder.glob("camera.*.exr"):
        old.unlink()
    scene = "tests/interop/cameras.toml"
    flags = ["--samples", "1", "--aovs", "P", "--exr-type", "float", "--progress", "none"]
    run(scene, "--frames", cameras_of_job, "-o", folder / "camera.####.exr", *flags)
    worst, seen = 0.0, 0
    pictures = sorted(folder.glob("camera.*.exr"))
    check(len(pictures) == len(poses), f"{name}: {len(pictures)} pictures")
    for picture, (rotation, translation) in zip(pictures, poses):
        channels = OpenEXR.File(str(picture), separate_channels=True).channels()
        points = numpy.stack([channels[f"P.{axis}"].pixels for axis in "XYZ"], axis=-1).astype(float)
        check(points.shape[:2] == (size[1], size[0]), f"{name}: {points.shape}")
        there = numpy.any(points != 0, axis=-1)
        rows, columns = numpy.nonzero(there)
        pixels = project(points[there] @ rotation.T + translation)
        off = numpy.abs(pixels - numpy.stack([columns + 0.5, rows + 0.5], axis=-1))
        worst, seen = max(worst, numpy.nanmax(off)), seen + len(rows)
    check(worst < 1e-3 and seen > 1000, f"{name}: {seen} points, {worst} pixels")


poses = [pose(angle) for angle in numpy.linspace(0, 2, 4)]
for model, parameters in MODELS.items():
    camera = pycolmap.Camera(model=model, width=size[0], height=size[1], params=parameters, camera_id=7)
    model_of_all = pycolmap.Reconstruction()
    model_of_all.add_camera_with_trivial_rig(camera)
    for i, (rotation, translation) in enumerate(poses):
        image = pycolmap.Image(name=f"images/f_{12 + 3 * i:04}.png", camera_id=7, image_id=20 - i)
        place = pycolmap.Rigid3d(pycolmap.Rotation3d(rotation), translation)
        model_of_all.add_image_with_trivial_frame(image, place)
    for form in ["text", "binary"]:
        path = folder / f"{model}_{form}"
        path.mkdir()
        getattr(model_of_all, f"write_{form}")(path)
        check_points(path, lambda points: numpy.array(camera.img_from_cam(points)), f"{model}, {form}")
        for target in [path / "again/images.bin", path / "texts/images.txt"]:
            run("convert-camera", path, target)
            for name, (own, rotation, translation) in cameras(path).items():
                again, turned, moved = cameras(target.parent)[name]
                points = numpy.random.default_rng(1).normal(size=(100, 3)) * 0.5
                seen = [numpy.array(c.img_from_cam(points @ r.T + t)) for c, r, t in
                        [(own, rotation, translation), (again, turned, moved)]]
                check(numpy.nanmax(numpy.abs(seen[0] - seen[1])) < 1e-9, f"{target}: {name}")
    if model.startswith("SIMPLE_R") or model == "RADIAL_FISHEYE":
        continue
    run("convert-camera", folder / f"{model}_text", folder / "lens.yml")
    store = cv2.FileStorage(str(folder / "lens.yml"), cv2.FILE_STORAGE_READ)
    matrix, coefficients, rows = (store.getNode(name).mat() for name in
                                  ["camera_matrix", "distortion_coefficients", "extrinsic_parameters"])
    project = cv2.fisheye.projectPoints if store.getNode("fisheye_model").real() else cv2.projectPoints
    zero = numpy.zeros((3, 1))
    points_of = lambda points: project(points.reshape(-1, 1, 3), zero, zero, matrix, coefficients)[0].reshape(-1, 2) + 0.5
    check_points(folder / f"{model}_text", points_of, f"{model} by OpenCV")
    for (rotation, translation), row in zip(poses, rows):
        check(numpy.abs(cv2.Rodrigues(row[:3])[0] - rotation).max() < 1e-9, f"{model}: rvec")
        check(numpy.abs(row[3:] - translation).max() < 1e-9, f"{model}: tvec")
    copy = cv2.FileStorage(str(folder / "copy.yml"), cv2.FILE_STORAGE_WRITE)
    for name, value in [("image_width", size[0]), ("image_height", size[1]), ("camera_matrix", matrix),
                        ("distortion_coefficients", coefficients), ("extrinsic_parameters", rows),
                        ("fisheye_model", int(store.getNode("fisheye_model").real()))]:
        copy.write(name, value)
    copy.release()
    check_points(folder / "copy.yml", points_of, f"{model} as OpenCV writes it")

print("cameras:", "wrong" if problems else "as COLMAP and OpenCV see them")
sys.exit(bool(problems))
