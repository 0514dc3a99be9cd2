"""Compares the silhouettes of an animated glTF file in Blender and in batch-render.

    blender_motion.py PROGRAM MODEL [--animation NAME] [--frames 0 6 12 18 24] [--keep FOLDER]

Needs the packages bpy (5.x), numpy and pillow. Both programs render the model from one camera in these frames, Blender by Cycles. A pixel
is of the silhouette if its alpha is at least one half. Prints of each frame the intersection over the union, the pixels that differ, and
those of them that are farther than a pixel from the other silhouette. Fails if an intersection is below 0.99 or a pixel is farther.
"""

import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

import bpy
import numpy as np
from mathutils import Matrix, Vector
from PIL import Image

WIDTH, HEIGHT = 640, 480
FOV = 40.0
SAMPLES = 16


def bounds(frames):
    """The corners of all vertices in all frames, in Blender's space."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        for shown in bpy.context.scene.objects:
            if shown.type != "MESH":
                continue
            own = shown.evaluated_get(graph)
            mesh = own.to_mesh()
            points = np.empty(3 * len(mesh.vertices))
            mesh.vertices.foreach_get("co", points)
            matrix = np.array(own.matrix_world)
            points = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
            low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
            own.to_mesh_clear()
    return low, high


def to_gltf(point):
    """A point of Blender, whose z is up, in glTF, whose y is."""
    x, y, z = point
    return [float(x), float(z), float(-y)]


def prepare(model, animation, frames):
    """Loads the model into Blender, and returns the eye and the target of the camera, in Blender's space."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = 24
    # Without this Blender shows bones as small spheres of its own.
    bpy.ops.import_scene.gltf(filepath=str(model), disable_bone_shape=True)
    if animation is not None:
        for shown in scene.objects:
            data = shown.animation_data
            if data is None:
                continue
            for track in data.nla_tracks:
                is_it = track.name == animation
                track.mute = not is_it
                if is_it:
                    data.action = track.strips[0].action
                    if track.strips[0].action_slot is not None:
                        data.action_slot = track.strips[0].action_slot
    low, high = bounds(frames)
    target = (low + high) / 2
    size = float(np.linalg.norm(high - low))
    direction = np.array([0.6, -1.0, 0.35])
    eye = target + direction / np.linalg.norm(direction) * size * 0.75 / math.tan(math.radians(FOV / 2))
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit = "VERTICAL"
    camera.angle_y = math.radians(FOV)
    camera.clip_start, camera.clip_end = size * 1e-3, size * 1e3
    placed = bpy.data.objects.new("camera", camera)
    look = Vector(target - eye).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    placed.matrix_world = Matrix.Translation(Vector(eye)) @ look
    scene.collection.objects.link(placed)
    scene.camera = placed
    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 0
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.film_transparent = True
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGBA"
    return eye, target


def render_blender(folder, frames):
    scene = bpy.context.scene
    for frame in frames:
        scene.frame_set(frame)
        scene.render.filepath = str(folder / f"blender.{frame:04d}.png")
        bpy.ops.render.render(write_still=True)


def render_own(program, folder, model, animation, frames, eye, target):
    names = '"all"' if animation is None else f"'{animation}'"
    text = f"""
[render]
width = {WIDTH}
height = {HEIGHT}
samples = {SAMPLES}
filter = "box"
[camera]
perspective = {{ eye = {to_gltf(eye)}, target = {to_gltf(target)}, fov = {FOV} }}
[background]
color = 1
visible = false
[[object]]
shape.mesh = {{ file = '{model}', animation = {names} }}
"""
    scene = folder / "scene.toml"
    scene.write_text(text)
    frames = ",".join(str(frame) for frame in frames)
    command = [program, scene, "--range", frames, "-o", folder / "own.####.png", "--quiet"]
    subprocess.run(command, check=True)


def mask(path):
    return np.asarray(Image.open(path).convert("RGBA"))[:, :, 3] >= 128


def grown(mask):
    """The mask and all pixels beside it."""
    padded = np.pad(mask, 1)
    rows, columns = mask.shape
    shifts = [padded[y : y + rows, x : x + columns] for y in range(3) for x in range(3)]
    return np.logical_or.reduce(shifts)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("model", type=pathlib.Path)
    parser.add_argument("--animation")
    parser.add_argument("--frames", type=int, nargs="+", default=[0, 6, 12, 18, 24])
    parser.add_argument("--keep", type=pathlib.Path)
    given = parser.parse_args()
    folder = given.keep or pathlib.Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    model = given.model.resolve()
    eye, target = prepare(model, given.animation, given.frames)
    render_blender(folder, given.frames)
    render_own(given.program, folder, model, given.animation, given.frames, eye, target)
    is_right = True
    for frame in given.frames:
        own, other = mask(folder / f"own.{frame:04d}.png"), mask(folder / f"blender.{frame:04d}.png")
        overlap = np.count_nonzero(own & other) / max(np.count_nonzero(own | other), 1)
        differ = np.count_nonzero(own ^ other)
        far = np.count_nonzero(own & ~grown(other)) + np.count_nonzero(other & ~grown(own))
        print(
            f"{model.stem} frame {frame}: {np.count_nonzero(own)} pixels, intersection over union {overlap:.4f}, "
            f"{differ} differ, {far} beyond the edge"
        )
        is_right &= overlap >= 0.99 and far == 0
        both = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        both[own & other] = 160
        both[own & ~other] = [255, 0, 0]
        both[other & ~own] = [0, 80, 255]
        Image.fromarray(both).save(folder / f"both.{frame:04d}.png")
    sys.exit(not is_right)


main()
