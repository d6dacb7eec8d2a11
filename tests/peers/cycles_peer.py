# SPDX-License-Identifier: Apache-2.0
"""Renders an exported scene with Blender's Cycles (Debian 12: blender 3.4.1 and python3-numpy).

Cycles' sample points are not unbiased at few samples per pixel: over seeds, a pixel that an edge covers by .248 has
mean .2445 +- .0005 at 64 samples and .2477 +- .0001 at 768. So few seeds are taken, with many samples each.
"""

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np

import image_test
from lucarium import Missing, read_exr

SCRIPT = Path(__file__).with_name("cycles_render.py")


def run(scene_file, size, bounces, samples, seeds, folder, linear_textures=False, area_lights=True):
    """Renders one image per seed into the folder; returns lists: wall and CPU seconds of each."""
    if shutil.which("blender") is None:
        raise Missing("Blender is not installed (apt-get install --no-install-recommends blender python3-numpy)")
    job = {"scene": str(scene_file), "size": list(size), "bounces": bounces, "samples": samples, "seeds": list(seeds),
           "output": str(folder), "threads": os.cpu_count(), "linear_textures": linear_textures,
           "area_lights": area_lights}
    file, report = Path(folder) / "job.json", Path(folder) / "cycles.json"
    file.write_text(json.dumps(job))
    report.unlink(missing_ok=True)
    command = [
    "blender",
    "-b",
    "--factory-startup",
    "-noaudio",
    "--python-exit-code",
    "1",
    "-P",
    str(SCRIPT),
    "--",
     str(file)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0 or not report.exists():
        raise RuntimeError(f"blender failed:\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}")
    times = json.loads(report.read_text())
    return times["seconds"], times["cpu_seconds"]


def render(scene_file, case, replicates, folder):
    """The image test's Render of a case: a quarter of the replicates, each with eight times the samples."""
    seeds = range(1, max(2, replicates // 4) + 1)
    run(scene_file, case.size, case.bounces, 8 * case.samples, seeds, folder, linear_textures=True)
    return image_test.Render.of_replicates(np.stack([read_exr(Path(folder) / f"cycles{s}.exr") for s in seeds]))
