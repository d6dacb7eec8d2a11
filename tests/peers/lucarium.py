# SPDX-License-Identifier: Apache-2.0
"""Runs the program: exports scenes, renders with replicates."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np

import image_test

ROOT = Path(__file__).resolve().parents[2]
SHARED = Path(os.environ.get("LUCARIUM_TEST_SHARED", ROOT.parent / "shared"))
PROGRAM = os.environ.get("LUCARIUM_TEST_PROGRAM", str(ROOT / "build/release/bin/lucarium"))


class Missing(Exception):
    """Something that a comparison needs is not here; it is skipped, not failed."""


def run(*arguments, kernel_path=None):
    """Standard output of one run of the program."""
    if not Path(PROGRAM).exists():
        raise Missing(f"{PROGRAM} is not built")
    environment = dict(os.environ)
    if kernel_path:
        environment["LUCARIUM_KERNEL_PATH"] = str(kernel_path)
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        raise RuntimeError(f"lucarium {' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return done.stdout


def export(source, options, file):
    """Writes the scene that those options describe to FILE.glb and its sidecar."""
    run("scene", source, *options, "--export", file, "--overwrite", "--quiet")


def separable_kernels(folder):
    """A kernel path on which GGX masking is separable, as in other renderers."""
    target = Path(folder) / "lucarium"
    target.mkdir(parents=True, exist_ok=True)
    source = (ROOT / "kernels/lucarium/ggx.clh").read_text()
    (target / "ggx.clh").write_text("#define LUCARIUM_GGX_SEPARABLE\n" + source)
    return Path(folder)


def read_exr(file, layer=None):
    """R, G, B of an EXR file as (h, w, 3), of a named layer if given."""
    import OpenEXR

    prefix = f"{layer}." if layer else ""
    with OpenEXR.File(str(file), separate_channels=True) as exr:
        return np.stack([exr.channels()[prefix + c].pixels.astype(np.float64) for c in "RGB"], axis=-1)


def write_exr(file, rgb):
    """An array (h, w, 3) as an EXR file of 32-bit floats."""
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": np.ascontiguousarray(rgb, np.float32)}) as exr:
        exr.write(str(file))


def render(file, size, bounces, samples, replicates, output, kernel_path=None, parameters=()):
    """The image test's Render of a scene file, and the program's own summary; `samples` per replicate and pixel."""
    words = ["-p", f"replicates={replicates}"] + [w for p in parameters for w in ("-p", p)]
    answer = json.loads(
        run("render", file, "-t", "path_tracing", *words, "--size", f"{size[0]}x{size[1]}", "--max-bounces", bounces,
            "--spp", samples * replicates, "-o", output, "--overwrite", "--quiet", "--json", kernel_path=kernel_path)
    )
    return image_test.Render.of_pixels(read_exr(output), read_exr(output, "Variance"), replicates), answer["frames"][0]
