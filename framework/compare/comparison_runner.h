// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "lucarium/compare/comparison.h"

namespace lucarium {

/// State of one comparison in progress: run_comparison() drives it.
class ComparisonRunner {
 public:
  ComparisonRunner(const ComparisonSpec& spec, const TechniqueRegistry& registry, const ComparisonOptions& options);
  ComparisonResult run();

 private:
  void check_folder() const;
  void prepare_folder();
  void plan_scene(size_t index);
  void get_reference(size_t index);
  /// Returns false when interrupted.
  bool render_reference(size_t index, const std::filesystem::path& target);
  PieceResult run_piece(size_t scene, size_t variant, uint32_t seed);
  void measure(PieceResult& piece);
  void save();
  void say(const std::string& line) const;
  std::vector<std::string> program_command(const char* name, size_t scene, uint64_t seed) const;
  std::filesystem::path piece_file(const PieceResult& piece, const char* extension) const;
  bool is_finished(size_t scene, size_t variant, uint32_t seed) const;
  void load_finished_pieces();
  bool load_finished_piece(PieceResult& piece);

  ComparisonSpec spec_;
  const TechniqueRegistry& registry_;
  ComparisonOptions options_;
  ComparisonResult result_;
  std::vector<Hash128> scene_hashes_;
  std::vector<std::string> path_sets_, reference_files_;
  std::vector<bool> needs_fallback_;
};

}  // namespace lucarium
