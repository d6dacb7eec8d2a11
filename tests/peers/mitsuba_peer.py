# SPDX-License-Identifier: Apache-2.0
"""A Scene of gltf.py in Mitsuba 3: as a dictionary with PLY files, rendered by its `path` integrator."""

import ctypes.util
import glob
import importlib.util
import os
from pathlib import Path

import numpy as np

import image_test
from lucarium import Missing, read_exr, write_exr

VARIANTS = ("llvm_ad_rgb", "scalar_rgb")


def find_llvm():
    """Dr.Jit needs LLVM 17 or newer, and looks for a name that Debian gives to development packages only."""
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        return True
    for version in range(30, 16, -1):
        found = glob.glob(f"/usr/lib/*/libLLVM.so.{version}*") + glob.glob(f"/usr/lib/*/libLLVM-{version}.so*")
        if found:
            os.environ["DRJIT_LIBLLVM_PATH"] = found[0]
            return True
    return ctypes.util.find_library("LLVM") is not None


def require(variant):
    """Sets the variant, registers the plug-ins; throws Missing."""
    if importlib.util.find_spec("mitsuba") is None:
        raise Missing("the Python package mitsuba is not installed (pip install -r tests/peers/requirements.txt)")
    if variant.startswith("llvm") and not find_llvm():
        raise Missing(f"{variant} needs LLVM 17 or newer (Debian 12: libllvm19)")
    import mitsuba

    mitsuba.set_variant(variant)
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    if variant.startswith("llvm"):
        import mitsuba_bsdf
        import mitsuba_spot

        mitsuba_bsdf.register()
        mitsuba_spot.register()
    return mitsuba


def write_ply(file, mesh):
    """Binary PLY with normals and texture coordinates."""
    uv = mesh.uv if mesh.uv is not None else np.zeros((len(mesh.positions), 2))
    vertices = np.hstack([mesh.positions, mesh.normals, uv]).astype("<f4")
    faces = np.empty(len(mesh.triangles), dtype=[("n", "u1"), ("i", "<i4", 3)])
    faces["n"], faces["i"] = 3, mesh.triangles
    names = "".join(f"property float {n}\n" for n in ("x", "y", "z", "nx", "ny", "nz", "u", "v"))
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{names}"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    Path(file).write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())


def is_flat(mesh):
    """Whether the vertex normals are those of the faces."""
    corners = mesh.positions[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.where(length > 0, length, 1)
    return bool((np.abs(mesh.normals[mesh.triangles] - normal[:, None])[length[:, 0] > 0] < 1e-4).all())


class Exporter:
    """One scene on its way to Mitsuba. `folder` takes PLY files; `own_bsdf` prefers the plug-in of mitsuba_bsdf.py to
    Mitsuba's BSDFs where a material is not exactly one of these."""

    def __init__(self, mi, scene, folder, own_bsdf=True):
        self.mi, self.scene, self.folder, self.own_bsdf = mi, scene, Path(folder), own_bsdf

    def image(self, index):
        """An image of the scene, which passes through a file."""
        file = self.folder / f"image{index}.png"
        file.write_bytes(self.scene.images[index])
        return self.mi.Bitmap(str(file))

    def texture(self, use, factor):
        """A constant, or a picture; a factor other than white is applied to the linear pixels."""
        if use is None:
            return {"type": "rgb", "value": [float(f) for f in factor]}
        bitmap = self.image(
    use.image).convert(
        self.mi.Bitmap.PixelFormat.RGB,
        self.mi.Struct.Type.Float32,
         srgb_gamma=False)
        pixels = np.array(bitmap) * np.asarray(factor, np.float32)
        return {"type": "bitmap", "bitmap": self.mi.Bitmap(pixels.astype(np.float32)), "raw": True,
                "format": "variant", "filter_type": "bilinear", "wrap_mode": "clamp" if use.clamp else "repeat"}

    def opacity(self, material):
        """MASK: the alpha of the base colour against the cutoff, texel by texel."""
        use = material.base_texture
        alpha = np.array(self.image(use.image))[..., 3:4] / 255.0
        mask = (alpha * material.base_color[3] >= material.alpha_cutoff).astype(np.float32)
        return {"type": "bitmap", "bitmap": self.mi.Bitmap(mask), "raw": True, "filter_type": "nearest",
                "wrap_mode": "clamp" if use.clamp else "repeat"}

    def bsdf(self, material, flat):
        base = self.texture(material.base_texture, material.base_color[:3])
        if material.transmission == 1 and material.roughness == 0:
            return {"type": "schlick_glass", "ior": material.ior}
        lambert = material.metallic == 0 and material.ior == 1
        if lambert and (flat or not self.own_bsdf):
            bsdf = {"type": "diffuse", "reflectance": base}
            if material.two_sided:
                bsdf = {"type": "twosided", "bsdf": bsdf}
        elif material.metallic == 1 and not self.own_bsdf:
            # Without conductor data the Fresnel term is 1; masking is separable.
            bsdf = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": material.roughness**2,
                    "specular_reflectance": base}
        else:
            bsdf = {"type": "lucarium_bsdf", "base_color": base, "metallic": material.metallic,
                    "roughness": material.roughness, "ior": material.ior, "two_sided": material.two_sided}
        if material.alpha_cutoff is not None and material.base_texture is not None:
            bsdf = {"type": "mask", "opacity": self.opacity(material), "bsdf": bsdf}
        return bsdf

    def shapes(self):
        result = {}
        for index, mesh in enumerate(self.scene.meshes):
            material, file, flat = self.scene.materials[mesh.material], self.folder / f"{index}.ply", is_flat(mesh)
            write_ply(file, mesh)
            name = f"bsdf{mesh.material}_{flat}"
            if name not in result:
                result[name] = self.bsdf(material, flat)
            shape = {"type": "ply", "filename": str(file), "face_normals": flat,
                     "bsdf": {"type": "ref", "id": name}}
            if material.emission.max() > 0:
                if material.two_sided:
                    raise ValueError(f"{material.name}: two-sided emitters are not exported")
                shape["emitter"] = {
    "type": "area",
    "radiance": self.texture(
        material.emission_texture,
         material.emission)}
            result[f"shape{index}"] = shape
        return result

    def light(self, light):
        rgb = {"type": "rgb", "value": [float(x) for x in light.intensity]}
        if light.kind == "point":
            return {"type": "point", "position": light.position.tolist(), "intensity": rgb}
        if light.kind == "directional":
            return {"type": "directional", "direction": light.direction.tolist(), "irradiance": rgb}
        return {"type": "gltf_spot", "position": self.mi.ScalarVector3f(light.position),
                "direction": self.mi.ScalarVector3f(light.direction),
                "intensity": self.mi.ScalarVector3f(light.intensity),
                "inner": light.inner, "outer": light.outer}

    def environment(self):
        environment = self.scene.environment
        if environment.radiance is not None:
            return {"type": "constant", "radiance": {"type": "rgb", "value": environment.radiance.tolist()}}
        file = self.folder / "environment.exr"
        write_exr(file, refined_environment(read_exr(environment.file)))
        # Mitsuba's u is less by a quarter; then the picture's own turn.
        degrees = float(np.degrees(environment.rotation))
        return {"type": "envmap", "filename": str(file),
                "to_world": self.mi.ScalarTransform4f().rotate([0, 1, 0], degrees)}

    def sensor(self, size):
        camera = self.scene.camera
        origin, forward, up = camera[:3, 3], -camera[:3, 2], camera[:3, 1]
        to_world = self.mi.ScalarTransform4f().look_at(origin.tolist(), (origin + forward).tolist(), up.tolist())
        return {"type": "perspective", "fov": float(np.degrees(self.scene.yfov)), "fov_axis": "y", "to_world": to_world,
                "near_clip": 1e-3, "far_clip": 1e5, "sampler": {"type": "independent"},
                "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "component_format": "float32",
                         "pixel_format": "rgb", "rfilter": {"type": "box"}}}

    def load(self, size, bounces):
        """The Mitsuba scene; bounces -1: unlimited, with its own roulette."""
        depth = {"max_depth": bounces + 2, "rr_depth": 10000} if bounces >= 0 else {"max_depth": -1, "rr_depth": 5}
        result = {
    "type": "scene",
    "integrator": {
        "type": "path",
        **depth},
        "sensor": self.sensor(size),
         **self.shapes()}
        for index, light in enumerate(self.scene.lights):
            result[f"light{index}"] = self.light(light)
        if self.scene.environment is not None:
            result["environment"] = self.environment()
        return self.mi.load_dict(result)


def refined_environment(rgb):
    """The same bilinear function on Mitsuba's grid: columns at texel centres, 3 for 1, rows from pole to pole, 2 h + 1;
    all kinks fall on samples. Turned by a quarter, since Mitsuba's u is less by 1/4."""
    h, w = rgb.shape[:2]
    x = (np.arange(3 * w) + 0.5) / 3 - 0.5 + w / 4
    y = np.clip(np.arange(2 * h + 1) / 2 - 0.5, 0, h - 1)
    j0 = np.minimum(y.astype(int), h - 1)
    j1, fy = np.minimum(j0 + 1, h - 1), (y - j0)[:, None, None]
    rows = (1 - fy) * rgb[j0] + fy * rgb[j1]
    i0 = np.floor(x).astype(int)
    fx = (x - i0)[None, :, None]
    return (1 - fx) * rows[:, i0 % w] + fx * rows[:, (i0 + 1) % w]


def render(scene, size, bounces, samples, replicates, folder, variant="llvm_ad_rgb", own_bsdf=True):
    """The image test's Render of a Scene; `samples` per replicate and pixel."""
    mi = require(variant)
    loaded = Exporter(mi, scene, folder, own_bsdf).load(size, bounces)
    images = [np.array(mi.render(loaded, spp=samples, seed=r + 1), np.float64) for r in range(replicates)]
    return image_test.Render.of_replicates(np.stack(images))
