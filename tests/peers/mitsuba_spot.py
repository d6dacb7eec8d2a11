# SPDX-License-Identifier: Apache-2.0
"""The spot light of KHR_lights_punctual, whose ramp is the square of a linear function of the cosine, as a Mitsuba
plug-in. Import after mi.set_variant().
"""

import drjit as dr
import mitsuba as mi
import numpy as np


class GltfSpot(mi.Emitter):
    """Properties: position and direction (3-vectors, unit direction), intensity (rgb, [cd]), inner, outer [rad]."""

    def __init__(self, props):
        mi.Emitter.__init__(self, props)
        self.m_flags = +mi.EmitterFlags.DeltaPosition
        self.position, self.direction = mi.Point3f(props["position"]), mi.Vector3f(props["direction"])
        self.intensity = mi.Color3f(props["intensity"])
        outer = np.cos(props["outer"])
        self.scale = 1 / max(np.cos(props["inner"]) - outer, 0.001)
        self.offset = -outer * self.scale

    def sample_direction(self, it, sample, active=True):
        ds = dr.zeros(mi.DirectionSample3f)
        ds.p, ds.n, ds.uv, ds.time = self.position, mi.Normal3f(0), mi.Point2f(0), it.time
        ds.pdf, ds.delta, ds.emitter = mi.Float(1), mi.Bool(True), mi.EmitterPtr(self)
        ds.d = ds.p - it.p
        squared = dr.squared_norm(ds.d)
        ds.dist = dr.sqrt(squared)
        ds.d /= ds.dist
        ramp = dr.clip(dr.dot(-ds.d, self.direction) * self.scale + self.offset, 0, 1)
        value = self.intensity * (ramp * ramp / squared)
        return ds, dr.select(mi.Bool(active), value, 0)

    def pdf_direction(self, it, ds, active=True):
        return mi.Float(0)

    def eval_direction(self, it, ds, active=True):
        return mi.Color3f(0)

    def eval(self, si, active=True):
        return mi.Color3f(0)

    def bbox(self):
        return mi.BoundingBox3f(self.position)

    def to_string(self):
        return "GltfSpot[]"


def register():
    mi.register_emitter("gltf_spot", GltfSpot)
