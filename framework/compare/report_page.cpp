// SPDX-License-Identifier: Apache-2.0
// One self-contained page: a table of what the summaries say, and the pictures.
#include "lucarium/compare/report_page.h"

#include <OpenImageIO/strutil.h>

#include <nlohmann/json.hpp>

#include "lucarium/base/atomic_file.h"
#include "lucarium/base/error.h"
#include "lucarium/film/image_io.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string escape(const std::string& text) {
  std::string html;
  for (const char c : text) {
    if (c == '&') html += "&amp;";
    else if (c == '<') html += "&lt;";
    else html += c;
  }
  return html;
}

std::string picture(const fs::path& file, const std::string& caption, float exposure) {
  const Film film = read_image(file);
  return fmt::format("<figure><img src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
                     OIIO::Strutil::base64_encode(encode_png(film.width(), film.height(), film.image(), exposure)), escape(caption));
}

}  // namespace

void write_report(const fs::path& folder, const ReportOptions&) {
  const fs::path file = folder / "results.json";
  try {
    const json results = json::parse(read_file(file));
    std::string page = "<!DOCTYPE html><html><meta charset=\"utf-8\"><title>Lucarium</title><body>\n";
    for (size_t scene = 0; scene < results.at("scenes").size(); ++scene) {
      const json& entry = results["scenes"][scene];
      page += fmt::format("<h2>{}</h2><table><tr><th>technique<th>budget<th>relMSE</tr>\n", escape(entry.at("name")));
      for (const json& summary : results.at("summaries")) {
        if (summary.at("scene") != scene) continue;
        page += fmt::format("<tr><td>{}<td>{}<td>{:.3g}</tr>\n", escape(results["variants"][summary.at("variant").get<size_t>()].at("label")),
                            escape(results["budgets"][summary.at("budget").get<size_t>()].at("label")),
                            summary.at("metrics").at("relMSE").at("mean").get<double>());
      }
      page += "</table>\n";
      for (const json& piece : results.at("pieces")) {
        if (piece.at("scene") != scene || piece.at("seed") != 1 || !piece.contains("image")) continue;
        page += picture(folder / piece["image"].get<std::string>(), results["variants"][piece.at("variant").get<size_t>()].at("label"),
                        entry.at("exposure_stops"));
      }
    }
    write_file_atomically(folder / "report.html", page + "</body></html>\n");
  } catch (const json::exception& error) {
    throw_error(ErrorClass::input, "{}: not a results file: {}", file.string(), error.what());
  }
}

}  // namespace lucarium
