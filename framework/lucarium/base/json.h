// SPDX-License-Identifier: Apache-2.0
// nlohmann/json with its parser and its writer compiled once, in json.cpp: they are a fifth of the compile time of a
// source that parses or writes a document. Headers in which a declaration will do include nlohmann/json_fwd.hpp.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace lucarium {

/// What nlohmann's parser reads a std::string through.
using JsonTextInput = decltype(nlohmann::detail::input_adapter(std::declval<const std::string&>()));

}  // namespace lucarium

#define LUCARIUM_JSON_TEMPLATES(prefix, Json)                                    \
  prefix template class nlohmann::detail::lexer<Json, lucarium::JsonTextInput>;  \
  prefix template class nlohmann::detail::parser<Json, lucarium::JsonTextInput>; \
  prefix template class nlohmann::detail::json_sax_dom_parser<Json>;             \
  prefix template class nlohmann::detail::json_sax_dom_callback_parser<Json>;    \
  prefix template class nlohmann::detail::serializer<Json>;
LUCARIUM_JSON_TEMPLATES(extern, nlohmann::json)
LUCARIUM_JSON_TEMPLATES(extern, nlohmann::ordered_json)
