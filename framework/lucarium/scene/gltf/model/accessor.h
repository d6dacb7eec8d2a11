// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "lucarium/scene/gltf/document/document.h"

namespace lucarium::gltf {

/// Reads checked accessors: strided, sparse, without a buffer view (zeros), normalized or not. `where` names the user
/// in messages ("mesh 3 'wall', primitive 0, POSITION").
class AccessorReader {
 public:
  AccessorReader(const Document& document, ImportContext& context) : document_(document), context_(context) {}

  /// Components per element.
  int width(int accessor) const;
  size_t count(int accessor) const { return document_.model.accessors[accessor].count; }
  int component_type(int accessor) const { return document_.model.accessors[accessor].componentType; }

  /// count × width numbers; normalized integers become numbers from 0 or -1 to 1 (glTF 2.0, section 3.11). Refuses
  /// anything that is not finite, and elements that are not `expected_width` wide (0: any).
  std::vector<float> floats(int accessor, int expected_width, const std::string& where);
  std::vector<glm::vec2> vec2(int accessor, const std::string& where);
  std::vector<glm::vec3> vec3(int accessor, const std::string& where);
  std::vector<glm::vec4> vec4(int accessor, const std::string& where);
  std::vector<glm::mat4> mat4(int accessor, const std::string& where);

  /// count × width unsigned integers; refuses floating-point and signed components.
  std::vector<uint32_t> integers(int accessor, int expected_width, const std::string& where);

  bool is_unsigned_integer(int accessor) const;

 private:
  template <class T>
  std::vector<T> read(int accessor, int expected_width, const std::string& where);

  const Document& document_;
  ImportContext& context_;
};

}  // namespace lucarium::gltf
