// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/base/child_process.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/compare/run/comparison.h"
#include "lucarium/compare/run/comparison_plan.h"

namespace lucarium {

/// State of one comparison in progress: run_comparison() drives it.
class ComparisonRunner {
 public:
  ComparisonRunner(const ComparisonSpec& spec, const TechniqueRegistry& registry, const ComparisonOptions& options);
  ComparisonResult run();

 private:
  // The result folder.
  void check_folder() const;
  void prepare_folder();
  void save();
  void write_page();
  bool page_is_due() const;

  // References.
  void get_references(size_t scene);
  void choose_exposure(size_t scene);
  bool keep_reference(size_t scene, size_t index);
  bool render_reference(size_t scene, size_t index);
  bool render_walk_references(size_t scene, size_t index);
  /// The reference of a job, in the cache afterwards; nothing when interrupted.
  std::optional<ChildResult> render_into_cache(const Job& job, const std::filesystem::path& cached);
  Job reference_job(size_t scene, size_t index) const;
  void check_reference_file() const;
  void measure_reference(ReferenceResult& reference);

  // Pieces.
  void load_finished_pieces();
  bool load_finished_piece(PieceResult& piece);
  bool run_missing_pieces();
  PieceResult run_piece(size_t scene, size_t variant, size_t budget, uint32_t seed);
  void add_piece(PieceResult piece);
  void add_warnings(const PieceResult& piece);
  bool drop_unlike_pieces(const PieceResult& piece);
  bool is_wanted(size_t scene, size_t variant) const;
  bool is_finished(const SummaryKey& key, uint32_t seed) const;
  const ReferenceResult& reference_of(size_t scene, size_t variant) const;
  void log_result(const PieceResult& piece, size_t number, size_t total) const;

  void update_conclusions();
  void say(const std::string& line) const;

  ComparisonSpec spec_;
  const TechniqueRegistry& registry_;
  ComparisonOptions options_;
  ComparisonResult result_;
  ImagePairs image_pairs_;  ///< that an experiment compares
  std::vector<ScenePlan> plans_;
  std::vector<SummaryKey> changed_;  ///< summaries that miss the newest pieces
  std::optional<Stopwatch> page_age_;
  double page_seconds_ = 0;  ///< what the last page took
};

}  // namespace lucarium
