// SPDX-License-Identifier: Apache-2.0
// Reads the events of finished runs into a profile: internal to compute/.
#pragma once
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "lucarium/compute/schedule/profile.h"
#include "lucarium/compute/schedule/schedule_run.h"

namespace lucarium {

/// Holds runs that may still be on the device, oldest first, and sums up those that have ended.
class RunLog {
 public:
  RunLog();

  /// `keep`: whether the run counts in the profile; what it took is noted in the schedule's
  /// facts in any case.
  void add(Schedule::State& schedule, RunRecord record, bool keep);
  /// Waits for the oldest runs until at most `count` are left. Throws Error{device} that names
  /// the pass when a command had failed.
  void retire(size_t count, ApiCalls& calls);
  size_t waiting() const { return waiting_.size(); }
  /// Forgets them after a failure; the device must be idle.
  void drop() { waiting_.clear(); }

  const Profile& profile() const { return profile_; }
  void add_wall_seconds(double seconds) { profile_.wall_seconds += seconds; }
  void reset();

 private:
  struct Waiting {
    RunRecord record;
    std::shared_ptr<Device> device;
    std::shared_ptr<ScheduleFacts> facts;
    std::shared_ptr<std::vector<int>> slots;  ///< null: not profiled
    uint64_t run = 0;
  };
  void assign_slots(Schedule::State& schedule);
  [[noreturn]] static void report_failure(const Waiting& run, cl_int code);
  void sum_up(const Waiting& run);

  uint64_t id_;  ///< of the present profile
  Profile profile_;
  std::map<std::tuple<std::string, std::string, std::string>, int> index_;  ///< (schedule, pass, kernel) → pass
  std::deque<Waiting> waiting_;
};

}  // namespace lucarium
