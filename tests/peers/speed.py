#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How fast Lucarium's path tracer is beside Mitsuba 3 and Cycles: the same triangles, textures and paths.

Renderers take turns, one image each per round, after a first one that is not counted (compilation, acceleration
structures). Per renderer: samples per second, the relative error of one image from the differences between rounds, the
time in which an image of the wanted error is done, error being inversely proportional to samples, and ours over it. CPU
time is listed beside wall time, since it suffers less from what else runs on the machine. Scenes whose files are not
there are skipped; exit code 77 without any.
"""

import argparse
import json
import resource
import struct
import sys
import time
from pathlib import Path

try:
    import numpy as np

    import cycles_peer
    import gltf
    import lucarium
    import mitsuba_peer
    import scenes
except ImportError as error:
    print(f"skipped: the Python package {error.name} is not installed (pip install -r tests/peers/requirements.txt)")
    sys.exit(77)

BOUNCES = 5
# Source and options; surfaces are Lambert, which all renderers have as their own.
SCENES = {
    "sponza": ("scenes/sponza_crytek/sponza.gltf",
               ("--light", "directional:0.20,-0.96,0.18:20", "--environment", "0.5", "--texture-size", "512",
                "--camera=-10,2,-0.4:8,4.5,0:57")),
    "bathroom": ("scenes/bathroom_salle_de_bain.glb", ()),
    # Cycles' area lights reflect nothing.
    "classroom": ("scenes/classroom_luxcore.glb", ("--material", "portal:base_color=0")),
    "atrium": ("builtin:atrium", ()),
}


def without_normal_maps(file):
    """Rewrites a .glb: peers get no normal maps, so nobody does."""
    document, binary = gltf.split_container(file.read_bytes())
    for material in document["materials"]:
        material.pop("normalTexture", None)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + bytes(binary)
    file.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


class Ours:
    """CPU time of the iterations is that of a whole run less that of a run of one sample."""

    def __init__(self, file, folder, size, samples):
        self.file, self.folder, self.size, self.samples = file, folder, size, samples
        self.one_run(1, 0)

    def one_run(self, samples, seed):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        output = self.folder / "ours.exr"
        answer = json.loads(lucarium.run(
            "render", self.file, "-t", "path_tracing", "--size", f"{self.size[0]}x{self.size[1]}",
            "--max-bounces", BOUNCES, "--spp", samples,
            "--seed", seed, "-p", f"samples_per_iteration={samples}", "-o", output, "--overwrite", "--quiet", "--json"))
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return lucarium.read_exr(output), answer["frames"][0]["clocks"]["iterate_seconds"], cpu

    def render(self, seed):
        cpu_of_one = self.one_run(1, seed)[2]
        image, wall, cpu = self.one_run(self.samples, seed)
        return image, wall, (cpu - cpu_of_one) * self.samples / (self.samples - 1)


class Mitsuba:
    def __init__(self, variant, scene, folder, size, samples):
        self.variant, self.samples = variant, samples
        folder.mkdir(exist_ok=True)
        self.mi = mitsuba_peer.require(variant)
        self.scene = mitsuba_peer.Exporter(self.mi, scene, folder, own_bsdf=False).load(size, BOUNCES)
        self.render(0)

    def render(self, seed):
        self.mi.set_variant(self.variant)
        start, start_cpu = time.time(), time.process_time()
        image = np.array(self.mi.render(self.scene, spp=self.samples, seed=seed), np.float64)
        return image, time.time() - start, time.process_time() - start_cpu


class Cycles:
    """Blender starts again each round; its first image builds the acceleration structure and is not counted."""

    def __init__(self, file, folder, size, samples):
        self.file, self.folder, self.size, self.samples = file, folder, size, samples
        folder.mkdir(exist_ok=True)
        cycles_peer.run(file, size, 0, 1, [1], folder)

    def render(self, seed):
        wall, cpu = cycles_peer.run(self.file, self.size, BOUNCES, self.samples, [10000 + seed, seed], self.folder)
        return lucarium.read_exr(self.folder / f"cycles{seed}.exr"), wall[1], cpu[1]


def summary(renderer, images, walls, cpus, size, target):
    """Medians, and the relMSE of one image from the spread of the rounds."""
    stack = np.stack(images)
    mean, variance = stack.mean(0), stack.var(0, ddof=1)
    luminance = mean.mean()
    error = float((variance / (mean**2 + 0.01 * luminance**2)).mean())
    wall, cpu = float(np.median(walls)), float(np.median(cpus))
    million = size[0] * size[1] * renderer.samples / 1e6
    return {"samples_per_pixel": renderer.samples, "wall_seconds": wall, "cpu_seconds": cpu, "rounds": len(images),
            "msamples_per_wall_second": million / wall, "msamples_per_cpu_second": million / cpu, "relmse": error,
            "wall_seconds_to_target": wall * error / target, "cpu_seconds_to_target": cpu * error / target,
            "mean": float(luminance)}


def renderers(arguments, file, folder, scene, size):
    """Those that are installed, by name; warns about the others."""
    samples = arguments.samples
    makers = {
        "lucarium": lambda: Ours(file, folder, size, samples),
        "mitsuba llvm_ad_rgb": lambda: Mitsuba("llvm_ad_rgb", scene, folder / "llvm", size, samples),
        "mitsuba scalar_rgb": lambda: Mitsuba("scalar_rgb", scene, folder / "scalar", size, samples),
        "cycles": lambda: Cycles(file, folder / "cycles", size, samples),
    }
    result = {}
    for name, make in makers.items():
        if arguments.only and name not in arguments.only:
            continue
        try:
            result[name] = make()
        except lucarium.Missing as missing:
            print(f"skipped: {name}: {missing}")
    return result


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", default="results/peers_speed")
    parser.add_argument("--scene", action="append", choices=SCENES, help="may be repeated; default: all")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--samples", type=int, default=16, help="per pixel and image")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--target", type=float, default=0.01, help="relMSE whose time is measured")
    parser.add_argument("--only", action="append", help="name of a renderer; may be repeated")
    return parser.parse_args()


def export(name, folder):
    """The scene's file, as all renderers read it; throws lucarium.Missing."""
    source, options = SCENES[name]
    if not source.startswith("builtin:"):
        source = scenes.shared_file(source)
    file = folder / f"{name}.glb"
    lucarium.export(source, ("--material", f"*:{scenes.LAMBERT}", *options), file)
    without_normal_maps(file)
    return file


def measure(arguments, file, folder, size):
    """Summaries by name of the renderer."""
    folder.mkdir(exist_ok=True)
    sides = renderers(arguments, file, folder, gltf.read(file), size)
    images, walls, cpus = ({name: [] for name in sides} for _ in range(3))
    for round_number in range(1, arguments.rounds + 1):
        for name, renderer in sides.items():
            image, wall, cpu = renderer.render(round_number)
            images[name].append(image), walls[name].append(wall), cpus[name].append(cpu)
    return {name: summary(side, images[name], walls[name], cpus[name], size, arguments.target)
            for name, side in sides.items()}


def show(scene, results, target):
    ours = results.get("lucarium")
    print(f"{scene:20} Msamples/s wall, CPU   relMSE   seconds to relMSE {target} wall, CPU   ours over it     mean")
    for name, r in results.items():
        over = ours["wall_seconds_to_target"] / r["wall_seconds_to_target"] if ours else float("nan")
        over_cpu = ours["cpu_seconds_to_target"] / r["cpu_seconds_to_target"] if ours else float("nan")
        print(f"{name:20} {r['msamples_per_wall_second']:8.3f} {r['msamples_per_cpu_second']:8.3f}   "
              f"{r['relmse']:8.4f}   {r['wall_seconds_to_target']:10.2f} {r['cpu_seconds_to_target']:10.2f}   "
              f"{over:12.2f} {over_cpu:6.2f}   {r['mean']:12.5f}", flush=True)


def main():
    arguments = parse()
    size = tuple(int(x) for x in arguments.size.split("x"))
    folder = Path(arguments.out)
    folder.mkdir(parents=True, exist_ok=True)
    results = {}
    for scene in arguments.scene or SCENES:
        try:
            file = export(scene, folder)
        except lucarium.Missing as missing:
            print(f"skipped: {scene}: {missing}")
            continue
        results[scene] = measure(arguments, file, folder / scene, size)
        show(scene, results[scene], arguments.target)
        (folder / "speed.json").write_text(json.dumps(results, indent=1) + "\n")
    return 0 if results else 77


if __name__ == "__main__":
    sys.exit(main())
