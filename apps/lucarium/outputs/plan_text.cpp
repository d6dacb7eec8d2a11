// SPDX-License-Identifier: Apache-2.0
#include "outputs/plan_text.h"

#include "lucarium/base/json.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/text_values.h"

namespace lucarium::app {

void print_plans(const std::vector<std::pair<std::string, std::string>>& plans, bool json) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& [name, text] : plans) {
    std::vector<std::string> lines = split(text, '\n');
    if (!lines.empty() && lines.back().empty()) lines.pop_back();
    list.push_back({{"name", name}, {"lines", lines}});
    if (!json) print_result("{}{}", plans.size() > 1 ? name + "\n" : "", text);
  }
  if (json) print_result("{}\n", nlohmann::ordered_json{{"schema", "lucarium-plan-1"}, {"plans", list}}.dump(2));
}

}  // namespace lucarium::app
