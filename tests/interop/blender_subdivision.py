"""Compares subdivided meshes with Blender's, which are OpenSubdiv's.

    blender_subdivision.py SUBDIVIDE

SUBDIVIDE is the example program `subdivide`. Needs the packages bpy (5.x) and numpy. Prints for each mesh, scheme and level the number of
vertices and the farthest that a vertex of the one is from the nearest vertex of the other, relative to the size of the mesh; and the same of
texture coordinates at the same place. Blender's
vertices are those on the limit surface, too. Fails if one is farther than 1e-5.
"""

import pathlib
import subprocess
import sys
import tempfile

import bpy  # Before the modules that come with it.
import bmesh
import numpy as np
from mathutils.kdtree import KDTree

BOUND = 1e-5


def cube(creased=0.0):
    mesh = bpy.data.meshes.new("cube")
    shape = bmesh.new()
    shape.loops.layers.uv.new("uv")
    bmesh.ops.create_cube(shape, size=2.0, calc_uvs=True)
    layer = shape.edges.layers.float.new("crease_edge")
    for edge in shape.edges:
        edge[layer] = creased
    shape.to_mesh(mesh)
    return mesh


def suzanne():
    mesh = bpy.data.meshes.new("suzanne")
    shape = bmesh.new()
    shape.loops.layers.uv.new("uv")
    bmesh.ops.create_monkey(shape, calc_uvs=True)
    # Two pairs of its vertices are at the same positions, which are one for us.
    bmesh.ops.remove_doubles(shape, verts=shape.verts, dist=1e-9)
    shape.to_mesh(mesh)
    return mesh


def sheet():
    """An open grid whose corners are not in a plane."""
    mesh = bpy.data.meshes.new("sheet")
    shape = bmesh.new()
    bmesh.ops.create_grid(shape, x_segments=3, y_segments=2, size=1.0)
    for number, vertex in enumerate(shape.verts):
        vertex.co.z = (number * 7 % 5) / 8.0
    shape.to_mesh(mesh)
    return mesh


def cone():
    """A closed cone with a base of seven corners."""
    mesh = bpy.data.meshes.new("cone")
    shape = bmesh.new()
    bmesh.ops.create_cone(shape, cap_ends=True, segments=7, radius1=1.0, radius2=0.0, depth=2.0)
    shape.to_mesh(mesh)
    return mesh


def fin():
    """Three quadrilaterals around one edge."""
    mesh = bpy.data.meshes.new("fin")
    points = [(0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0), (-1, 0.3, 1), (-1, 0.3, 0), (0, 1, 1), (0, 1, 0)]
    mesh.from_pydata(points, [], [(0, 1, 2, 3), (0, 1, 4, 5), (0, 1, 6, 7)])
    return mesh


def write(mesh, path):
    with open(path, "w") as file:
        for vertex in mesh.vertices:
            file.write("v {:.9g} {:.9g} {:.9g}\n".format(*vertex.co))
        layer = mesh.uv_layers.active
        for loop in layer.uv if layer else []:
            file.write("vt {:.9g} {:.9g}\n".format(*loop.vector))
        for face in mesh.polygons:
            corners = zip(face.vertices, face.loop_indices)
            file.write("f " + " ".join(f"{v + 1}/{i + 1}" if layer else str(v + 1) for v, i in corners) + "\n")


def blender(mesh, levels, corners):
    shown = bpy.data.objects.new("shown", mesh)
    bpy.context.collection.objects.link(shown)
    modifier = shown.modifiers.new("subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = levels
    modifier.use_limit_surface = True
    # Patches around irregular vertices are approximated after so many levels.
    modifier.quality = 10
    modifier.boundary_smooth = "PRESERVE_CORNERS" if corners else "ALL"
    own = shown.evaluated_get(bpy.context.evaluated_depsgraph_get())
    fine = own.to_mesh()
    points = np.empty(3 * len(fine.vertices))
    fine.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    corners = []
    if fine.uv_layers.active:
        places = np.array([loop.vertex_index for loop in fine.loops])
        uvs = np.array([loop.vector[:] for loop in fine.uv_layers.active.uv])
        corners = np.unique(np.hstack([points[places], uvs]), axis=0)
    own.to_mesh_clear()
    bpy.data.objects.remove(shown)
    return points, corners


def ours(program, path, levels, arguments):
    out = subprocess.run([program, path, str(levels), "catmull-clark", *arguments], check=True, capture_output=True, text=True)
    rows = {key: [line.split()[1:] for line in out.stdout.splitlines() if line.startswith(key + " ")] for key in ("v", "vt")}
    points, uvs = (np.array(rows[key], dtype=float) for key in ("v", "vt"))
    corners = np.hstack([points, uvs]) if len(uvs) else []
    return np.unique(points, axis=0), corners


def farthest(points, others):
    tree = KDTree(len(others))
    for number, point in enumerate(others):
        tree.insert(point, number)
    tree.balance()
    return max(tree.find(point)[2] for point in points)


def farthest_uv(corners, others):
    """The farthest that texture coordinates are from the nearest ones at the same place."""
    tree = KDTree(len(others))
    for number, corner in enumerate(others):
        tree.insert(corner[:3], number)
    tree.balance()
    far = 0.0
    for corner in corners:
        near = [others[number][3:] for _, number, _ in tree.find_range(corner[:3], 1e-4)]
        far = max(far, min(np.linalg.norm(uv - corner[3:]) for uv in near))
    return far


def main():
    program = sys.argv[1]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # Blender's crease c is the sharpness 10 c^2 in levels; 1 is infinite.
    cases = [
        ("cube", cube(), [], False),
        ("cube, creases of 2.5 levels", cube(0.5), ["30", "2.5"], False),
        ("cube, creases of 0.4 levels", cube(0.2), ["30", "0.4"], False),
        ("suzanne", suzanne(), [], False),
        ("sheet", sheet(), [], False),
        ("sheet with corners", sheet(), ["180", "inf", "corners"], True),
        ("cone", cone(), [], False),
        ("fin", fin(), [], False),
    ]
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh, arguments, corners in cases:
            path = pathlib.Path(folder) / "cage.obj"
            write(mesh, path)
            # Blender's limit has all levels of a crease, ours those that are asked for.
            for levels in range(3 if "creases" in name else 1, 5):
                (theirs, uvs), (own, own_uvs) = blender(mesh, levels, corners), ours(program, path, levels, arguments)
                size = np.ptp(theirs, axis=0).max()
                far = max(farthest(theirs, own), farthest(own, theirs)) / size
                verdict = "" if far <= BOUND else "  FAR"
                failed |= far > BOUND
                print(f"{name}, level {levels}: {len(own)} and {len(theirs)} vertices, {far:.1e}{verdict}")
                if len(uvs):
                    far = max(farthest_uv(uvs, own_uvs), farthest_uv(own_uvs, uvs))
                    verdict = "" if far <= BOUND else "  FAR"
                    failed |= far > BOUND
                    print(f"{name}, level {levels}: texture coordinates, {far:.1e}{verdict}")
    sys.exit(1 if failed else 0)


main()
