// SPDX-License-Identifier: Apache-2.0
// The page is framework/lucarium/compare/report/page/*, embedded at build time together with the plotting library;
// page.html names the files to include. Here the results and images are filled in.
#include "lucarium/compare/report/report_page.h"

#include <OpenImageIO/strutil.h>
#include <fmt/format.h>

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/embedded_page.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/report/report_images.h"
#include "lucarium/compare/results/result_folder.h"

const lucarium::EmbeddedSources& lucarium_report_assets();

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

constexpr const char* schema = "lucarium-results-2";
constexpr double largest_page = 145e6;  // [bytes], with a little room below the promised 150 MB
constexpr const char* image_folder = "report_images";

/// JSON inside a <script> element: "<" never stands alone there, so no text can end or comment out the element.
std::string script_safe(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  return safe;
}

ordered_json read_results(const fs::path& file) {
  ordered_json results;
  try {
    results = ordered_json::parse(read_file(file));
  } catch (const ordered_json::exception& error) {
    throw_error(ErrorClass::input, "{}: {}", file.string(), error.what());
  }
  const std::string found = results.is_object() ? results.value("schema", "") : "";
  if (found != schema) {
    throw_error(ErrorClass::input, "{}: schema is '{}', but reports are made from '{}'; run the comparison again",
                file.string(), found, schema);
  }
  return results;
}

/// Where the images go: into the page, or beside it as scripts, which unlike data a page opened from a disk may load.
class ImageWriter {
 public:
  ImageWriter(fs::path folder, bool link) : folder_(std::move(folder)), link_(link) {
    remove_written_files(folder_);
    if (link_) fs::create_directories(folder_);
  }

  void add(ordered_json entry, const std::string& data) {
    const size_t id = list_.size();
    const std::string text = OIIO::Strutil::base64_encode(data);
    if (link_) {
      const std::string name = fmt::format("{}.js", id);
      write_file_atomically(folder_ / name, fmt::format("receiveImage({},\"{}\");\n", id, text));
      entry["file"] = fmt::format("{}/{}", image_folder, name);
    } else {
      elements_ += fmt::format("<script type=\"text/plain\" id=\"image-{}\">{}</script>\n", id, text);
    }
    list_.push_back(std::move(entry));
  }

  const ordered_json& list() const { return list_; }
  const std::string& elements() const { return elements_; }

 private:
  fs::path folder_;
  bool link_;
  ordered_json list_ = ordered_json::array();
  std::string elements_;
};

void substitute(std::string& page, std::string_view marker, const std::string& text) {
  page.replace(page.find(marker), marker.size(), text);
}

}  // namespace

void write_report(const fs::path& folder, const ReportOptions& options) {
  const ordered_json results = read_results(folder / "results.json");
  std::string page = assemble_page(lucarium_report_assets().at("page.html"), {&lucarium_report_assets()});
  const std::string results_text = script_safe(results.dump());

  const std::vector<ReportSource> sources = list_report_sources(results, folder);
  // Base64 makes four bytes of three.
  const double room = largest_page - static_cast<double>(page.size() + results_text.size()) -
                      400.0 * static_cast<double>(sources.size() * 8);
  const ReportPlan plan = plan_report_images(sources, options.link_images ? 0 : std::max(0.75 * room, 1.0));
  ImageWriter images(folder / image_folder, options.link_images);
  pack_report_images(sources, plan,
                     [&](ordered_json entry, const std::string& data) { images.add(std::move(entry), data); });

  substitute(page, "@images@", images.elements());
  substitute(page, "@image_list@",
             script_safe(ordered_json{{"notes", plan.notes()}, {"images", images.list()}}.dump()));
  substitute(page, "@results@", results_text);
  write_file_atomically(folder / "report.html", page);
}

}  // namespace lucarium
