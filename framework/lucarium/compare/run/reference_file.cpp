// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/run/reference_file.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/film/image_io.h"
#include "lucarium/services/path_set.h"

namespace lucarium {
namespace fs = std::filesystem;

namespace {

/// Complains when the header of an image says that it shows other light paths or another scene. An image from elsewhere
/// says nothing and is taken at its user's word.
void check_reference(const Film& film, const fs::path& file, const ReferenceResult& wanted, const SceneResult& scene) {
  const auto path_set = film.metadata.find("path_set"), hash = film.metadata.find("scene_hash");
  if (hash != film.metadata.end() && hash->second != scene.hash) {
    throw_error(ErrorClass::usage, "{} shows another scene than {}, or another version of it", file.string(),
                scene.name);
  }
  if (path_set == film.metadata.end() || wanted.is_for(path_set->second)) return;
  std::string text;
  for (const std::string& line : PathSet::parse(path_set->second).differences(PathSet::parse(wanted.path_set))) {
    text += (text.empty() ? "" : "; ") + line;
  }
  throw_error(ErrorClass::usage,
              "{} shows other light paths than the technique computes ({}); omit --reference to render the right one",
              file.string(), text);
}

}  // namespace

void check_one_reference(const SceneResult& scene) {
  if (scene.references.size() <= 1) return;
  throw_error(ErrorClass::usage,
              "the techniques compute {} different sets of light paths; one --reference file cannot match them all",
              scene.references.size());
}

Film read_reference_file(const ComparisonSpec& spec, const SceneResult& scene, const ReferenceResult& wanted) {
  const fs::path& file = *spec.reference.file;
  Film film = read_reference_image(file);
  const SceneSettings own = spec.settings_of(spec.scenes.front());  // a file is for one scene only
  if (film.width() != own.width || film.height() != own.height) {
    throw_error(ErrorClass::input, "{} is {}×{}, the comparison {}×{}; give --size {}x{}", file.string(), film.width(),
                film.height(), own.width, own.height, film.width(), film.height());
  }
  check_reference(film, file, wanted, scene);
  return film;
}

}  // namespace lucarium
