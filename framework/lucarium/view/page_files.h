// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

namespace lucarium {

/// What the server has to give, by its name below the token: "" the page, "view.js", "view.css". Empty type: nothing.
struct PageFile {
  std::string type;  ///< Content-Type
  std::string text;
};
const PageFile& view_page_file(std::string_view name);

}  // namespace lucarium
