// SPDX-License-Identifier: Apache-2.0
// The page is framework/lucarium/view/page/* with modules of the report's, embedded at build time.
#include "lucarium/view/page_files.h"

#include <map>

#include "lucarium/base/files/embedded_page.h"

const lucarium::EmbeddedSources& lucarium_report_assets();
const lucarium::EmbeddedSources& lucarium_view_assets();

namespace lucarium {

const PageFile& view_page_file(std::string_view name) {
  static const auto assembled = [](const char* file) {
    return assemble_page(lucarium_view_assets().at(file), {&lucarium_view_assets(), &lucarium_report_assets()});
  };
  static const std::map<std::string, PageFile, std::less<>> files = {
      {"", {"text/html; charset=utf-8", assembled("view.html")}},
      {"view.js", {"text/javascript; charset=utf-8", assembled("view.js")}},
      {"view.css", {"text/css; charset=utf-8", assembled("view.css")}}};
  static const PageFile nothing;
  const auto found = files.find(name);
  return found == files.end() ? nothing : found->second;
}

}  // namespace lucarium
