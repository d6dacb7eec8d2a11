// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/model/accessor.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace lucarium::gltf {

namespace {

/// One component as stored in memory to a number; normalized ones per glTF 2.0, section 3.11.
template <class Out, class Stored>
Out convert(Stored value, bool normalized) {
  if constexpr (std::is_floating_point_v<Out> && std::is_integral_v<Stored>) {
    if (normalized) {
      return std::max(static_cast<Out>(value) / static_cast<Out>(std::numeric_limits<Stored>::max()), Out(-1));
    }
  }
  return static_cast<Out>(value);
}

template <class Out, class Stored>
void copy_elements(std::string_view bytes, size_t stride, size_t count, int width, bool normalized, Out* out) {
  for (size_t i = 0; i < count; ++i) {
    for (int c = 0; c < width; ++c) {
      Stored value;  // may be unaligned
      std::memcpy(&value, bytes.data() + i * stride + static_cast<size_t>(c) * sizeof(Stored), sizeof(Stored));
      *out++ = convert<Out>(value, normalized);
    }
  }
}

template <class Out>
void copy_elements(int component_type, std::string_view bytes, size_t stride, size_t count, int width, bool normalized,
                   Out* out) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return copy_elements<Out, int8_t>(bytes, stride, count, width, normalized, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return copy_elements<Out, uint8_t>(bytes, stride, count, width, normalized, out);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return copy_elements<Out, int16_t>(bytes, stride, count, width, normalized, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return copy_elements<Out, uint16_t>(bytes, stride, count, width, normalized, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return copy_elements<Out, uint32_t>(bytes, stride, count, width, normalized, out);
    default: return copy_elements<Out, float>(bytes, stride, count, width, normalized, out);
  }
}

}  // namespace

int AccessorReader::width(int accessor) const {
  return tinygltf::GetNumComponentsInType(static_cast<uint32_t>(document_.model.accessors[accessor].type));
}

bool AccessorReader::is_unsigned_integer(int accessor) const {
  const int type = component_type(accessor);
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

template <class T>
std::vector<T> AccessorReader::read(int index, int expected_width, const std::string& where) {
  const tinygltf::Accessor& accessor = document_.model.accessors[index];
  const int components = width(index);
  if (expected_width && components != expected_width) {
    context_.fail("{}: /accessors/{} has {} components per element, not {}", where, index, components, expected_width);
  }
  if (accessor.type == TINYGLTF_TYPE_MAT2 || accessor.type == TINYGLTF_TYPE_MAT3) {
    context_.fail("{}: /accessors/{} holds matrices, which have no meaning there", where, index);
  }
  const uint64_t element = static_cast<uint64_t>(components) * sizeof(T);
  context_.spend_bytes(accessor.count > UINT64_MAX / element ? UINT64_MAX / 2 : accessor.count * element);
  std::vector<T> values(accessor.count * static_cast<size_t>(components));
  const size_t stored =
      static_cast<size_t>(components) *
      static_cast<size_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType)));
  if (accessor.bufferView != none) {
    const std::string_view bytes = view_bytes(document_, accessor.bufferView, where, context_);
    const size_t stride = document_.model.bufferViews[accessor.bufferView].byteStride;
    copy_elements(accessor.componentType, bytes.substr(accessor.byteOffset), stride ? stride : stored, accessor.count,
                  components, accessor.normalized, values.data());
  }
  if (!accessor.sparse.isSparse) return values;

  const auto& sparse = accessor.sparse;
  const size_t replaced = static_cast<size_t>(sparse.count);
  std::vector<uint32_t> targets(replaced);
  const std::string_view indices = view_bytes(document_, sparse.indices.bufferView, where, context_);
  const size_t index_size =
      static_cast<size_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(sparse.indices.componentType)));
  copy_elements(sparse.indices.componentType, indices.substr(static_cast<size_t>(sparse.indices.byteOffset)),
                index_size, replaced, 1, false, targets.data());
  const std::string_view contents = view_bytes(document_, sparse.values.bufferView, where, context_)
                                        .substr(static_cast<size_t>(sparse.values.byteOffset));
  for (size_t i = 0; i < replaced; ++i) {
    if (targets[i] >= accessor.count) {
      context_.fail("{}: /accessors/{}/sparse replaces element {} of {}", where, index, targets[i], accessor.count);
    }
    copy_elements(accessor.componentType, contents.substr(i * stored), stored, 1, components, accessor.normalized,
                  values.data() + static_cast<size_t>(targets[i]) * static_cast<size_t>(components));
  }
  return values;
}

std::vector<float> AccessorReader::floats(int accessor, int expected_width, const std::string& where) {
  std::vector<float> values = read<float>(accessor, expected_width, where);
  for (size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    context_.fail("{}: element {} of /accessors/{} is not finite", where, i / static_cast<size_t>(width(accessor)),
                  accessor);
  }
  return values;
}

std::vector<uint32_t> AccessorReader::integers(int accessor, int expected_width, const std::string& where) {
  if (!is_unsigned_integer(accessor)) {
    context_.fail("{}: /accessors/{} must hold unsigned integers", where, accessor);
  }
  return read<uint32_t>(accessor, expected_width, where);
}

namespace {

/// Regroups plain numbers as vectors or matrices.
template <class T>
std::vector<T> grouped(const std::vector<float>& values) {
  std::vector<T> result(values.size() * sizeof(float) / sizeof(T));
  if (!values.empty()) std::memcpy(static_cast<void*>(result.data()), values.data(), values.size() * sizeof(float));
  return result;
}

}  // namespace

std::vector<glm::vec2> AccessorReader::vec2(int accessor, const std::string& where) {
  return grouped<glm::vec2>(floats(accessor, 2, where));
}
std::vector<glm::vec3> AccessorReader::vec3(int accessor, const std::string& where) {
  return grouped<glm::vec3>(floats(accessor, 3, where));
}
std::vector<glm::vec4> AccessorReader::vec4(int accessor, const std::string& where) {
  return grouped<glm::vec4>(floats(accessor, 4, where));
}
std::vector<glm::mat4> AccessorReader::mat4(int accessor, const std::string& where) {
  if (component_type(accessor) != TINYGLTF_COMPONENT_TYPE_FLOAT ||
      document_.model.accessors[accessor].type != TINYGLTF_TYPE_MAT4) {
    context_.fail("{}: /accessors/{} must hold 4x4 matrices of floats", where, accessor);
  }
  return grouped<glm::mat4>(floats(accessor, 16, where));
}

}  // namespace lucarium::gltf
