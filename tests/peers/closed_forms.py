#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lucarium and Cycles against exact values, for scenes in which they differ: which of the two is right?

Prints, for both, the deviation from a closed form: a rough metal in a furnace, a rectangular lamp on a wall, faceted
glass in a furnace. Exit code: 0, or 77 when a program is missing.
"""

import sys
import tempfile
from pathlib import Path

try:
    import numpy as np

    import cycles_peer
    import lucarium
    import made_scenes
except ImportError as error:
    print(f"skipped: the Python package {error.name} is not installed (pip install -r tests/peers/requirements.txt)")
    sys.exit(77)

SEEDS = range(1, 9)


def render_both(writer, options, size, bounces, samples, folder, kernel_path=None, area_lights=True):
    """Images (h, w) of the first channel: ours, theirs; `samples` per pixel altogether."""
    scene = folder / "scene.glb"
    lucarium.export(writer.write(folder / "made.gltf"), options, scene)
    ours, _ = lucarium.render(scene, size, bounces, samples // 16, 16, folder / "ours.exr", kernel_path)
    cycles_peer.run(scene, size, bounces, samples // len(SEEDS), SEEDS, folder, area_lights=area_lights)
    theirs = np.mean([lucarium.read_exr(folder / f"cycles{seed}.exr")[..., 0] for seed in SEEDS], axis=0)
    return ours.pixels.mean[..., 0], theirs


def ggx_albedo(roughness, cosine):
    """Directional albedo of GGX with separable masking and F = 1: the mean over half vectors that D cos distributes."""
    alpha = roughness * roughness
    u, phi = np.meshgrid((np.arange(4000) + 0.5) / 4000, (np.arange(2000) + 0.5) / 2000 * np.pi, indexing="ij")
    cos_h = 1 / np.sqrt(1 + alpha * alpha * u / (1 - u))
    out_h = np.sqrt(1 - cosine * cosine) * np.sqrt(1 - cos_h * cos_h) * np.cos(phi) + cosine * cos_h
    cos_in = 2 * out_h * cos_h - cosine
    lit = (out_h > 0) & (cos_in > 0)

    def masking(c):
        return 2 / (1 + np.sqrt(1 + alpha * alpha * (1 - c * c) / (c * c)))

    weight = masking(cosine) * masking(np.where(lit, cos_in, 1)) * out_h / (cosine * cos_h)
    return np.where(lit, weight, 0).mean()


def metal_in_furnace(folder):
    kernels = lucarium.separable_kernels(folder / "kernels")
    for roughness in (0.2, 0.4, 0.7):
        for degrees in (10, 50, 75):
            writer = made_scenes.Writer()
            writer.add("plane", made_scenes.quad((-5, 0, 5), (10, 0, 0), (0, 0, -10)),
                       writer.material("metal", (1, 1, 1), 1.0, roughness))
            angle = np.radians(degrees)
            view = ["--camera", f"0,{2 * np.cos(angle)},{2 * np.sin(angle)}:0,0,0:0.5", "--environment", "1,1,1"]
            ours, theirs = render_both(writer, view, (16, 8), 2, 16384, folder, kernels)
            exact = ggx_albedo(roughness, np.cos(angle))
            print(f"metal, roughness {roughness}, {degrees} degrees: exact {exact:.5f}, "
                  f"ours {ours.mean() / exact - 1:+.5f}, Cycles {theirs.mean() / exact - 1:+.5f}", flush=True)


LAMP = np.array([(-0.6, 2.9, -0.6), (0.6, 2.9, -0.6), (0.6, 2.9, 0.6), (-0.6, 2.9, 0.6)])


def lambert_irradiance(point, normal):
    """Irradiance of the lamp of radiance 1 at a point that sees all of it (Lambert's polygon formula)."""
    corners = LAMP - point
    corners /= np.linalg.norm(corners, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        edge = np.cross(a, b)
        total += np.arccos(np.clip(a @ b, -1, 1)) * (normal @ edge) / np.linalg.norm(edge)
    return abs(total) / 2


def lamp_on_wall(folder):
    writer = made_scenes.Writer()
    writer.add("wall", made_scenes.quad((-2, 0, -2), (4, 0, 0), (0, 3, 0)), writer.material("wall", (0.5, 0.5, 0.5)))
    made_scenes.lamp(writer, LAMP[0], LAMP[1] - LAMP[0], LAMP[3] - LAMP[0], 12.0)
    size, block = (96, 64), 8
    height, middle = 1.2, np.array([0.8, 2.1])  # of what is seen of the wall
    view = ["--camera", f"{middle[0]},{middle[1]},2:{middle[0]},{middle[1]},-2:{np.degrees(2 * np.arctan(height / 8))}"]
    exact = np.zeros((2 * size[1], 2 * size[0]))
    for j, i in np.ndindex(exact.shape):
        x = middle[0] + height * ((i + 0.5) / 2 - size[0] / 2) / size[1]
        y = middle[1] - height * ((j + 0.5) / 2 - size[1] / 2) / size[1]
        exact[j, i] = 0.5 / np.pi * 12 * lambert_irradiance(np.array([x, y, -2]), np.array([0, 0, 1]))
    blocks = lambda a, n: a.reshape(size[1] // block, n, size[0] // block, n).mean(axis=(1, 3))
    exact = blocks(exact, 2 * block)
    for area_lights in (False, True):
        ours, theirs = (blocks(a, block) / exact - 1
                        for a in render_both(writer, view, size, 0, 1024, folder, area_lights=area_lights))
        lamp = "area light" if area_lights else "mesh"
        print(f"wall under a lamp, 8 x 8 blocks: ours {ours.min():+.5f} to {ours.max():+.5f}, "
              f"Cycles ({lamp}) {theirs.min():+.5f} to {theirs.max():+.5f}", flush=True)


def glass_in_furnace(folder):
    writer = made_scenes.add_glass_sphere(made_scenes.Writer())
    view = ["--camera", "0.5,1.6,4.2:0.2,0.6,0.3:22", "--environment", "1,1,1"]
    ours, theirs = (a - 1 for a in render_both(writer, view, (64, 64), -1, 1024, folder))
    print(f"glass: mean ours {ours.mean():+.6f}, Cycles {theirs.mean():+.6f}; darkest pixel ours {ours.min():+.4f}, "
          f"Cycles {theirs.min():+.4f}", flush=True)


def main():
    with tempfile.TemporaryDirectory() as folder:
        try:
            metal_in_furnace(Path(folder))
            lamp_on_wall(Path(folder))
            glass_in_furnace(Path(folder))
        except lucarium.Missing as missing:
            print(f"skipped: {missing}")
            return 77
    return 0


if __name__ == "__main__":
    sys.exit(main())
