# SPDX-License-Identifier: Apache-2.0
"""The scenes that are compared: what the program is told, and how both sides render it."""

from dataclasses import dataclass

from lucarium import SHARED

LAMBERT = "ior=1,metallic=0,roughness=1,transmission=0"


@dataclass
class Case:
    """`separable`: with GGX masking as other renderers have it, and their own BSDFs; `peers`: who can render it."""

    source: str
    options: tuple = ()
    bounces: int = 4
    samples: int = 16  # per pixel and replicate
    size: tuple = (128, 96)
    separable: bool = False
    peers: tuple = ("mitsuba", "cycles")
    make: str | None = None  # function of made_scenes.py that writes the source


CASES = {
    "cornell": Case("builtin:cornell"),
    "cornell-direct": Case("builtin:cornell", bounces=0),
    "room": Case("builtin:room", bounces=3),
}
