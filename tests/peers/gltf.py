# SPDX-License-Identifier: Apache-2.0
"""Reads what `lucarium scene --export` writes: a binary glTF file and its sidecar, all geometry in world space.

Only that dialect is understood (32-bit floats and indices, every node a root with a matrix, PNG images inside). Runs in
Blender's Python, too: it needs numpy alone.
"""

import json
import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
DTYPES = {5125: "<u4", 5126: "<f4"}


@dataclass
class Mesh:
    """World-space triangles, counter-clockwise seen from the front."""

    name: str
    material: int
    positions: np.ndarray  # (n, 3) [m]
    normals: np.ndarray  # (n, 3), unit
    uv: np.ndarray | None  # (n, 2), v from the top of the image
    triangles: np.ndarray  # (m, 3)


@dataclass
class Texture:
    image: int
    clamp: bool  # in both directions; else it repeats


@dataclass
class Material:
    name: str
    base_color: tuple
    metallic: float
    roughness: float
    ior: float
    transmission: float
    emission: np.ndarray  # (3,) [cd/m^2]
    two_sided: bool
    alpha_cutoff: float | None  # of MASK
    base_texture: Texture | None
    emission_texture: Texture | None


@dataclass
class Light:
    kind: str  # point, spot or directional
    intensity: np.ndarray  # (3,) [cd], directional [lx]
    position: np.ndarray
    direction: np.ndarray  # in which it shines, unit
    inner: float = 0.0  # half angles [rad]
    outer: float = 0.0


@dataclass
class Environment:
    radiance: np.ndarray | None = None  # (3,), constant [cd/m^2]
    file: Path | None = None  # equirectangular EXR
    rotation: float = 0.0  # about +Y, counter-clockwise seen from above [rad]


@dataclass
class Scene:
    meshes: list = field(default_factory=list)
    materials: list = field(default_factory=list)
    lights: list = field(default_factory=list)
    images: list = field(default_factory=list)  # encoded PNG
    camera: np.ndarray | None = None  # 4x4, looks along -Z
    yfov: float = 0.0  # [rad]
    environment: Environment | None = None

    def flatten(self):
        """Gives every triangle its own vertices and the normal of its plane."""
        for mesh in self.meshes:
            corners = mesh.triangles.ravel()
            mesh.positions = mesh.positions[corners]
            mesh.uv = mesh.uv[corners] if mesh.uv is not None else None
            mesh.triangles = np.arange(len(corners)).reshape(-1, 3)
            a, b, c = mesh.positions[0::3], mesh.positions[1::3], mesh.positions[2::3]
            normals = np.cross(b - a, c - a)
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
            mesh.normals = np.repeat(normals, 3, axis=0)


def split_container(data):
    """JSON and binary chunk of a .glb (glTF 2.0, section 4.4)."""
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + length])
    start = 20 + length + 8
    return document, memoryview(data)[start : start + document["buffers"][0]["byteLength"]]


class Reader:
    """One file on its way to a Scene."""

    def __init__(self, file):
        self.json, self.binary = split_container(Path(file).read_bytes())

    def view(self, index):
        view = self.json["bufferViews"][index]
        return self.binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]

    def array(self, index):
        accessor = self.json["accessors"][index]
        values = np.frombuffer(self.view(accessor["bufferView"]), DTYPES[accessor["componentType"]])
        return values.reshape(accessor["count"], COMPONENTS[accessor["type"]])

    def texture(self, owner, key):
        info = owner.get(key)
        if info is None:
            return None
        if info.get("texCoord", 0) != 0 or "extensions" in info:
            raise ValueError(f"{key}: only plain uses of texture coordinates 0 are exported to peers")
        texture = self.json["textures"][info["index"]]
        return Texture(texture["source"], self.json["samplers"][texture["sampler"]]["wrapS"] == 33071)

    def material(self, json):
        pbr, extensions = json["pbrMetallicRoughness"], json.get("extensions", {})
        strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        if json.get("alphaMode") == "BLEND" or "KHR_materials_unlit" in extensions:
            raise ValueError(f"material {json['name']}: BLEND and unlit are not exported to peers")
        return Material(
            json["name"],
            tuple(pbr["baseColorFactor"]),
            pbr["metallicFactor"],
            pbr["roughnessFactor"],
            extensions.get("KHR_materials_ior", {}).get("ior", 1.5),
            extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0),
            strength * np.array(json["emissiveFactor"]),
            json["doubleSided"],
            json.get("alphaCutoff") if json.get("alphaMode") == "MASK" else None,
            self.texture(pbr, "baseColorTexture"),
            self.texture(json, "emissiveTexture"),
        )

    def mesh(self, index, matrix):
        mesh = self.json["meshes"][index]
        primitive = mesh["primitives"][0]
        attributes = primitive["attributes"]
        linear = matrix[:3, :3]
        normals = self.array(attributes["NORMAL"]) @ np.linalg.inv(linear)
        triangles = self.array(primitive["indices"]).reshape(-1, 3)
        if np.linalg.det(linear) < 0:
            triangles = triangles[:, [0, 2, 1]]
        return Mesh(
            mesh["name"],
            primitive["material"],
            self.array(attributes["POSITION"]) @ linear.T + matrix[:3, 3],
            normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30),
            self.array(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else None,
            triangles,
        )

    def light(self, json, matrix):
        spot = json.get("spot", {})
        return Light(
            json["type"],
            json["intensity"] * np.array(json["color"]),
            matrix[:3, 3],
            -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2]),
            spot.get("innerConeAngle", 0.0),
            spot.get("outerConeAngle", 0.0),
        )

    def scene(self):
        result = Scene(materials=[self.material(m) for m in self.json["materials"]])
        result.images = [bytes(self.view(image["bufferView"])) for image in self.json.get("images", [])]
        lights = self.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
        for node in self.json["nodes"]:
            matrix = np.array(node.get("matrix", np.eye(4).ravel())).reshape(4, 4).T
            if "mesh" in node:
                result.meshes.append(self.mesh(node["mesh"], matrix))
            elif "camera" in node:
                if result.camera is None:
                    result.camera = matrix
                    result.yfov = self.json["cameras"][node["camera"]]["perspective"]["yfov"]
            else:
                index = node["extensions"]["KHR_lights_punctual"]["light"]
                result.lights.append(self.light(lights[index], matrix))
        return result


def read_environment(sidecar):
    json_environment = json.loads(sidecar.read_text()).get("environment")
    if json_environment is None:
        return None
    if "radiance" in json_environment:
        return Environment(radiance=np.array(json_environment["radiance"]))
    rotation = np.radians(json_environment["rotation_degrees"])
    return Environment(file=sidecar.parent / json_environment["file"], rotation=rotation)


def read(file):
    """The Scene in FILE.glb and FILE.glb.lucarium.json."""
    scene = Reader(file).scene()
    scene.environment = read_environment(Path(f"{file}.lucarium.json"))
    return scene


def move_emitters(file, offset):
    """Shifts all meshes that emit by a world-space vector [m], in FILE.glb itself."""
    data, reader = bytearray(Path(file).read_bytes()), Reader(file)
    binary_start = len(data) - len(reader.binary)
    for node in reader.json["nodes"]:
        if "mesh" not in node:
            continue
        primitive = reader.json["meshes"][node["mesh"]]["primitives"][0]
        if max(reader.json["materials"][primitive["material"]]["emissiveFactor"]) == 0:
            continue
        matrix = np.array(node.get("matrix", np.eye(4).ravel())).reshape(4, 4).T
        accessor = primitive["attributes"]["POSITION"]
        moved = (reader.array(accessor) + np.linalg.solve(matrix[:3, :3], offset)).astype("<f4").tobytes()
        view = reader.json["bufferViews"][reader.json["accessors"][accessor]["bufferView"]]
        start = binary_start + view["byteOffset"]
        data[start : start + len(moved)] = moved
    Path(file).write_bytes(data)
