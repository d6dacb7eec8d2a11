// SPDX-License-Identifier: Apache-2.0
// libFuzzer target: any bytes are imported and evaluated, or refused with Error{input}; anything else is a bug.
#include "lucarium/base/error.h"
#include "lucarium/scene/gltf/import.h"
#include "lucarium/scene/import_options.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  lucarium::ImportOptions options;
  options.max_triangles = 100'000;
  options.max_image_pixels = 1u << 18;
  options.max_texture_size = 64;
  try {
    const std::string_view bytes(reinterpret_cast<const char*>(data), size);
    lucarium::Scene scene = lucarium::import_gltf_bytes(bytes, "/nonexistent", "fuzz.gltf", options);
    lucarium::evaluate(scene, 0.3);
    (void)scene.bounds();
  } catch (const lucarium::Error& error) {
    if (error.error_class() != lucarium::ErrorClass::input) __builtin_trap();
  }
  return 0;
}
