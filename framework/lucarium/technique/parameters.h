// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "lucarium/base/error.h"

namespace lucarium {

/// One parameter as people see it: in --help, JSON, docs and error messages.
struct ParameterInfo {
  std::string name, type, default_value, range, unit, doc;  ///< type: bool, int, float, enum
  std::vector<std::string> choices;                         ///< of an enum
  bool advanced = false;                                    ///< shown behind the others
};

/// Values that belong together, chosen by one name.
struct ParameterPreset {
  std::string name;
  std::vector<std::pair<std::string, std::string>> values;  ///< of other parameters; all others get their defaults
};

/// Text access to the parameters of one technique instance. Setting an unknown or out-of-range one throws Error{usage}
/// naming the nearest valid name or the range.
class ParameterTable {
 public:
  struct Entry {
    ParameterInfo info;
    std::function<std::string()> get;
    std::function<void(std::string_view)> set;
    std::vector<ParameterPreset> presets;  ///< of the parameter `preset`: setting it sets all others
  };
  const std::vector<Entry>& entries() const { return entries_; }
  void set(std::string_view name, std::string_view value);
  /// Several at once; `preset` first wherever it stands, so that the others change what it sets.
  void set_all(const std::vector<std::pair<std::string, std::string>>& values);
  std::string get(std::string_view name) const;
  /// "name=value,…" of all parameters in declaration order: what a result records.
  std::string to_string() const;
  std::vector<Entry>& mutable_entries() { return entries_; }

 private:
  const Entry& find(std::string_view name) const;
  std::vector<Entry> entries_;
};

/// Builds the table from one `describe`. A parameter struct is plain data plus
///
///   template <class V> void describe(V& v) {
///     v.number("roulette_start", roulette_start, 0, 64, "", "counted scatterings before Russian roulette begins");
///     v.flag("nee", nee, "next-event estimation: sample lights directly");
///     v.choice("lights", light_choice, {{"power", LightChoice::power}, …}, "…");
///     v.presets({{"paper", {{"nee", "off"}}}}, "values of the paper");   // adds the parameter `preset`
///     v.basic({"nee"});                                                  // all others are advanced
///   }
///
/// Defaults are the member initialisers. The table refers to the struct and must not outlive it.
class ParameterDescriber {
 public:
  explicit ParameterDescriber(ParameterTable& table) : table_(table) {}

  template <class T>
  requires(std::is_arithmetic_v<T> &&
           !std::is_same_v<T, bool>) void number(std::string name, T& value, std::type_identity_t<T> low,
                                                 std::type_identity_t<T> high, std::string unit, std::string doc);
  void flag(std::string name, bool& value, std::string doc);
  template <class E>
  void choice(std::string name, E& value, std::vector<std::pair<std::string, E>> choices, std::string doc);
  /// Adds the parameter `preset` with these choices and `default`, before all others: it sets every other parameter,
  /// and those that are set after it (or recorded with it, in order of declaration) win.
  void presets(std::vector<ParameterPreset> presets, std::string doc);
  /// Names the parameters that most pictures need; `preset` is one of them. All others that were declared before are
  /// advanced. A technique that does not call it has no advanced parameters. A name without a parameter is a fault.
  void basic(const std::vector<std::string>& names);

 private:
  ParameterTable& table_;
};

template <class P>
ParameterTable make_parameter_table(P& parameters) {
  ParameterTable table;
  ParameterDescriber describer(table);
  parameters.describe(describer);
  return table;
}

// ---- implementation of the templates

/// Parses a number completely or throws Error{usage} naming parameter and text.
double parse_parameter_number(const std::string& name, std::string_view text, bool integral);
[[noreturn]] void throw_parameter_range(const std::string& name, std::string_view text, const std::string& low,
                                        const std::string& high);

template <class T>
requires(std::is_arithmetic_v<T> &&
         !std::is_same_v<T, bool>) void ParameterDescriber::number(std::string name, T& value,
                                                                   std::type_identity_t<T> low,
                                                                   std::type_identity_t<T> high, std::string unit,
                                                                   std::string doc) {
  // The shortest text that reads back as the same T: what a result records gives the same image again.
  const auto format = [](T v) { return fmt::format("{}", v); };
  ParameterInfo info{name,
                     std::is_integral_v<T> ? "int" : "float",
                     format(value),
                     format(low) + " … " + format(high),
                     std::move(unit),
                     std::move(doc),
                     {}};
  const auto set = [&value, format, name, low, high](std::string_view text) {
    // A real number is rounded before it is compared, so that the limits' own texts are inside; a whole one is compared
    // before it is converted, since converting what does not fit is undefined.
    using Compared = std::conditional_t<std::is_floating_point_v<T>, T, double>;
    const auto number = static_cast<Compared>(parse_parameter_number(name, text, std::is_integral_v<T>));
    if (!(number >= static_cast<Compared>(low) && number <= static_cast<Compared>(high))) {
      throw_parameter_range(name, text, format(low), format(high));
    }
    value = static_cast<T>(number);
  };
  table_.mutable_entries().push_back({std::move(info), [&value, format] { return format(value); }, set});
}

/// Index of `text` in `choices` or Error{usage} naming them.
size_t parse_parameter_choice(const std::string& name, std::string_view text, const std::vector<std::string>& choices);

template <class E>
void ParameterDescriber::choice(std::string name, E& value, std::vector<std::pair<std::string, E>> choices,
                                std::string doc) {
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  const auto name_of = [choices](E current) {
    for (const auto& choice : choices)
      if (choice.second == current) return choice.first;
    return std::string("?");
  };
  std::string range;
  for (const std::string& n : names) range += (range.empty() ? "" : "|") + n;
  ParameterInfo info{name, "enum", name_of(value), range, "", std::move(doc), names};
  table_.mutable_entries().push_back({std::move(info), [&value, name_of] { return name_of(value); },
                                      [&value, name, names, choices](std::string_view text) {
                                        value = choices[parse_parameter_choice(name, text, names)].second;
                                      }});
}

}  // namespace lucarium
