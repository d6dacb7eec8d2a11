// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/gltf/model/mesh.h"

namespace lucarium::gltf {

/// One node per glTF node, at the same index, with in_scene set for those below the roots of the chosen scene.
/// Throws where options.gltf_scene does not exist.
void import_nodes(const Document& document, Scene& scene, ImportContext& context);

/// Materials that primitives of visible nodes use, one flag per glTF material.
std::vector<bool> used_materials(const Document& document, const Scene& scene);

/// Meshes, instances, skins; EXT_mesh_gpu_instancing appends nodes.
void import_instances(const Document& document, Scene& scene, ImportContext& context);

/// Lights and cameras of visible nodes.
void import_lights(const Document& document, Scene& scene, ImportContext& context);
void import_cameras(const Document& document, Scene& scene, ImportContext& context);

}  // namespace lucarium::gltf
