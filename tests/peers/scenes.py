# SPDX-License-Identifier: Apache-2.0
"""The scenes that are compared: arguments of the program, and how both sides render them."""

from dataclasses import dataclass
from pathlib import Path

import gltf
import lucarium
import made_scenes

LAMBERT = "ior=1,metallic=0,roughness=1,transmission=0"


VIEW = ("--camera", "0.5,1.6,4.2:0,0.9,-0.4:38")  # of the made scenes


@dataclass
class Case:
    """`source`: builtin:NAME, a file under the shared scenes, or made:NAME of made_scenes.py; `separable`: with GGX
    masking as other renderers have it, and their own BSDFs; `flat`: geometric normals on both sides."""

    source: str
    options: tuple = ()
    bounces: int = 4  # -1: unlimited
    samples: int = 16  # per pixel and replicate
    size: tuple = (128, 96)
    environment: str | None = None  # a picture of the shared scenes, at 64 x 32 texels, turned by 40 degrees
    separable: bool = False
    flat: bool = False
    move_emitters: tuple | None = None  # by a vector [m]
    peers: tuple = ("mitsuba", "cycles")


BUNNY = dict(source="models/bunny_stanford.glb", environment="env/venice_sunset_1k.hdr", bounces=3)
BUNNY_MATERIAL = ("--material", f"*:base_color=0.7,{LAMBERT}")

# Edges of lamps in view show the bias of Cycles' sample points best (cycles_peer.py): its views look away from them.
CASES = {
    "cornell": Case("builtin:cornell", samples=48, peers=("mitsuba",)),
    "cornell-direct": Case("builtin:cornell", bounces=0, samples=32, peers=("mitsuba",)),
    "cornell-inside": Case("builtin:cornell", ("--camera", "0,0.22,0.3:0,0.18,-0.3:36"), samples=48),
    "room": Case("builtin:room", bounces=3, samples=32),
    "classroom": Case("scenes/classroom_luxcore.glb", 
                      ("--material", f"*:{LAMBERT}", "--material", "portal:base_color=0"),
                      samples=64, flat=True,
                      # away from window frames at 0.4 mm: Mitsuba's shadow rays end 5 mm early
                      move_emitters=(0, 0, -0.03)),
    "textured-light": Case("made:textured_light", VIEW, bounces=2, samples=32, peers=("mitsuba",)),
    "textured-light-down": Case("made:textured_light", ("--camera", "0.2,1.5,1.5:-0.2,0,0.2:40"), bounces=2,
                                samples=32),
    "bunny-smooth": Case(**BUNNY, options=(*BUNNY_MATERIAL, "--camera", "0.05,0.16,0.42:-0.017,0.105,0:26"),
                         peers=("mitsuba",)),
    "bunny": Case(**BUNNY, options=(*BUNNY_MATERIAL, "--camera", "0.05,0.16,0.42:-0.02,0.085,0:9"), flat=True),
    "spot": Case("made:corner", (*VIEW, "--light", "spot:1,2.6,1.5:-0.3,-1,-0.6:30,20,10:32:18"), bounces=2),
    "sun": Case("made:corner", (*VIEW, "--light", "directional:-0.4,-1,-0.7:10,9,8"), bounces=2),
    "metals": Case("made:rough_metals", VIEW, samples=32, peers=("mitsuba",)),
    "plastics": Case("made:rough_dielectrics", VIEW, samples=32, peers=("mitsuba",)),
    "metals-separable": Case("made:white_metals", VIEW, samples=32, separable=True),
    "glass": Case("made:glass", VIEW, bounces=-1, samples=64, peers=("mitsuba",)),
    "glass-sky": Case("made:glass_corner", VIEW, bounces=-1, samples=32, environment="env/venice_sunset_1k.hdr"),
}


def small_environment(source, file):
    """That picture averaged to 64 x 32 texels, as an EXR file."""
    scene = file.with_suffix(".glb")
    lucarium.export("builtin:furnace", ("--environment", source), scene)
    rgb = lucarium.read_exr(f"{scene}.environment.exr")
    h, w = rgb.shape[0] // 32, rgb.shape[1] // 64
    lucarium.write_exr(file, rgb.reshape(32, h, 64, w, 3).mean(axis=(1, 3)))


def shared_file(name):
    """A file of the shared scenes; throws lucarium.Missing."""
    file = lucarium.SHARED / "scenes" / name
    if not file.exists():
        raise lucarium.Missing(f"there is no {file}")
    return str(file)


def export(case, file):
    """Writes the case's scene to FILE.glb and its sidecar; throws lucarium.Missing."""
    options = list(case.options)
    if case.environment:
        picture = Path(file).with_name("small_environment.exr")
        small_environment(shared_file(case.environment), picture)
        options += ["--environment", f"{picture}@40"]
    if case.source.startswith("made:"):
        source = made_scenes.make(case.source[5:], Path(file).parent)
    else:
        source = case.source if case.source.startswith("builtin:") else shared_file(case.source)
    lucarium.export(source, options, file)
    if case.move_emitters:
        gltf.move_emitters(file, case.move_emitters)
