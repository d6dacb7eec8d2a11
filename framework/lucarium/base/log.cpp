// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "lucarium/base/terminal.h"

namespace lucarium {
namespace {

spdlog::logger& logger() {
  static const auto instance = [] {
    auto created = std::make_shared<spdlog::logger>("lucarium", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    created->set_pattern("%v");
    created->set_level(spdlog::level::trace);
    return created;
  }();
  return *instance;
}

LogLevel current_level = LogLevel::warning;

}  // namespace

void set_log_level(LogLevel level) { current_level = level; }
LogLevel log_level() { return current_level; }

void log_message(LogLevel level, std::string_view text) {
  if (level > current_level) return;
  // Errors and warnings are one line, whatever names they hold; details may be build logs of many.
  switch (level) {
    case LogLevel::error: logger().error("lucarium: {}", printable_line(text)); break;
    case LogLevel::warning: logger().warn("lucarium: warning: {}", printable_line(text)); break;
    case LogLevel::info: logger().info("{}", printable(text)); break;
    case LogLevel::debug: logger().debug("{}", printable(text)); break;
  }
}

}  // namespace lucarium
