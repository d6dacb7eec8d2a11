// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "lucarium/view/truth/error_history.h"
#include "lucarium/view/view_side.h"

namespace lucarium {

/// The truth while one watches: references of the light paths that the sides compute, and the errors of all that was
/// tried at this view.
class ViewTruth {
 public:
  ViewTruth(ViewSurroundings& around, const TechniqueRegistry& registry, std::function<bool()> unwanted);

  /// Another view: nothing of the one before is of use.
  void begin(std::shared_ptr<SceneOnDevice> scene);
  void begin() { begin(scene_); }
  void switch_to(bool on);
  /// Looks at a side that has worked: whose light paths are wanted, and whether its picture must be kept. Returns
  /// whether pages must hear something at once.
  bool watch(ViewSide& side);
  /// It begins again: its curve does, too.
  void forget(const ViewTechnique& technique) { history_.forget(technique); }
  bool is_on() const { return on_; }
  bool has_work() const;
  /// An iteration of the reference that has the fewest samples, or a measurement.
  void work();
  double spent() const { return spent_; }
  void catch_up(double spent) { spent_ = std::max(spent_, spent); }
  /// {"on", "obstacle", "references": [{"paths", "samples", "measured", "relmse"}], "curves"}
  nlohmann::ordered_json status() const;

 private:
  GrowingReference* next() const;
  std::string start(const PathSet& paths, const std::string& text);

  ViewSurroundings& around_;
  const TechniqueRegistry& registry_;
  std::function<bool()> unwanted_;
  std::shared_ptr<SceneOnDevice> scene_;
  bool on_ = false;
  double spent_ = 0;
  std::map<std::string, std::unique_ptr<GrowingReference>> references_;  ///< by light paths
  std::map<std::string, std::string> obstacles_;                         ///< by light paths
  std::string obstacle_;                                                 ///< of what a side shows
  ErrorHistory history_;
};

}  // namespace lucarium
