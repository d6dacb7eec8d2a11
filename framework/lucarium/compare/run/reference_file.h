// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compare/request/comparison_spec.h"
#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/film/film.h"

namespace lucarium {

/// Throws Error{usage} where the techniques of a scene need several references, for which one file cannot do.
void check_one_reference(const SceneResult& scene);

/// The image that spec.reference.file names. Throws Error{input} where it cannot be read or has another size,
/// Error{usage} where its header says that it shows another scene or other light paths.
Film read_reference_file(const ComparisonSpec& spec, const SceneResult& scene, const ReferenceResult& wanted);

}  // namespace lucarium
