// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/files/json_lines.h"

#include <iterator>
#include <set>
#include <stdexcept>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"

namespace lucarium {

namespace {

/// Where the parser is: the line of the character that it consumed last. A line feed belongs to the line that it ends:
/// the parser consumes it to see that a number before it is over.
struct LineCounter {
  int line = 1;
  bool at_end = false;  ///< that character was a line feed
  void consume(char c) {
    if (at_end) ++line;
    at_end = c == '\n';
  }
};

/// Characters of a text; counts the lines that the parser has consumed.
struct CountingIterator {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;
  const char* at = nullptr;
  LineCounter* counter = nullptr;
  reference operator*() const { return *at; }
  CountingIterator& operator++() {
    counter->consume(*at);
    ++at;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at == other.at; }
  bool operator!=(const CountingIterator& other) const { return at != other.at; }
};

struct DoubledKey : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Follows the parser through objects and arrays and notes where each value begins.
class LineRecorder {
 public:
  LineRecorder(std::map<std::string, int>& lines, const LineCounter& counter) : lines_(lines), counter_(counter) {}

  bool operator()(int, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
    using Event = nlohmann::json::parse_event_t;
    switch (event) {
      case Event::key:
        levels_.back().key = parsed.get<std::string>();
        if (!levels_.back().keys.insert(levels_.back().key).second) {
          throw DoubledKey(fmt::format("the key \"{}\" is given twice in one object", levels_.back().key));
        }
        note();
        break;
      case Event::object_start:
      case Event::array_start:
        next_element();
        if (levels_.size() >= deepest) throw std::length_error("it is nested too deeply");
        levels_.push_back({event == Event::array_start, -1, "", {}});
        break;
      case Event::object_end:
      case Event::array_end: levels_.pop_back(); break;
      case Event::value: next_element(); break;
    }
    return true;
  }

 private:
  static constexpr size_t deepest = 64;  ///< every level costs time in note()
  struct Level {
    bool array;
    int index;
    std::string key;
    std::set<std::string> keys;  ///< so far
  };

  void next_element() {
    if (levels_.empty() || !levels_.back().array) return;
    ++levels_.back().index;
    note();
  }

  void note() {
    std::string pointer;
    for (const Level& level : levels_) pointer += "/" + (level.array ? std::to_string(level.index) : level.key);
    lines_[pointer] = counter_.line;
  }

  std::map<std::string, int>& lines_;
  const LineCounter& counter_;
  std::vector<Level> levels_;
};

}  // namespace

int JsonWithLines::line(const std::string& pointer) const {
  for (std::string at = pointer; !at.empty(); at.resize(at.rfind('/'))) {
    if (const auto found = lines.find(at); found != lines.end()) return found->second;
  }
  return 1;
}

JsonWithLines read_json_with_lines(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  JsonWithLines result;
  LineCounter counter;
  const int& line = counter.line;
  try {
    const CountingIterator begin{text.data(), &counter}, end{text.data() + text.size(), &counter};
    result.value = nlohmann::json::parse(begin, end, LineRecorder(result.lines, counter), true, true);
  } catch (const std::length_error& error) {
    throw_error(ErrorClass::input, "{}:{}: {}", file.string(), line, error.what());
  } catch (const DoubledKey& error) {
    throw_error(ErrorClass::input, "{}:{}: {}", file.string(), line, error.what());
  } catch (const nlohmann::json::exception& exception) {
    // The parser's message repeats the position and ends with what it expected.
    std::string what = exception.what();
    if (const size_t at = what.rfind("; "); at != std::string::npos) what = what.substr(at + 2);
    throw Error(ErrorClass::input, fmt::format("{}:{}: this is not valid JSON: {}", file.string(), line, what))
        .with_details(exception.what());
  }
  return result;
}

}  // namespace lucarium
