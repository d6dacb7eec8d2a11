// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cfloat>
#include <string>
#include <vector>

#include "lucarium/base/json.h"
#include "lucarium/scene/gltf/document/context.h"

namespace lucarium::gltf {

using Json = nlohmann::json;

/// What one member of a JSON object must look like. A tree of these describes a document; gltf_rules.cpp holds
/// glTF's. Members without a rule are ignored; "name" and "extensions" are checked in every object.
struct Rule {
  enum class Kind {
    boolean,
    integer,
    number,
    text,
    choice,
    numbers,     ///< array of numbers
    index,       ///< into the array `target`
    indices,     ///< array of those
    index_map,   ///< object of those (vertex attributes)
    index_maps,  ///< array of those objects (morph targets)
    object,
    objects,
    texts
  };

  std::string key;
  Kind kind = Kind::object;
  bool required = false;
  double min = -FLT_MAX, max = FLT_MAX;  ///< of numbers
  size_t length = 0;                     ///< exact length of `numbers`; 0: any
  std::string target;                    ///< JSON pointer of the array that an index points into
  std::vector<Json> choices;
  std::vector<Rule> members;

  /// A copy that must be present.
  Rule needed() const {
    Rule copy = *this;
    copy.required = true;
    return copy;
  }
};

/// Checks `root` against `rules`: JSON types, lengths, ranges, references. Numbers that stand for integers but are
/// written as 3.0 become integers. Throws Error{input} with the JSON pointer of the first fault; empty arrays, which
/// glTF forbids but exporters write, become warnings.
void check_json(Json& root, const std::vector<Rule>& rules, ImportContext& context);

/// The rules of glTF 2.0 and of the extensions that are read.
const std::vector<Rule>& gltf_rules();

/// Parses text that may be hostile: nesting is limited before anything recursive sees it.
Json parse_json(std::string_view text, const ImportContext& context);

}  // namespace lucarium::gltf
