// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/request/expression.h"

#include <muParser.h>

#include <cctype>
#include <cmath>

#include "lucarium/base/error.h"

namespace lucarium {
namespace {

/// Functions of results (reproduction.cpp) that must be known to find out which names an expression uses.
const char* const result_functions[] = {"seconds_to", "relmse_at"};

double call_function(void* function, double argument) {
  return (*static_cast<const std::function<double(double)>*>(function))(argument);
}

[[noreturn]] void fail(const std::string& expression, const mu::Parser::exception_type& error) {
  throw_error(ErrorClass::input, "'{}': {}", expression, error.GetMsg());
}

}  // namespace

bool is_expression_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  for (const char c : name) {
    if (!letter(c) && !(c >= '0' && c <= '9')) return false;
  }
  return !name.empty() && letter(name.front());
}

std::string expression_name(std::string label) {
  for (char& c : label) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return label;
}

std::vector<std::string> expression_names(const std::string& expression) {
  try {
    mu::Parser parser;
    const std::function<double(double)> nothing = [](double) { return 0.0; };
    for (const char* name : result_functions) {
      parser.DefineFunUserData(name, call_function, const_cast<std::function<double(double)>*>(&nothing));
    }
    parser.SetExpr(expression);
    std::vector<std::string> names;
    for (const auto& [name, unused] : parser.GetUsedVar()) names.push_back(name);
    return names;
  } catch (const mu::Parser::exception_type& error) {
    fail(expression, error);
  }
}

double evaluate_expression(const std::string& expression, const ExpressionScope& scope) {
  for (const std::string& name : expression_names(expression)) {
    const auto found = scope.numbers.find(name);
    if (found == scope.numbers.end() || std::isnan(found->second)) return NAN;
  }
  try {
    mu::Parser parser;
    for (const auto& [name, number] : scope.numbers) parser.DefineConst(name, number);
    for (const auto& [name, function] : scope.functions) {
      parser.DefineFunUserData(name, call_function, const_cast<std::function<double(double)>*>(&function));
    }
    parser.SetExpr(expression);
    return parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    fail(expression, error);
  }
}

}  // namespace lucarium
