// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <unordered_set>

namespace lucarium {

/// The identifiers and numbers in `source`, those in comments and strings too.
std::unordered_set<std::string_view> identifiers_of(std::string_view source);

/// Those of `defines` that may change what `sources` mean: their names stand there or in the value of another define,
/// or ## can make them of what stands there.
std::map<std::string, std::string> named_defines(const std::map<std::string, std::string>& defines,
                                                 std::string_view sources);

}  // namespace lucarium
