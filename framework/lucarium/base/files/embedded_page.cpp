// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/files/embedded_page.h"

#include "lucarium/base/error.h"

namespace lucarium {

namespace {

std::string_view find_asset(std::string_view name, const std::vector<const EmbeddedSources*>& assets) {
  for (const EmbeddedSources* set : assets) {
    if (const auto found = set->find(name); found != set->end()) return found->second;
  }
  throw_error(ErrorClass::internal, "a page includes {}, which is not embedded", name);
}

}  // namespace

std::string assemble_page(std::string_view source, const std::vector<const EmbeddedSources*>& assets) {
  const std::string_view opening = "@include ";
  std::string page;
  size_t at = 0;
  for (size_t begin; (begin = source.find(opening, at)) != std::string_view::npos;) {
    const size_t end = source.find('@', begin + 1);
    page += source.substr(at, begin - at);
    page += find_asset(source.substr(begin + opening.size(), end - begin - opening.size()), assets);
    at = end + 1;
  }
  return page.append(source.substr(at));
}

}  // namespace lucarium
