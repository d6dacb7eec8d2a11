// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/base/files/file_state.h"
#include "lucarium/base/progress.h"
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
  /// Of results and page while pieces come: what they cost bounds how often.
  void save_when_due();
  void say_left_jobs() const;

  // References.
  /// One image of a reference that is not there yet.
  struct MissingImage {
    size_t scene = 0, index = 0;
    std::optional<size_t> walk_frame;  ///< index into the plan's; absent: the picture itself
    std::filesystem::path cached, image;
    FileState was_cached;  ///< before it was rendered or extended
  };
  /// Returns false when interrupted.
  bool get_references(PieceExecutor& executor);
  void read_reference(size_t scene, size_t index);
  void choose_exposure(size_t scene);
  bool keep_reference(size_t scene, size_t index);
  void find_missing(size_t scene, size_t index, std::vector<MissingImage>& missing);
  void remove_unusable(const MissingImage& image) const;
  void render_missing(std::vector<MissingImage>& missing, PieceExecutor& executor);
  PieceTask reference_task(const MissingImage& image) const;
  void keep_rendered(const MissingImage& image, const ChildResult& child);
  void finish_reference(size_t scene, size_t index);
  void fail_reference(size_t scene, size_t index, const Error& error);
  void check_reference_file() const;
  void measure_reference(ReferenceResult& reference);

  // Pieces.
  void load_finished_pieces();
  /// Whether a summary is of the scene, the light paths and the program of this comparison.
  bool fits(const nlohmann::json& summary, const PieceResult& piece) const;
  bool load_finished_piece(PieceResult& piece);
  /// Returns false when interrupted before all is done.
  bool run_missing_pieces();
  std::vector<PieceResult> missing_pieces(size_t& total) const;
  PieceTask piece_task(const PieceResult& piece) const;
  /// What its process left; or the reason why there is none.
  void finish_piece(PieceResult& piece, const PieceEnd& end);
  void add_piece(PieceResult piece);
  void add_warnings(const PieceResult& piece);
  void drop_unlike_pieces(const PieceResult& piece);
  bool is_wanted(size_t scene, size_t variant) const;
  const ReferenceResult& reference_of(size_t scene, size_t variant) const;
  void log_result(const PieceResult& piece, size_t number, size_t total) const;

  void update_conclusions();
  void warn_of_unlike_machines(size_t scene);
  void say(const std::string& line) const;
  /// One line that is drawn again and again.
  void show_progress(double fraction, const std::string& text);

  ComparisonSpec spec_;
  const TechniqueRegistry& registry_;
  ComparisonOptions options_;
  ComparisonResult result_;
  ImagePairs image_pairs_;  ///< that an experiment compares
  std::vector<ScenePlan> plans_;
  std::vector<SummaryKey> changed_;  ///< summaries that miss the newest pieces
  std::map<SummaryKey, int> drops_;  ///< how often pieces of one kind were dropped for another's parameters
  std::unique_ptr<PieceExecutor> executor_;
  std::unique_ptr<Progress> progress_;
  std::optional<Stopwatch> page_age_, save_age_;
  double page_seconds_ = 0, save_seconds_ = 0;  ///< what the last one took
};

}  // namespace lucarium
