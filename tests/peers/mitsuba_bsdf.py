# SPDX-License-Identifier: Apache-2.0
"""Lucarium's BSDF as a Mitsuba plug-in, written from its definition, not from its kernels: the specular albedo comes
from quadrature here. Import after mi.set_variant().

  f = (1 - Ebar) c_diff / pi + F D G2 / (4 cos_v cos_l),  F = F0 + (F90 - F0) (1 - v.h)^5,

GGX with height-correlated Smith masking; 0 where geometric and shading normal see a direction on different sides.
"""

import drjit as dr
import mitsuba as mi
import numpy as np


def masking(cosine, a2):
    """Smith's Lambda of GGX."""
    return 0.5 * (np.sqrt(1 + a2 * (1 - cosine**2) / cosine**2) - 1)


def average_albedo(roughness, nodes=48):
    """Cosine averages (E1, B) of the albedo with F = 1 and with F = (1 - v.h)^5, over visible normals."""
    alpha, a2 = roughness**2, roughness**4
    x, w = np.polynomial.legendre.leggauss(nodes)
    mu2, wmu = 0.5 * (x + 1), 0.5 * w  # of cos^2: its measure is that of the cosine average
    u, wu = 0.5 * (x + 1), 0.5 * w
    phi = np.pi * (np.arange(2 * nodes) + 0.5) / (2 * nodes)  # half of a symmetric circle
    e1 = b = 0.0
    for m2, wm in zip(mu2, wmu):
        cos_v = np.sqrt(m2)
        v = np.array([np.sqrt(1 - m2), 0.0, cos_v])
        s = np.array([alpha * v[0], 0.0, v[2]])
        s /= np.linalg.norm(s)
        # Spherical caps: a uniform point of the cap above -s.z plus s is the stretched visible normal.
        z = (1 - u)[:, None] * (1 + s[2]) - s[2] + 0 * phi
        r = np.sqrt(np.maximum(0, 1 - z**2))
        h = np.stack([alpha * (r * np.cos(phi) + s[0]), alpha * r * np.sin(phi), np.maximum(z + s[2], 0)], -1)
        h /= np.linalg.norm(h, axis=-1, keepdims=True)
        vh = h @ v
        cos_l = 2 * vh * h[..., 2] - cos_v
        up = cos_l > 0
        lv, ll = masking(cos_v, a2), masking(np.where(up, cos_l, 1), a2)
        weight = np.where(up, (1 + lv) / (1 + lv + ll), 0)
        mean = (weight * wu[:, None]).sum(0).mean(), (weight * (1 - vh) ** 5 * wu[:, None]).sum(0).mean()
        e1, b = e1 + wm * mean[0], b + wm * mean[1]
    return e1, b


class LucariumBsdf(mi.BSDF):
    """Properties: base_color (texture), metallic, roughness, ior, two_sided."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.base_color = props.get_texture("base_color")
        self.metallic, self.alpha = props["metallic"], props["roughness"] ** 2
        self.two_sided = props["two_sided"]
        ior = props["ior"]
        self.specular = self.metallic > 0 or ior != 1
        self.dielectric_f0, self.dielectric_f90 = ((ior - 1) / (ior + 1)) ** 2, 0.0 if ior == 1 else 1.0
        self.e1, self.b = average_albedo(props["roughness"]) if self.specular else (0.0, 0.0)
        sides = mi.BSDFFlags.FrontSide | (mi.BSDFFlags.BackSide if self.two_sided else mi.BSDFFlags.Empty)
        self.m_components = [mi.BSDFFlags.DiffuseReflection | sides]
        if self.specular:
            self.m_components.append(mi.BSDFFlags.GlossyReflection | sides)
        self.m_flags = self.m_components[0] | self.m_components[-1]

    def lobes(self, si, active):
        """Diffuse albedo, F0, F90."""
        base = self.base_color.eval(si, active)
        f0 = dr.lerp(mi.Color3f(self.dielectric_f0), base, self.metallic)
        f90 = (1 - self.metallic) * self.dielectric_f90 + self.metallic
        average = f0 * (self.e1 - self.b) + f90 * self.b
        return (1 - self.metallic) * base * (1 - average), f0, f90

    def frame(self, si):
        """The view in the frame of the viewer's side, the sign that turns a direction into it, whether it is seen."""
        front = dr.dot(si.n, si.to_world(si.wi)) > 0
        side = dr.select(front, mi.Float(1), mi.Float(-1))
        wi = mi.Vector3f(si.wi.x, si.wi.y, si.wi.z * side)
        return wi, side, (front | mi.Bool(self.two_sided)) & (wi.z > 0)

    def choice(self, diffuse, f0, f90, wi):
        """Probability of the specular lobe."""
        if not self.specular:
            return mi.Float(0)
        specular = mi.luminance(f0 + (f90 - f0) * (1 - wi.z) ** 5)
        total = specular + mi.luminance(diffuse)
        return dr.select(mi.luminance(diffuse) > 0, dr.clip(specular / total, 0.1, 0.9), mi.Float(1))

    def evaluate(self, si, wo_local, active):
        """Value with the cosine, and density."""
        wi, side, seen = self.frame(si)
        wo = mi.Vector3f(wo_local.x, wo_local.y, wo_local.z * side)
        agree = side * dr.dot(si.n, si.to_world(wo_local)) > 0
        active &= seen & (wo.z > 0)
        diffuse, f0, f90 = self.lobes(si, active)
        value, pdf = diffuse * (wo.z / dr.pi), wo.z / dr.pi
        if self.specular:
            distribution = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)
            h = dr.normalize(wi + wo)
            d = distribution.eval(h)
            g1v, g1l = distribution.smith_g1(wi, h), distribution.smith_g1(wo, h)
            g2 = g1v * g1l / (g1v + g1l - g1v * g1l)  # 1 / (1 + Lambda_v + Lambda_l)
            fresnel = f0 + (f90 - f0) * (1 - dr.dot(wi, h)) ** 5
            value += fresnel * (d * g2 / (4 * wi.z))
            choice = self.choice(diffuse, f0, f90, wi)
            pdf = dr.lerp(pdf, g1v * d / (4 * wi.z), choice)
        return dr.select(active & agree, value, 0), dr.select(active, pdf, 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        wi, side, seen = self.frame(si)
        wo = mi.warp.square_to_cosine_hemisphere(sample2)
        if self.specular:
            diffuse, f0, f90 = self.lobes(si, active)
            distribution = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)
            h, _ = distribution.sample(wi, sample2)
            wo = dr.select(sample1 < self.choice(diffuse, f0, f90, wi), mi.reflect(wi, h), wo)
        wo_local = mi.Vector3f(wo.x, wo.y, wo.z * side)
        value, pdf = self.evaluate(si, wo_local, mi.Bool(active) & seen)
        sample = mi.BSDFSample3f(wo_local)
        sample.pdf = pdf
        sample.sampled_type = mi.UInt32(+self.m_components[-1])
        sample.sampled_component = mi.UInt32(0)
        return sample, dr.select(pdf > 0, value / pdf, 0)

    def eval(self, ctx, si, wo, active=True):
        return self.evaluate(si, wo, mi.Bool(active))[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.evaluate(si, wo, mi.Bool(active))[1]

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.evaluate(si, wo, mi.Bool(active))

    def traverse(self, callback):
        callback.put("base_color", self.base_color, mi.ParamFlags.Differentiable)

    def to_string(self):
        return "LucariumBsdf[]"


class SchlickGlass(mi.BSDF):
    """Ideal glass with Schlick's Fresnel term on the less dense side. Properties: ior, f0 (0: that of the ior)."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.ior = props["ior"]
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [mi.BSDFFlags.DeltaReflection | both, mi.BSDFFlags.DeltaTransmission | both]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def sample(self, ctx, si, sample1, sample2, active=True):
        cos_v = si.wi.z
        eta = dr.select(cos_v > 0, mi.Float(self.ior), mi.Float(1 / self.ior))  # of the far side over the near one
        cos2_far = 1 - (1 - cos_v * cos_v) / (eta * eta)
        cos_far = dr.sqrt(dr.maximum(cos2_far, 0))
        f0 = ((self.ior - 1) / (self.ior + 1)) ** 2
        thin = dr.select(cos_v > 0, cos_v, cos_far)  # cosine on the less dense side
        fresnel = dr.select(cos2_far > 0, f0 + (1 - f0) * (1 - thin) ** 5, 1)
        reflect = sample1 < fresnel
        refracted = mi.Vector3f(-si.wi.x / eta, -si.wi.y / eta, -dr.sign(cos_v) * cos_far)
        sample = mi.BSDFSample3f(dr.select(reflect, mi.reflect(si.wi), refracted))
        sample.pdf = dr.select(reflect, fresnel, 1 - fresnel)
        sample.eta = dr.select(reflect, 1, eta)
        sample.sampled_type = dr.select(reflect, mi.UInt32(+mi.BSDFFlags.DeltaReflection),
                                        mi.UInt32(+mi.BSDFFlags.DeltaTransmission))
        sample.sampled_component = dr.select(reflect, mi.UInt32(0), mi.UInt32(1))
        # Radiance is compressed by the refraction.
        value = mi.Color3f(dr.select(reflect, mi.Float(1), 1 / (eta * eta)))
        return sample, dr.select(active & (cos_v != 0), value, 0)

    def eval(self, ctx, si, wo, active=True):
        return mi.Color3f(0)

    def pdf(self, ctx, si, wo, active=True):
        return mi.Float(0)

    def eval_pdf(self, ctx, si, wo, active=True):
        return mi.Color3f(0), mi.Float(0)

    def to_string(self):
        return "SchlickGlass[]"


def register():
    mi.register_bsdf("lucarium_bsdf", LucariumBsdf)
    mi.register_bsdf("schlick_glass", SchlickGlass)
