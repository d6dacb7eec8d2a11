// SPDX-License-Identifier: Apache-2.0
// What pages ask for: JSON, one object a message.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lucarium/scene/camera_path.h"
#include "lucarium/view/edits/scene_edits.h"

namespace lucarium {

inline constexpr size_t largest_view_message = 16384;  ///< [bytes]
/// Techniques that render at once.
inline constexpr uint32_t view_sides = 2;

/// A message, by its member "do":
///
///   {"do": "shown", "picture": N}                            the picture is on the screen: the next one may come
///   {"do": "control"}                                        this page wants to control, others watch
///   {"do": "camera", "eye": [x, y, z], "target": [x, y, z], "vfov": degrees}
///   {"do": "scene_camera", "index": I}                       one of the scene's cameras
///   {"do": "technique", "name": NAME, "parameters": [[KEY, VALUE], …], "side": 0 | 1}
///                                                            "side" may be left out: 0
///   {"do": "beside", "as": "none" | "pictures" | "flip"}     a second side renders; FLIP of the two is wanted, too
///   {"do": "layer", "name": NAME}                            "": the image
///   {"do": "inspect", "x": N, "y": N}                        what is at that pixel of the whole size
///   {"do": "reference", "on": true | false}                  one grows, and errors are measured
///   {"do": "scene", "lights": [TEXT, …] | null, "materials": [TEXT, …], "environment": TEXT}
///                                                            edits, as on the command line; null, "": the scene's own
///   {"do": "time", "seconds": T}                             of the animation
///   {"do": "pause", "on": true | false}
///   {"do": "restart"}                                        from the first sample
///   {"do": "save", "kind": "exr" | "png", "exposure": STOPS} answered with a file
///
/// Each may have "id": N; the answer to it then says {"answer": N}, with "error" where it was refused.
struct ViewMessage {
  enum class Kind {
    shown,
    control,
    camera,
    scene_camera,
    technique,
    beside,
    layer,
    inspect,
    reference,
    scene,
    time,
    pause,
    restart,
    save
  };
  Kind kind = Kind::control;
  std::optional<int64_t> id;
  uint64_t picture = 0;
  CameraKey camera;
  uint32_t index = 0;  ///< of a camera, a side
  std::string name;    ///< of a technique, a layer, a kind of file, a way to compare
  std::vector<std::pair<std::string, std::string>> parameters;
  bool on = false;
  float exposure = 0;  ///< [stops]
  uint32_t x = 0, y = 0;
  SceneEdits edits;
};

/// Throws Error{usage} that says what is wrong: no JSON, an unknown word, a member that is missing, of another type or
/// out of range, or one too many.
ViewMessage parse_view_message(std::string_view text);

/// Its "id" where it can be read, for the answer to a message that is refused.
std::optional<int64_t> view_message_id(std::string_view text);

}  // namespace lucarium
