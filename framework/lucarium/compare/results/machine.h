// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace lucarium {

/// What a processor, a memory and a system are called; nothing that identifies the machine.
struct Machine {
  std::string cpu, system;
  unsigned logical_cores = 0;
  uint64_t memory_bytes = 0;
  bool operator==(const Machine&) const = default;
};
Machine describe_machine();

/// Where one piece ran, and what else ran there.
struct PieceMachine {
  Machine machine;
  std::string device_index;            ///< of --devices; empty: the device that the comparison states
  double load = 0;                     ///< of the machine when the piece began: processes that run or wait, last minute
  std::optional<unsigned> other_jobs;  ///< beside it when it began: pieces of this comparison, jobs of the scheduler
};

/// This machine, now.
PieceMachine describe_piece_machine();

nlohmann::ordered_json machine_json(const Machine& machine);
nlohmann::ordered_json piece_machine_json(const PieceMachine& machine);
/// Inverse of piece_machine_json(); throws nlohmann::json::exception.
PieceMachine read_piece_machine(const nlohmann::json& json);

}  // namespace lucarium
