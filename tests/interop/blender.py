"""Opens a multilayer file in Blender and keys an object with the Cryptomatte node.

`python blender.py FILE.exr OBJECT`, where the environment has `bpy` and `OpenImageIO`. It prints the layers that Blender finds, and how far its matte
is from the coverage in the file; it ends with 1 where the difference is more than a half can hold.
"""

import json
import os
import struct
import sys
import tempfile

import bpy
import numpy
import OpenImageIO as oiio

path, name = os.path.abspath(sys.argv[1]), sys.argv[2]
image = bpy.data.images.load(path)
file = oiio.ImageInput.open(path)
spec = file.spec()
width, height = spec.full_width, spec.full_height

scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.samples = 1
scene.cycles.device = "CPU"
scene.render.resolution_x, scene.render.resolution_y = width, height
scene.render.resolution_percentage = 100
for thing in list(scene.objects):
    if thing.type != "CAMERA":
        bpy.data.objects.remove(thing)


def tree():
    """The tree of the compositor, and a function that makes a socket the picture of the scene."""
    if hasattr(scene, "compositing_node_group"):
        group = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
        scene.compositing_node_group = group
        group.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        return group, group.nodes.new("NodeGroupOutput").inputs[0]
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree, scene.node_tree.nodes.new("CompositorNodeComposite").inputs[0]


nodes, picture = tree()


def render(socket):
    """The pixels of a socket, from the bottom row up."""
    nodes.links.new(socket, picture)
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    scene.render.filepath = os.path.join(tempfile.mkdtemp(), "out.exr")
    bpy.ops.render.render(write_still=True)
    out = bpy.data.images.load(scene.render.filepath)
    out.colorspace_settings.name = "Non-Color"
    pixels = numpy.array(out.pixels[:], dtype=numpy.float32)
    return pixels.reshape(height, width, -1)[:, :, :3]


source = nodes.nodes.new("CompositorNodeImage")
source.image = image
print("Blender", bpy.app.version_string, "opens", os.path.basename(path), image.type, [width, height])
print("layers of the image node:", [output.name for output in source.outputs if output.enabled])

crypto = nodes.nodes.new("CompositorNodeCryptomatteV2")
crypto.source = "IMAGE"
crypto.image = image
print("Cryptomatte layers:", [item.name for item in crypto.bl_rna.properties["layer_name"].enum_items], crypto.layer_name)
crypto.matte_id = name
print("entries:", [(entry.name, round(entry.encoded_hash, 9)) for entry in crypto.entries])
matte = render(crypto.outputs["Matte"])[:, :, 0]

pixels = file.read_image(0, 0, 0, spec.nchannels, "float")
channel = {channel: pixels[::-1, :, i] for i, channel in enumerate(spec.channelnames)}
manifest = next(a.value for a in spec.extra_attribs if a.name == "cryptomatte/3ae39a5/manifest")
ident = struct.unpack("<f", struct.pack("<I", int(json.loads(manifest)[name], 16)))[0]
coverage = sum(
    numpy.where(channel[f"CryptoObject0{layer}.{i}"] == numpy.float32(ident), channel[f"CryptoObject0{layer}.{c}"], 0)
    for layer in range(3)
    for i, c in ("RG", "BA")
)
off = float(abs(matte - coverage).max())
print(f"matte of {name!r}: {float(matte.sum()):.3f} pixels, {float(coverage.sum()):.3f} in the file, off by {off:.1e} at most")
sys.exit(not (off < 1e-3 and coverage.sum() > 1))
