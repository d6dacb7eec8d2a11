// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/error.h"

#include <string_view>

namespace lucarium {

Error::Error(ErrorClass error_class, const std::string& message) : std::runtime_error(message), class_(error_class) {}

Error Error::with_context(std::string context) const {
  context += ": ";
  // A technique that names itself is named by its caller, too: once is enough.
  if (std::string_view(what()).starts_with(context)) return *this;
  Error outer(class_, context + what());
  outer.details_ = details_;
  return outer;
}

Error Error::with_details(std::string details) const {
  Error copy = *this;
  copy.details_ = std::move(details);
  return copy;
}

}  // namespace lucarium
