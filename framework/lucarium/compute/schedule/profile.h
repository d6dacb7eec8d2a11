// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace lucarium {

/// One execution of one pass on the device's clock.
struct PassEvent {
  int pass = 0;      ///< index into Profile::passes
  uint64_t run = 0;  ///< which run of which schedule
  uint64_t queued_ns = 0, started_ns = 0, ended_ns = 0;
};

/// Sums over all runs of one pass.
struct PassProfile {
  std::string schedule, name, kernel;
  uint64_t count = 0;
  double device_seconds = 0;  ///< of host steps: on the host
  double launch_seconds = 0;  ///< from enqueued, or the device free, to started
  double bytes = 0;           ///< as declared by moves_bytes()
};

/// Where the time went. Overlapping passes are listed, never summed into a wall time; gaps show in wall_seconds.
struct Profile {
  std::vector<PassProfile> passes;
  std::vector<PassEvent> events;  ///< kept up to a limit; the sums go on
  double wall_seconds = 0;        ///< host wall time inside run()
  uint64_t runs = 0;

  std::string table() const;         ///< for people, sorted by device time, with each pass' share of it
  std::string json() const;          ///< seconds and bytes in the key names
  std::string chrome_trace() const;  ///< chrome://tracing, Perfetto
};

}  // namespace lucarium
