// SPDX-License-Identifier: Apache-2.0
// lucarium report. Declared in commands.h.
#include "commands/commands.h"
#include "lucarium/base/json.h"
#include "lucarium/base/terminal.h"
#include "lucarium/compare/report/report_page.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

int report(const fs::path& folder, const ReportOptions& options, const Messages& messages) {
  write_report(folder, options);
  const std::string page = (folder / "report.html").string();
  if (messages.json) {
    const nlohmann::ordered_json json = {{"schema", "lucarium-report-1"}, {"file", page}};
    print_result("{}\n", json.dump(2));
  } else {
    print_result("report: {}\n", page);
  }
  return 0;
}

}  // namespace

void add_report_command(Command program, Action& action) {
  struct ReportArguments {
    fs::path folder;
    ReportOptions options;
  };
  auto arguments = std::make_shared<ReportArguments>();
  Command command = program.add_subcommand("report", "write report.html again from the results in a folder");
  command.option("folder", arguments->folder).required();
  command.flag("--link-images", arguments->options.link_images);
  command.examples({"lucarium report results", "lucarium report results --link-images"}, "docs/report.md");
  command.callback([arguments, &action] {
    action = [arguments](const Messages& messages) { return report(arguments->folder, arguments->options, messages); };
  });
}

}  // namespace lucarium::app
