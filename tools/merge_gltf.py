#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Puts one glTF file into another, animations and skins included:

    lucarium scene builtin:room --export room.glb
    tools/merge_gltf.py room.glb Fox.glb room_with_fox.glb --scale 0.009 --translate=-0.2,0,0.35 --turn 60
    lucarium render room_with_fox.glb -t micro_rendering --animation Run --frames 0:23 -o fox.png

The added file's scene hangs on one new node, which is turned about +Y, scaled and moved. Everything is written into one
.glb. The sidecar of the first file (exposure, environment) is not read: name environments again.
"""
import argparse
import base64
import json
import math
import pathlib
import struct

LISTS = [
    "accessors",
    "animations",
    "bufferViews",
    "cameras",
    "images",
    "materials",
    "meshes",
    "nodes",
    "samplers",
    "skins",
     "textures"]
LIGHTS = "KHR_lights_punctual"


def load(path):
    """The JSON of a .gltf or .glb file and its buffers' bytes."""
    data = path.read_bytes()
    binary = b""
    if data[:4] == b"glTF":
        length, = struct.unpack_from("<I", data, 12)
        text, rest = data[20:20 + length], data[20 + length:]
        if rest:
            binary = rest[8:8 + struct.unpack_from("<I", rest)[0]]
    else:
        text = data
    gltf = json.loads(text)

    def fetch(uri):
        if uri is None:
            return binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (path.parent / uri).read_bytes()

    buffers = [fetch(b.get("uri"))[:b["byteLength"]] for b in gltf.get("buffers", [])]
    for image in gltf.get("images", []):
        if "uri" in image:  # becomes part of the one buffer
            uri = image.pop("uri")
            image.setdefault("mimeType", "image/png" if ".png" in uri.lower()
                             or "image/png" in uri[:20] else "image/jpeg")
            buffers.append(fetch(uri))
            gltf.setdefault("bufferViews", []).append({"buffer": len(buffers) - 1, "byteLength": len(buffers[-1])})
            image["bufferView"] = len(gltf["bufferViews"]) - 1
    return gltf, buffers


def shift(gltf, by):
    """Adds by[list] to every index into that list."""
    def add(thing, key, name):
        if thing is not None and key in thing:
            thing[key] += by[name]

    def shift_textures(thing):
        for key, value in thing.items() if isinstance(thing, dict) else ():
            if key.endswith("Texture"):
                add(value, "index", "textures")
            shift_textures(value)

    for accessor in gltf.get("accessors", []):
        add(accessor, "bufferView", "bufferViews")
        for part in ("indices", "values"):
            add(accessor.get("sparse", {}).get(part), "bufferView", "bufferViews")
    for image in gltf.get("images", []):
        add(image, "bufferView", "bufferViews")
    for texture in gltf.get("textures", []):
        add(texture, "sampler", "samplers")
        add(texture, "source", "images")
    for material in gltf.get("materials", []):
        shift_textures(material)
    for mesh in gltf.get("meshes", []):
        for primitive in mesh["primitives"]:
            add(primitive, "indices", "accessors")
            add(primitive, "material", "materials")
            for attributes in [primitive["attributes"], *primitive.get("targets", [])]:
                for key in attributes:
                    attributes[key] += by["accessors"]
    for node in gltf.get("nodes", []):
        add(node, "mesh", "meshes")
        add(node, "skin", "skins")
        add(node, "camera", "cameras")
        node_light = node.get("extensions", {}).get(LIGHTS)
        add(node_light, "light", "lights")
        if "children" in node:
            node["children"] = [c + by["nodes"] for c in node["children"]]
    for skin in gltf.get("skins", []):
        add(skin, "inverseBindMatrices", "accessors")
        add(skin, "skeleton", "nodes")
        skin["joints"] = [j + by["nodes"] for j in skin["joints"]]
    for animation in gltf.get("animations", []):
        for channel in animation["channels"]:
            add(channel["target"], "node", "nodes")
        for sampler in animation["samplers"]:
            add(sampler, "input", "accessors")
            add(sampler, "output", "accessors")


def roots(gltf):
    if gltf.get("scenes"):
        return gltf["scenes"][gltf.get("scene", 0)].get("nodes", [])
    children = {c for node in gltf.get("nodes", []) for c in node.get("children", [])}
    return [i for i in range(len(gltf.get("nodes", []))) if i not in children]


def lights(gltf):
    return gltf.get("extensions", {}).get(LIGHTS, {}).get("lights", [])


def pack_buffers(gltf, buffers, binary):
    """Moves the buffers of `gltf` to the end of `binary`."""
    starts = []
    for data in buffers:
        binary.extend(b"\0" * (-len(binary) % 16))
        starts.append(len(binary))
        binary.extend(data)
    for view in gltf.get("bufferViews", []):
        view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
        view["buffer"] = 0


def merge(base, added, translate, scale, turn):
    for gltf in (base, added):
        for name in ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu", "EXT_texture_webp"):
            if name in gltf.get("extensionsRequired", []):
                raise SystemExit(f"merge_gltf: {name} is not supported; decode the file first")
    by = {name: len(base.get(name, [])) for name in LISTS}
    by["lights"] = len(lights(base))
    first = roots(base)
    shift(added, by)
    second = [r + by["nodes"] for r in roots(added)]
    for name in LISTS:
        if base.get(name) or added.get(name):
            base[name] = base.get(name, []) + added.get(name, [])
    half = math.radians(turn) / 2
    base["nodes"].append({"name": "added", "children": second, "translation": translate, "scale": [scale] * 3,
                          "rotation": [0, math.sin(half), 0, math.cos(half)]})
    base["scenes"] = [{"nodes": first + [len(base["nodes"]) - 1]}]
    base["scene"] = 0
    all_lights = lights(base) + lights(added)
    if all_lights:
        base.setdefault("extensions", {})[LIGHTS] = {"lights": all_lights}
    for name in ("extensionsUsed", "extensionsRequired"):
        names = sorted(set(base.get(name, [])) | set(added.get(name, [])))
        if names:
            base[name] = names


def save(path, gltf, binary):
    binary.extend(b"\0" * (-len(binary) % 4))
    gltf["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(binary), b"BIN\0") + bytes(binary))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", type=pathlib.Path, help="what the other is put into: its camera comes first")
    parser.add_argument("added", type=pathlib.Path)
    parser.add_argument("output", type=pathlib.Path, help=".glb")
    parser.add_argument("--translate", default="0,0,0", metavar="X,Y,Z")
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--turn", type=float, default=0, metavar="DEGREES",
                        help="about +Y, counter-clockwise seen from above")
    arguments = parser.parse_args()
    (base, base_buffers), (added, added_buffers) = load(arguments.base), load(arguments.added)
    binary = bytearray()
    pack_buffers(base, base_buffers, binary)
    pack_buffers(added, added_buffers, binary)
    merge(base, added, [float(x) for x in arguments.translate.split(",")], arguments.scale, arguments.turn)
    save(arguments.output, base, binary)


if __name__ == "__main__":
    main()
