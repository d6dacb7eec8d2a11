# SPDX-License-Identifier: Apache-2.0
"""Runs inside Blender: builds a Scene of gltf.py from nodes that mean exactly what Lucarium means, and renders it with
Cycles once per seed.

  blender -b --factory-startup -P cycles_render.py -- JOB.json

JOB.json: scene, size, bounces, samples, seeds, output (folder), threads, linear_textures, area_lights.
"""

import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import mathutils
import numpy as np

import gltf

JOB = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text())
# glTF has y up, Blender z.
TO_BLENDER = mathutils.Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


class Nodes:
    """A node tree that grows; sockets are given as values or as outputs of other nodes."""

    def __init__(self, tree):
        tree.nodes.clear()
        self.tree = tree

    def node(self, kind, inputs=(), **settings):
        node = self.tree.nodes.new(kind)
        for key, value in settings.items():
            setattr(node, key, value)
        for key, value in dict(inputs).items():
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, node.inputs[key])
            else:
                node.inputs[key].default_value = value
        return node

    def math(self, operation, a, b=0.0, c=0.0, clamp=False):
        return self.node("ShaderNodeMath", {0: a, 1: b, 2: c}, operation=operation, use_clamp=clamp).outputs[0]

    def mix(self, factor, a, b):
        return self.node("ShaderNodeMixShader", {0: factor, 1: a, 2: b}).outputs[0]

    def geometry(self, name):
        return self.node("ShaderNodeNewGeometry").outputs[name]

    def dot(self, a, b):
        return self.node("ShaderNodeVectorMath", {0: a, 1: b}, operation="DOT_PRODUCT").outputs["Value"]


def linear_image(source):
    """The picture as linear floats: Cycles interpolates bytes before it decodes sRGB, glTF demands the reverse."""
    name = f"linear {source.name}"
    if name in bpy.data.images:
        return bpy.data.images[name]
    source.colorspace_settings.name = "Non-Color"
    pixels = np.empty(len(source.pixels), np.float32)
    source.pixels.foreach_get(pixels)
    rgb = pixels.reshape(-1, 4)[:, :3]
    rgb[:] = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    image = bpy.data.images.new(name, *source.size, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(pixels)
    image.update()
    return image


def image_node(nodes, scene, use, folder):
    """A picture, bilinear; its alpha is left out of the colour."""
    file = folder / f"image{use.image}.png"
    file.write_bytes(scene.images[use.image])
    image = bpy.data.images.load(str(file), check_existing=True)
    image.alpha_mode = "CHANNEL_PACKED"
    if JOB["linear_textures"]:
        image = linear_image(image)
    return nodes.node("ShaderNodeTexImage", image=image, interpolation="Linear",
                      extension="EXTEND" if use.clamp else "REPEAT")


def color(nodes, scene, use, factor, folder):
    """A constant RGBA, or a picture times it."""
    rgba = (*[float(f) for f in factor[:3]], 1.0)
    if use is None:
        return rgba
    picture = image_node(nodes, scene, use, folder).outputs["Color"]
    return nodes.node("ShaderNodeMixRGB", {"Fac": 1.0, "Color1": picture,
                      "Color2": rgba}, blend_type="MULTIPLY").outputs[0]


def schlick_glass(nodes, ior):
    """Ideal reflection and refraction mixed by Schlick's term on the less dense side."""
    cosine = nodes.math("ABSOLUTE", nodes.dot(nodes.geometry("Incoming"), nodes.geometry("Normal")))
    back = nodes.geometry("Backfacing")
    # Cosine behind the interface, seen from inside: 1 - ior^2 (1 - c^2); not positive under total reflection.
    square = nodes.math("MULTIPLY_ADD", nodes.math("MULTIPLY", cosine, cosine), ior * ior, 1 - ior * ior)
    outside = nodes.math("SQRT", nodes.math("MAXIMUM", square, 0.0))
    thin = nodes.math("ADD", nodes.math("MULTIPLY", back, outside),
                      nodes.math("MULTIPLY", nodes.math("SUBTRACT", 1.0, back), cosine))
    f0 = ((ior - 1) / (ior + 1)) ** 2
    power = nodes.math("POWER", nodes.math("SUBTRACT", 1.0, thin), 5.0)
    fresnel = nodes.math("MULTIPLY_ADD", power, 1 - f0, f0)
    total = nodes.math("MULTIPLY", back, nodes.math("LESS_THAN", square, 1e-12))
    fresnel = nodes.math("MAXIMUM", fresnel, total)
    refraction = nodes.node("ShaderNodeBsdfRefraction", {"Color": (1, 1, 1, 1), "Roughness": 0.0, "IOR": ior},
                            distribution="SHARP")
    reflection = nodes.node("ShaderNodeBsdfGlossy", {"Color": (1, 1, 1, 1), "Roughness": 0.0}, distribution="SHARP")
    return nodes.mix(fresnel, refraction.outputs[0], reflection.outputs[0])


def surface(nodes, scene, material, folder):
    """The shader of a material seen from the front, and whether the back is another matter."""
    if material.transmission == 1 and material.roughness == 0:
        return schlick_glass(nodes, material.ior), False
    base = color(nodes, scene, material.base_texture, material.base_color, folder)
    if material.metallic == 1:
        shader = nodes.node(
    "ShaderNodeBsdfGlossy", {
        "Color": base, "Roughness": material.roughness}, distribution="GGX")
    elif material.metallic == 0 and material.ior == 1:
        shader = nodes.node("ShaderNodeBsdfDiffuse", {"Color": base, "Roughness": 0.0})
    else:
        raise SystemExit(f"{material.name}: only Lambert surfaces, metals and ideal glass are exported to Cycles")
    result = shader.outputs[0]
    if material.emission.max() > 0:
        emission = color(nodes, scene, material.emission_texture, material.emission, folder)
        light = nodes.node("ShaderNodeEmission", {"Color": emission, "Strength": 1.0}).outputs[0]
        result = nodes.node("ShaderNodeAddShader", {0: result, 1: light}).outputs[0]
    return result, not material.two_sided


def make_material(scene, index, folder):
    source = scene.materials[index]
    material = bpy.data.materials.new(source.name)
    material.use_nodes = True
    nodes = Nodes(material.node_tree)
    shader, one_sided = surface(nodes, scene, source, folder)
    if one_sided:
        black = nodes.node("ShaderNodeBsdfDiffuse", {"Color": (0, 0, 0, 1)}).outputs[0]
        shader = nodes.mix(nodes.geometry("Backfacing"), shader, black)
    if source.alpha_cutoff is not None and source.base_texture is not None:
        alpha = image_node(nodes, scene, source.base_texture, folder).outputs["Alpha"]
        solid = nodes.math("GREATER_THAN", alpha, source.alpha_cutoff / source.base_color[3])
        shader = nodes.mix(solid, nodes.node("ShaderNodeBsdfTransparent").outputs[0], shader)
    nodes.node("ShaderNodeOutputMaterial", {"Surface": shader})
    return material


def make_mesh(source, material):
    positions = source.positions @ np.array(TO_BLENDER)[:3, :3].T
    mesh = bpy.data.meshes.new(source.name)
    mesh.from_pydata(positions.tolist(), [], source.triangles.tolist())
    if source.uv is not None:
        layer = mesh.uv_layers.new()
        uv = source.uv[source.triangles.ravel()] * (1, -1) + (0, 1)
        layer.data.foreach_set("uv", uv.astype(np.float32).ravel())
    mesh.materials.append(material)
    holder = bpy.data.objects.new(source.name, mesh)
    bpy.context.scene.collection.objects.link(holder)
    return holder


def rectangle(mesh):
    """Corner and two sides of two triangles that make up a rectangle, front: u x v; None for other meshes."""
    if len(mesh.triangles) != 2:
        return None
    corners = mesh.positions[mesh.triangles].astype(np.float64)
    a, b, c = corners[0]
    for origin, p, q in ((a, b, c), (b, c, a), (c, a, b)):
        u, v = p - origin, q - origin
        far = np.linalg.norm(corners[1] - (p + v), axis=1).min()
        if abs(u @ v) < 1e-5 * np.linalg.norm(u) * np.linalg.norm(v) and far < 1e-5 * np.linalg.norm(u + v):
            return origin, u, v
    return None


def make_rectangle_light(name, corner, u, v, radiance):
    """Cycles' own area light: of lamps that are meshes it takes samples with too little light
    (docs/measurements/validation.md)."""
    light = bpy.data.lights.new(name, "AREA")
    light.shape, light.size, light.size_y = "RECTANGLE", np.linalg.norm(u), np.linalg.norm(v)
    largest = float(radiance.max())
    light.color = [float(x) / largest for x in radiance]
    light.energy = 4 * largest * light.size * light.size_y
    axes = TO_BLENDER.to_3x3() @ mathutils.Matrix([(x / np.linalg.norm(x)).tolist()
                             for x in (u, -v, -np.cross(u, v))]).transposed()
    holder = bpy.data.objects.new(name, light)
    holder.matrix_world = mathutils.Matrix.Translation(
        TO_BLENDER.to_3x3() @ mathutils.Vector(corner + 0.5 * (u + v))) @ axes.to_4x4()
    bpy.context.scene.collection.objects.link(holder)


def show_to_camera_only(holder):
    """For what area lights leave out: the camera does not see them."""
    holder.visible_diffuse = holder.visible_glossy = holder.visible_transmission = holder.visible_shadow = False
    for material in holder.data.materials:
        material.cycles.sample_as_light = False


def is_plain_lamp(material):
    return JOB["area_lights"] and material.emission.max(
    ) > 0 and material.emission_texture is None and max(material.base_color[:3]) == 0


def spot_ramp(light):
    """The squared ramp of KHR_lights_punctual on a point light of the same intensity: Cycles' own spot has another."""
    outer = np.cos(light.outer)
    scale = 1 / max(np.cos(light.inner) - outer, 0.001)
    return scale, -outer * scale


def make_light(index, source):
    name, largest = f"light{index}", float(source.intensity.max())
    kind = "SUN" if source.kind == "directional" else "POINT"
    light = bpy.data.lights.new(name, kind)
    light.color = [float(x) / largest for x in source.intensity]
    light.energy = largest if kind == "SUN" else 4 * np.pi * largest
    light.use_nodes = True
    nodes = Nodes(light.node_tree)
    strength = 1.0
    if kind == "SUN":
        light.angle = 0
    else:
        light.shadow_soft_size = 0
    if source.kind == "spot":
        scale, offset = spot_ramp(source)
        normal = nodes.node("ShaderNodeTexCoord").outputs["Normal"]
        z = nodes.node("ShaderNodeSeparateXYZ", {0: normal}).outputs[2]
        ramp = nodes.math("MULTIPLY_ADD", z, -scale, offset, clamp=True)
        strength = nodes.math("MULTIPLY", ramp, ramp)
    emission = nodes.node("ShaderNodeEmission", {"Color": (1, 1, 1, 1), "Strength": strength})
    nodes.node("ShaderNodeOutputLight", {"Surface": emission.outputs[0]})
    holder = bpy.data.objects.new(name, light)
    direction = TO_BLENDER.to_3x3() @ mathutils.Vector(source.direction)
    rotation = direction.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    holder.matrix_world = mathutils.Matrix.Translation(
        TO_BLENDER.to_3x3() @ mathutils.Vector(source.position)) @ rotation
    bpy.context.scene.collection.objects.link(holder)


def make_world(environment):
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes = Nodes(world.node_tree)
    if environment is None:
        picture = (0, 0, 0, 1)
    elif environment.radiance is not None:
        picture = (*environment.radiance.tolist(), 1.0)
    else:
        # Blender looks up u = 1/2 - atan2(y, x) / 2 pi, y = -z of glTF: the same picture up to its own rotation.
        direction = nodes.node("ShaderNodeTexCoord").outputs["Generated"]
        turned = nodes.node("ShaderNodeVectorRotate", {"Vector": direction, "Angle": -environment.rotation},
                            rotation_type="Z_AXIS").outputs[0]
        image = bpy.data.images.load(str(environment.file))
        picture = nodes.node(
    "ShaderNodeTexEnvironment", {
        "Vector": turned}, image=image, interpolation="Linear").outputs[0]
    background = nodes.node("ShaderNodeBackground", {"Color": picture, "Strength": 1.0})
    nodes.node("ShaderNodeOutputWorld", {"Surface": background.outputs[0]})
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = 1024


def make_camera(scene):
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit, camera.angle_y = "VERTICAL", scene.yfov
    camera.clip_start, camera.clip_end = 1e-3, 1e5
    holder = bpy.data.objects.new("camera", camera)
    matrix = TO_BLENDER @ mathutils.Matrix(scene.camera.tolist())
    holder.matrix_world = matrix.to_quaternion().to_matrix().to_4x4()
    holder.matrix_world.translation = matrix.translation
    bpy.context.scene.collection.objects.link(holder)
    bpy.context.scene.camera = holder


def settings():
    """Everything that would bias the image, or differ from a box filter, is off."""
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = *JOB["size"], 100
    render.threads_mode, render.threads = "FIXED", JOB["threads"]
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.color_mode = "RGB"
    render.use_persistent_data = True
    cycles.device, cycles.samples = "CPU", JOB["samples"]
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.light_sampling_threshold = 0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.sampling_pattern = "PROGRESSIVE_MULTI_JITTER"
    bounces = JOB["bounces"] if JOB["bounces"] >= 0 else 1024
    for name in ("max", "diffuse", "glossy", "transmission", "volume"):
        setattr(cycles, f"{name}_bounces", bounces)
    cycles.transparent_max_bounces = 1024
    cycles.caustics_reflective = cycles.caustics_refractive = True


def main():
    output = Path(JOB["output"])
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    scene = gltf.read(JOB["scene"])
    materials = [make_material(scene, i, output) for i in range(len(scene.materials))]
    for mesh in scene.meshes:
        holder = make_mesh(mesh, materials[mesh.material])
        sides = rectangle(mesh) if is_plain_lamp(scene.materials[mesh.material]) else None
        if sides is not None:
            show_to_camera_only(holder)
            make_rectangle_light(mesh.name, *sides, scene.materials[mesh.material].emission)
    for index, light in enumerate(scene.lights):
        make_light(index, light)
    make_world(scene.environment)
    make_camera(scene)
    settings()
    seconds, cpu_seconds = [], []
    for seed in JOB["seeds"]:
        bpy.context.scene.cycles.seed = seed
        bpy.context.scene.render.filepath = str(output / f"cycles{seed}.exr")
        start, start_cpu = time.time(), time.process_time()
        bpy.ops.render.render(write_still=True)
        seconds.append(time.time() - start)
        cpu_seconds.append(time.process_time() - start_cpu)
    (output / "cycles.json").write_text(json.dumps({"seconds": seconds, "cpu_seconds": cpu_seconds}))


main()
