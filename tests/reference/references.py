#!/usr/bin/env python3
"""Makes the reference pictures of this folder with Mitsuba 3, and writes the means of their 8x8 blocks.

    pip install mitsuba==3.9.1 numpy
    python3 references.py [cornell] [metal] [dragon] [--dragon dragon_871k.obj]

Each scene is the TOML file of the same name, said once more in Mitsuba's words. `NAME.csv` has a row for each block, rows of the
picture from the top: the means of red, green and blue, then their standard errors, by eight renderings with seeds of their own.
"""

import argparse
import math
import os

import mitsuba as mi
import numpy as np

BLOCK = 8
RUNS = 8

try:
    mi.set_variant("llvm_ad_rgb")
except ImportError:
    mi.set_variant("scalar_rgb")

T = mi.ScalarTransform4f
HERE = os.path.dirname(os.path.abspath(__file__))


def rgb(*v):
    return {"type": "rgb", "value": list(v)}


def matte(*v):
    return {"type": "diffuse", "reflectance": rgb(*v)}


def camera(eye, target, fov, size, axis="y"):
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    return {
        "type": "perspective",
        "fov": fov,
        "fov_axis": axis,
        "to_world": T().look_at(origin=eye, target=target, up=[0, 1, 0]),
        "film": film,
        "sampler": {"type": "independent", "sample_count": 4},
    }


def quad(corners, bsdf, **more):
    """A parallelogram by its corners, wound about its normal."""
    a, b, _, d = (np.array(c, dtype=float) for c in corners)
    u, v = (b - a) / 2, (d - a) / 2
    n = np.cross(u, v)
    n /= np.linalg.norm(n)
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = u, v, n, a + u + v
    return {"type": "rectangle", "to_world": T(m.tolist()), "bsdf": bsdf, **more}


def sphere(center, radius, bsdf):
    return {"type": "sphere", "center": center, "radius": radius, "bsdf": bsdf}


METAL = {"eta": rgb(0.2, 0.92, 1.1), "k": rgb(3.9, 2.45, 2.2)}


def cornell():
    white = {"type": "twosided", "bsdf": matte(0.73, 0.71, 0.68)}
    red = {"type": "twosided", "bsdf": matte(0.6, 0.06, 0.05)}
    green = {"type": "twosided", "bsdf": matte(0.12, 0.45, 0.15)}
    light = [[-0.25, 1.98, -0.25], [0.25, 1.98, -0.25], [0.25, 1.98, 0.25], [-0.25, 1.98, 0.25]]
    return 12, {
        "camera": camera([0, 1, 3.9], [0, 1, 0], 37, (128, 128)),
        "floor": quad([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], white),
        "ceiling": quad([[-1, 2, -1], [1, 2, -1], [1, 2, 1], [-1, 2, 1]], white),
        "back": quad([[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]], white),
        "left": quad([[-1, 0, 1], [-1, 0, -1], [-1, 2, -1], [-1, 2, 1]], red),
        "right": quad([[1, 0, -1], [1, 0, 1], [1, 2, 1], [1, 2, -1]], green),
        "light": quad(light, matte(0, 0, 0), emitter={"type": "area", "radiance": rgb(17, 12, 5)}),
        "glass": sphere([0.45, 0.35, 0.3], 0.35, {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}),
        "metal": sphere([-0.42, 0.4, -0.3], 0.4, {"type": "conductor", **METAL}),
    }


def sky(width=128, height=64):
    """A blue gradient, a brown ground and a wide, soft sun."""
    v, u = (np.indices((height, width)) + 0.5) / [[[height]], [[width]]]
    elevation, azimuth = (0.5 - v) * math.pi, (u - 0.5) * 2 * math.pi
    # The centre column looks along -z, right is +x.
    d = np.stack([np.cos(elevation) * np.sin(azimuth), np.sin(elevation), -np.cos(elevation) * np.cos(azimuth)], -1)
    up = d[..., 1:2]
    blend = 1 / (1 + np.exp(-6 * up))
    light = (1 - blend) * [0.35, 0.28, 0.2] + blend * [0.35, 0.55, 0.95]
    sun = np.array([0.55, 0.6, 0.58])
    sun /= np.linalg.norm(sun)
    return light + np.exp(12 * (d @ sun - 1))[..., None] * [9.0, 8.0, 6.5]


def metal():
    path = os.path.join(HERE, "sky.exr")
    if not os.path.exists(path):
        mi.Bitmap(sky().astype(np.float16)).write(path)
    # Mitsuba has the texels of an environment on the edges of its pixels, not in their middles: 1.4 degrees off at the size of
    # the file. So it gets the same light in eight times the resolution.
    fine = mi.Bitmap(sky(1024, 512).astype(np.float32))
    return 8, {
        "camera": camera([0, 1.4, 4], [0, 0.6, 0], 35, (128, 96)),
        # Mitsuba's centre column looks along +z.
        "sky": {"type": "envmap", "bitmap": fine, "to_world": T().rotate([0, 1, 0], 180)},
        "floor": quad([[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]], {"type": "twosided", "bsdf": matte(0.4, 0.4, 0.42)}),
        # Roughness 0.2 is alpha 0.04.
        "rough": sphere([-0.7, 0.6, 0], 0.6, {"type": "roughconductor", "alpha": 0.04, "distribution": "ggx", **METAL}),
        "mirror": sphere([0.75, 0.5, 0.2], 0.5, {"type": "conductor", "material": "none", "specular_reflectance": rgb(0.9, 0.9, 0.9)}),
    }


def vertices(path):
    with open(path) as lines:
        return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)


def dragon(path, size=(160, 96)):
    p = vertices(path)
    low, high = p.min(0), p.max(0)
    scale = 2 / (high - low).max()
    middle = (low + high) / 2
    place = T().translate([-scale * middle[0], -scale * low[1], -scale * middle[2]]) @ T().scale([scale] * 3)
    a = math.radians(38)
    floor = [[-10, 0, 10], [10, 0, 10], [10, 0, -10], [-10, 0, -10]]
    return 8, {
        "camera": camera([3.56 * math.sin(a), 1.6, 3.56 * math.cos(a)], [0, 0.6, 0], 40, size, "x"),
        "sky": {"type": "constant", "radiance": rgb(1, 1, 1)},
        "dragon": {
            "type": "obj",
            "filename": path,
            "to_world": place,
            "face_normals": True,
            "bsdf": {"type": "twosided", "bsdf": matte(0.7, 0.7, 0.7)},
        },
        "floor": quad(floor, {"type": "twosided", "bsdf": matte(0.5, 0.5, 0.5)}),
    }


def blocks(picture):
    h, w, _ = picture.shape
    picture = picture[: h // BLOCK * BLOCK]
    return picture.reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK, 3).mean((1, 3))


def write(name, depth, scene, samples):
    scene = mi.load_dict({"type": "scene", "integrator": {"type": "path", "max_depth": depth}, **scene})
    runs = [blocks(np.array(mi.render(scene, spp=samples, seed=seed))) for seed in range(RUNS)]
    mean, error = np.mean(runs, 0), np.std(runs, 0, ddof=1) / math.sqrt(RUNS)
    rows = np.concatenate([mean, error], -1).reshape(-1, 6)
    header = f"Mitsuba {mi.__version__}, {RUNS} x {samples} samples, blocks of {BLOCK}x{BLOCK}, {mean.shape[1]} in a row"
    np.savetxt(os.path.join(HERE, f"{name}.csv"), rows, fmt="%.6g", delimiter=",", header=header)
    print(name, "mean", mean.mean(), "typical error", np.median(error / np.maximum(mean, 1e-3)))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="*", default=["cornell", "metal"])
    parser.add_argument("--dragon")
    parser.add_argument("--samples", type=int, default=1024)
    args = parser.parse_args()
    for name in args.scenes:
        depth, scene = {"cornell": cornell, "metal": metal, "dragon": lambda: dragon(args.dragon)}[name]()
        write(name, depth, scene, args.samples)


if __name__ == "__main__":
    main()
