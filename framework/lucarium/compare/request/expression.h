// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace lucarium {

/// What an expression may use: numbers by name, and functions of one number.
struct ExpressionScope {
  std::map<std::string, double> numbers;
  std::map<std::string, std::function<double(double)>> functions;
};

/// The value of an arithmetic expression ("1000*iterate_seconds/samples < 12"; a comparison is 1 or 0; muParser's
/// syntax). NaN when a name is not in the scope, or NaN there: what compares with it says nothing. Throws Error{input}
/// when it cannot be parsed.
double evaluate_expression(const std::string& expression, const ExpressionScope& scope);

/// The names that an expression uses, functions aside. Throws Error{input} when it cannot be parsed.
std::vector<std::string> expression_names(const std::string& expression);

bool is_expression_name(const std::string& name);

/// A label as a part of a name in expressions: what is neither letter nor digit becomes _.
std::string expression_name(std::string label);

}  // namespace lucarium
