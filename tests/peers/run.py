#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders scenes with Lucarium and with another renderer and checks whether the images are the same up to noise.

Prints a table, writes OUT/results.json. Exit code: 0 all passed, 1 a difference, 77 nothing could be compared.
"""

import argparse
import json
import sys
import time
from pathlib import Path

try:
    import numpy as np

    import gltf
    import image_test
    import lucarium
    import scenes
    from scenes import CASES
except ImportError as error:
    print(f"skipped: the Python package {error.name} is not installed (pip install -r tests/peers/requirements.txt)")
    sys.exit(77)


def render_peer(peer, case, scene, folder, replicates, variant):
    if peer == "mitsuba":
        import mitsuba_peer

        return mitsuba_peer.render(scene, case.size, case.bounces, case.samples, replicates, folder, variant,
                                   own_bsdf=not case.separable)
    import cycles_peer

    return cycles_peer.render(folder / "scene.glb", case, replicates, folder)


def compare(peer, name, case, arguments):
    """Result of one scene as a dictionary; throws lucarium.Missing."""
    folder = Path(arguments.out) / peer / name
    folder.mkdir(parents=True, exist_ok=True)
    scene_file = folder / "scene.glb"
    scenes.export(case, scene_file)
    scene = gltf.read(scene_file)
    if case.flat:
        scene.flatten()
    kernels = lucarium.separable_kernels(folder / "kernels") if case.separable else None
    start = time.time()
    theirs = render_peer(peer, case, scene, folder, arguments.replicates, arguments.variant)
    between = time.time()
    ours, _ = lucarium.render(scene_file, case.size, case.bounces, case.samples, arguments.replicates,
                              folder / "ours.exr", kernels, ["geometric_normals=on"] if case.flat else [])
    result = image_test.compare(ours, theirs)
    result["seconds"] = {"ours": time.time() - between, "theirs": between - start}
    result["samples_per_pixel"] = case.samples * arguments.replicates
    result["size"], result["bounces"] = case.size, case.bounces
    np.savez_compressed(folder / "images.npz", ours=ours.pixels.mean, theirs=theirs.pixels.mean,
                        ours_variance=ours.pixels.variance, theirs_variance=theirs.pixels.variance)
    return result


def line(peer, name, r):
    worst = int(np.argmax(np.abs(r["image_t"])))
    return (f"{peer:8} {name:18} {'pass' if r['passed'] else 'FAIL'}  "
            f"{r['mean_ratio'][worst]:.5f} +- {r['mean_ratio_error'][worst]:.5f} {r['image_t'][worst]:7.2f}  "
            f"{r['pixels']['worst_t']:6.2f} ({r['pixels'].get('limit_t', 0):.2f})  "
            f"{r['blocks']['worst_t']:6.2f} ({r['blocks'].get('limit_t', 0):.2f})  {r['pixels'].get('ks_p', 1):8.2g}  "
            f"{r['samples_per_pixel']:6}")


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--peer", choices=["mitsuba", "cycles"], help="both if left out")
    parser.add_argument("--scene", action="append", choices=sorted(CASES), help="all if left out")
    parser.add_argument("--out", default="results/peers", help="folder of images and results.json")
    parser.add_argument("--replicates", type=int, default=32)
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba")
    return parser.parse_args()


def main():
    arguments = parse()
    results, skipped = {}, set()
    header = False
    for peer in [arguments.peer] if arguments.peer else ["mitsuba", "cycles"]:
        for name in arguments.scene or CASES:
            if peer not in CASES[name].peers:
                continue
            try:
                result = compare(peer, name, CASES[name], arguments)
            except lucarium.Missing as missing:
                if str(missing) not in skipped:
                    print(f"skipped: {peer}, {name}: {missing}", flush=True)
                skipped.add(str(missing))
                continue
            if not header:
                print(f"{'peer':8} {'scene':18} test  mean ratio             t      worst pixel t   "
                      "worst block t    KS p         spp")
                header = True
            results[f"{peer}/{name}"] = result
            print(line(peer, name, result), flush=True)
            Path(arguments.out).mkdir(parents=True, exist_ok=True)
            (Path(arguments.out) / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    if not results:
        return 77
    return 0 if all(r["passed"] for r in results.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
