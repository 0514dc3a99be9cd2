"""Compares lights and compositing surfaces in Blender's Cycles and in batch-render.

    blender_lights.py PROGRAM [--only NAME] [--keep FOLDER]

Needs the packages bpy (5.x), numpy and OpenEXR. A ball stands on a floor below one light of each kind, or on a shadow catcher, or is a
holdout. Both programs render it from one camera. Prints, for each scene, the ratio of the means of the pictures and the largest difference
of a block of 10x10 pixels from that of Cycles, relative to it. Fails if a mean differs by more than 2 %.
"""

import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

import bpy
import numpy as np
import OpenEXR
from mathutils import Vector

WIDTH, HEIGHT, BLOCK, SAMPLES = 160, 90, 10, 1024
EYE, TARGET, FOV = (0, 3, 8), (0, 0.8, 0), 40

# Of each scene: the light here, and the type, the place, the point it shines at and the attributes of the light there.
LIGHTS = {
    "rect": (
        "rect = { position = [-2, 4, 1], target = [0, 0.5, 0], size = [2, 1], power = 200 }",
        ("AREA", (-2, 4, 1), (0, 0.5, 0), {"energy": 200, "shape": "RECTANGLE", "size": 2, "size_y": 1}),
    ),
    "disk": (
        "disk = { position = [2, 4, 1], target = [0, 0.5, 0], radius = 0.7, power = 200 }",
        ("AREA", (2, 4, 1), (0, 0.5, 0), {"energy": 200, "shape": "DISK", "size": 1.4}),
    ),
    "point": (
        "point = { position = [2, 3, 2], radius = 0.4, power = 400 }",
        ("POINT", (2, 3, 2), (0, 0, 0), {"energy": 400, "shadow_soft_size": 0.4, "use_soft_falloff": False}),
    ),
    "spot": (
        "spot = { position = [2, 4, 2], target = [0, 0.5, 0], cone_angle = 30, power = 400, radius = 0.3 }",
        ("SPOT", (2, 4, 2), (0, 0.5, 0), {"energy": 400, "shadow_soft_size": 0.3, "spot_size": math.radians(60), "spot_blend": 0, "use_soft_falloff": False}),
    ),
    # Cycles takes 177.83 lm/W, its horizontal angle 0 lies below, and its angles grow clockwise.
    "ies": (
        f"point = {{ position = [-2, 4, 1], target = [0, 0.3, 0], ies = 'lamp.ies', up = [0, -1, 0], intensity = {683 / 177.83} }}",
        ("POINT", (-2, 4, 1), (0, 0.3, 0), {"energy": 1, "shadow_soft_size": 0, "use_soft_falloff": False}),
    ),
    "sun": (
        "sun = { direction = [-1, -2, -1], irradiance = 3, angle = 5 }",
        ("SUN", (1, 2, 1), (0, 0, 0), {"energy": 3, "angle": math.radians(5)}),
    ),
}


def write_lamp(path, side):
    """Writes an IES file of a lamp without any symmetry, which shines a little upwards as well; -1 as `side` mirrors it."""
    vertical, horizontal = [2.5 * i for i in range(73)], [15 * i for i in range(25)]

    def candela(v, h):
        a, b = math.radians(v), math.radians(h * side)
        beam = 1200 * max(math.cos(a), 0) ** 2 * (1 + 0.8 * math.sin(a) * math.cos(b) + 0.4 * math.sin(a) ** 2 * math.sin(b))
        ring = 400 * math.exp(-(((v - 55) / 12) ** 2)) * (1 + 0.5 * math.cos(2 * b))
        return beam + ring + 60 * max(-math.cos(a), 0)

    rows = [vertical, horizontal] + [[candela(v, h) for v in vertical] for h in horizontal]
    text = "\n".join(" ".join(f"{number:.6g}" for number in row) for row in rows)
    head = f"IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 {len(vertical)} {len(horizontal)} 1 2 0 0 0\n1 1 10\n"
    path.write_text(head + text + "\n")


def shine_by(data, file):
    """Gives a light of Blender the distribution of an IES file."""
    nodes, links = data.node_tree.nodes, data.node_tree.links
    nodes.clear()
    output, emission = nodes.new("ShaderNodeOutputLight"), nodes.new("ShaderNodeEmission")
    measured = nodes.new("ShaderNodeTexIES")
    measured.mode, measured.filepath = "EXTERNAL", str(file)
    links.new(measured.outputs["Factor" if "Factor" in measured.outputs else "Fac"], emission.inputs["Strength"])
    links.new(emission.outputs[0], output.inputs[0])


def to_blender(p):
    return Vector((p[0], -p[2], p[1]))


def look(thing, eye, target):
    thing.location = to_blender(eye)
    direction = to_blender(target) - to_blender(eye)
    thing.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()


def material(name, albedo):
    made = bpy.data.materials.new(name)
    nodes = made.node_tree.nodes
    nodes.clear()
    output, diffuse = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (*albedo, 1)
    made.node_tree.links.new(diffuse.outputs[0], output.inputs[0])
    return made


def cycles(light, floor, ball, world, path):
    """Renders the scene in Cycles; `floor` and `ball` are attributes of these objects."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = SAMPLES, False, False
    scene.cycles.pixel_filter_type, scene.cycles.max_bounces, scene.cycles.diffuse_bounces = "BOX", 4, 4
    scene.cycles.sample_clamp_indirect = 0
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.world = bpy.data.worlds.new("world")
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (world, world, world, 1)
    bpy.ops.mesh.primitive_plane_add(size=12)
    plane = bpy.context.object
    plane.data.materials.append(material("floor", (0.5, 0.5, 0.5)))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128, radius=0.8, location=(0, 0, 0.8))
    sphere = bpy.context.object
    bpy.ops.object.shade_smooth()
    sphere.data.materials.append(material("ball", (0.8, 0.2, 0.1)))
    for thing, attributes in ((plane, floor), (sphere, ball)):
        for name, value in attributes.items():
            setattr(thing, name, value)
    kind, place, target, attributes = light
    data = bpy.data.lights.new("light", kind)
    for name, value in attributes.items():
        setattr(data, name, value)
    if path.name.startswith("ies"):
        data.use_nodes = True
        shine_by(data, path.with_name("mirrored.ies"))
    lamp = bpy.data.objects.new("light", data)
    scene.collection.objects.link(lamp)
    look(lamp, place, target)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.data.sensor_fit, camera.data.angle_y = "VERTICAL", math.radians(FOV)
    look(camera, EYE, TARGET)
    scene.camera = camera
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def ours(program, light, floor, ball, world, path):
    scene = f"""
[render]
width = {WIDTH}
height = {HEIGHT}
samples = {SAMPLES}
filter = "box"
integrator.path = {{ max_depth = 5 }}
[output]
exr_type = "float"
[camera]
perspective = {{ eye = {list(EYE)}, target = {list(TARGET)}, fov = {FOV} }}
[background]
color = {world}
visible = false
[material.floor]
matte = {{ albedo = 0.5 }}
[material.ball]
matte = {{ albedo = [0.8, 0.2, 0.1] }}
[[object]]
material = "floor"
shape.quad = {{ corners = [[-6, 0, 6], [6, 0, 6], [6, 0, -6], [-6, 0, -6]] }}
{floor}
[[object]]
material = "ball"
shape.sphere = {{ center = [0, 0.8, 0], radius = 0.8 }}
{ball}
[[light]]
{light}
"""
    text = path.with_suffix(".toml")
    text.write_text(scene)
    subprocess.run([program, text, "-o", path, "--progress", "none", "--overwrite"], check=True)


def pixels(path):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    named = {name.split(".")[-1]: channels[name].pixels for name in channels}
    return np.stack([np.float64(named[c]) for c in "RGBA"], axis=-1)


def blocks(picture):
    rows, columns = HEIGHT // BLOCK, WIDTH // BLOCK
    return picture.reshape(rows, BLOCK, columns, BLOCK, -1).mean(axis=(1, 3))


def over(picture, plate=0.4):
    """The picture over a grey plate."""
    return picture[..., :3] + plate * (1 - picture[..., 3:])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--only")
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    folder = options.keep or pathlib.Path(tempfile.mkdtemp())
    folder.mkdir(exist_ok=True)
    write_lamp(folder / "lamp.ies", 1)
    write_lamp(folder / "mirrored.ies", -1)
    scenes = {name: (here, there, {}, "", {}, "", 0.0) for name, (here, there) in LIGHTS.items()}
    rect = LIGHTS["rect"]
    scenes["holdout"] = (*rect, {}, "", {"is_holdout": True}, "holdout = true", 0.3)
    scenes["catcher"] = (*rect, {"is_shadow_catcher": True}, "shadow_catcher = true", {}, "", 0.3)
    worst = 0.0
    for name, (here, there, floor, floor_here, ball, ball_here, world) in scenes.items():
        if options.only not in (None, name):
            continue
        paths = [folder / f"{name}.{who}.exr" for who in ("cycles", "ours")]
        cycles(there, floor, ball, world, paths[0])
        ours(options.program, here, floor_here, ball_here, world, paths[1])
        # Catchers and holdouts count by what they make of a plate.
        a, b = (pixels(path) for path in paths)
        a, b = (over(a), over(b)) if name in ("catcher", "holdout") else (a[..., :3], b[..., :3])
        mean = b.mean() / a.mean()
        a, b = blocks(a), blocks(b)
        difference = np.abs(b - a) / (np.abs(a) + 0.02 * a.mean())
        print(f"{name}: mean {mean:.4f}, largest block {difference.max():.4f}, median {np.median(difference):.4f}", flush=True)
        worst = max(worst, abs(mean - 1))
    return int(worst > 0.02)


if __name__ == "__main__":
    sys.exit(main())
