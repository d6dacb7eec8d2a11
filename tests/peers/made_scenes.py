# SPDX-License-Identifier: Apache-2.0
"""Scenes made here, as glTF files with a data URI: spheres, a textured lamp, planes."""

import base64
import json
import struct
import zlib

import numpy as np


def png(rgb):
    """An image (h, w, 3) of bytes as a PNG file."""
    h, w = rgb.shape[:2]
    rows = np.hstack([np.zeros((h, 1), np.uint8), rgb.astype(np.uint8).reshape(h, 3 * w)]).tobytes()

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", w, h, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def quad(corner, u, v):
    """Positions, normals, uv (v downwards from the end of `v`), triangles of a flat rectangle; front: u x v."""
    corner, u, v = (np.array(x, np.float32) for x in (corner, u, v))
    positions = np.array([corner, corner + u, corner + u + v, corner + v])
    normal = np.cross(u, v)
    normals = np.tile(normal / np.linalg.norm(normal), (4, 1))
    return positions, normals, np.array([[0, 1], [1, 1], [1, 0], [0, 0]]), np.array([[0, 1, 2], [0, 2, 3]])


def sphere(centre, radius, rows=48, columns=96, flat=False):
    """A latitude-longitude sphere with smooth normals, or with those of its faces."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns + 1), indexing="ij")
    unit = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    a = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    below = a + columns + 1
    triangles = np.concatenate([np.stack([a, below, below + 1], 1), np.stack([a, below + 1, a + 1], 1)])
    corners = unit[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    kept = np.linalg.norm(normal, axis=1) > 1e-7  # the poles' triangles without area go
    triangles, normal = triangles[kept], normal[kept]
    centre = np.array(centre)
    if flat:
        normals = np.repeat(normal / np.linalg.norm(normal, axis=1, keepdims=True), 3, axis=0)
        positions = unit[triangles].reshape(-1, 3)
        return centre + radius * \
            positions, normals, np.zeros((len(positions), 2)), np.arange(len(positions)).reshape(-1, 3)
    return centre + radius * unit, unit, np.zeros((len(unit), 2)), triangles


class Writer:
    """A glTF document that grows."""

    def __init__(self):
        self.buffer = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "bufferViews": [],
                     "accessors": [],
                     "meshes": [], "materials": [], "nodes": [], "images": [], "textures": []}

    def view(self, data):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)})
        self.buffer += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values, kind):
        integer = kind == "SCALAR"
        data = np.ascontiguousarray(values, "<u4" if integer else "<f4")
        accessor = {"bufferView": self.view(data.tobytes()), "componentType": 5125 if integer else 5126,
                    "count": len(data), "type": kind}
        if kind == "VEC3":
            accessor |= {"min": data.min(0).tolist(), "max": data.max(0).tolist()}
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def texture(self, rgb):
        self.json["images"].append({"bufferView": self.view(png(rgb)), "mimeType": "image/png"})
        self.json["textures"].append({"source": len(self.json["images"]) - 1})
        return len(self.json["textures"]) - 1

    def material(self, name, base=(0.5, 0.5, 0.5), metallic=0.0, roughness=1.0, ior=1.0, **more):
        extensions = {"KHR_materials_ior": {"ior": ior}} | more.pop("extensions", {})
        self.json["materials"].append({
            "name": name, "extensions": extensions,
            "pbrMetallicRoughness": {"baseColorFactor": [*base, 1], "metallicFactor": metallic,
                                     "roughnessFactor": roughness}
            | more.pop("pbr", {})} | more)
        return len(self.json["materials"]) - 1

    def add(self, name, geometry, material):
        positions, normals, uv, triangles = geometry
        primitive = {"attributes": {"POSITION": self.accessor(positions, "VEC3"),
                                    "NORMAL": self.accessor(normals, "VEC3"),
                                    "TEXCOORD_0": self.accessor(uv, "VEC2")},
                     "indices": self.accessor(np.ravel(triangles), "SCALAR"), "material": material}
        self.json["meshes"].append({"name": name, "primitives": [primitive]})
        self.json["nodes"].append({"name": name, "mesh": len(self.json["meshes"]) - 1})
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def write(self, file):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.buffer).decode()
        used = {name for m in self.json["materials"] for name in m["extensions"]}
        document = {k: v for k, v in self.json.items() if v != []}
        document |= {"buffers": [{"byteLength": len(self.buffer), "uri": uri}], "extensionsUsed": sorted(used)}
        file.write_text(json.dumps(document))
        return str(file)


def floor_and_walls(writer):
    """Two Lambert walls and a floor, without symmetry."""
    grey = writer.material("floor", (0.6, 0.55, 0.5))
    blue = writer.material("wall", (0.2, 0.3, 0.7))
    writer.add("floor", quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), grey)
    writer.add("back", quad((-2, 0, -2), (4, 0, 0), (0, 3, 0)), blue)
    writer.add("left", quad((-2, 0, 2), (0, 0, -4), (0, 3, 0)), grey)


def lamp(writer, corner, u, v, radiance, texture=None):
    """A rectangle that shines towards u x v."""
    more = {"emissiveTexture": {"index": texture}} if texture is not None else {}
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": radiance}}
    material = writer.material("lamp", (0, 0, 0), extensions=strength, emissiveFactor=[1, 1, 1], **more)
    writer.add("lamp", quad(corner, u, v), material)


def textured_light():
    """A lamp and a floor with small pictures that have no symmetry, so that any turn or flip shows."""
    writer = Writer()
    floor_and_walls(writer)
    random = np.random.default_rng(7)
    picture = random.integers(0, 256, (6, 9, 3))
    picture[:3, :4] = (255, 40, 10)
    picture[4:, 6:] = (0, 0, 0)
    writer.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": writer.texture(picture)}
    lamp(writer, (-1, 0.4, -1.9), (1.8, 0, 0), (0, 1.2, 0), 4.0, writer.texture(picture))
    return writer


def spheres(material_of, flat=False):
    """Three spheres on a floor under one lamp; `material_of(writer, i)` gives their materials."""
    writer = Writer()
    floor_and_walls(writer)
    lamp(writer, (-0.6, 2.9, -0.6), (1.2, 0, 0), (0, 0, 1.2), 12.0)
    for i in range(3):
        writer.add(f"sphere {i}", sphere((-1.1 + 1.1 * i, 0.5, 0.1 * i), 0.45, flat=flat), material_of(writer, i))
    return writer


def rough_metals():
    """Coloured metals of three roughnesses."""
    colors = ((0.95, 0.64, 0.54), (0.9, 0.9, 0.9), (0.3, 0.6, 0.9))
    return spheres(lambda w, i: w.material(f"metal {i}", colors[i], 1.0, (0.25, 0.5, 0.8)[i]))


def white_metals():
    """The same, white, so that F is 1 at every angle, and faceted, so that normals cannot disagree."""
    return spheres(lambda w, i: w.material(f"metal {i}", (1, 1, 1), 1.0, (0.25, 0.5, 0.8)[i]), flat=True)


def rough_dielectrics():
    """Lambert under a specular lobe of index 1.5."""
    return spheres(lambda w, i: w.material(f"plastic {i}", (0.7, 0.3, 0.2), 0.0, (0.3, 0.5, 1.0)[i], 1.5))


def add_glass_sphere(writer):
    """Ideal glass of index 1.5, faceted."""
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1.0},
                  "KHR_materials_volume": {"thicknessFactor": 1.0}}
    material = writer.material("glass", (1, 1, 1), 0.0, 0.0, 1.5, extensions=extensions)
    writer.add("sphere", sphere((0.2, 0.6, 0.3), 0.6, flat=True), material)
    return writer


def glass():
    """A glass sphere before a textured lamp."""
    return add_glass_sphere(textured_light())


def glass_corner():
    """A glass sphere, without light."""
    writer = Writer()
    floor_and_walls(writer)
    return add_glass_sphere(writer)


def corner():
    """Floor, walls and a sphere, without light."""
    writer = Writer()
    floor_and_walls(writer)
    writer.add("sphere", sphere((0.3, 0.6, 0.2), 0.6, flat=True), writer.material("sphere", (0.8, 0.7, 0.3)))
    return writer


MAKERS = {
    f.__name__: f for f in (
        textured_light,
        rough_metals,
        white_metals,
        rough_dielectrics,
        glass,
        glass_corner,
         corner)}


def make(name, folder):
    """Writes a scene into the folder; returns its file."""
    return MAKERS[name]().write(folder / f"{name}.gltf")
