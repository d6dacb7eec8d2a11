// SPDX-License-Identifier: Apache-2.0
// Files of saved states: what was put comes back, and nothing that is not whole is believed.
#include "lucarium/technique/state_file.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>

#include "file_size_limit.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/technique/state_layout.h"
#include "test_support.h"

using namespace lucarium;
namespace layout = lucarium::state_layout;

namespace {

StateHeader some_header() {
  StateHeader header;
  header.program_version = "1.2";
  header.scene = "builtin:room";
  header.scene_hash = "00ff";
  header.technique = "some_technique";
  header.technique_version = "3";
  header.parameters = {{"lines", "12"}, {"mode", "a b"}};
  header.path_set = "max_bounces=2";
  header.max_bounces = 2;
  header.seed = std::numeric_limits<uint64_t>::max();
  header.width = 64;
  header.height = 48;
  header.seconds = 1.5;
  return header;
}

void put_some(StateWriter& chunks) {
  chunks.put("light", std::vector<float>{0, 1.5f, -2, 1e30f});
  chunks.put("index", std::vector<uint32_t>(1000, 7));
  chunks.put("empty", std::vector<double>{});
  chunks.put_value("count", uint64_t{1} << 40);
}

class File {
 public:
  explicit File(bool compress = false) { write_state_file(path(), some_header(), compress, put_some); }
  std::filesystem::path path() const { return folder_.path() / "a.state"; }
  std::string bytes() const { return read_file(path()); }
  void replace(const std::string& bytes) const { std::ofstream(path(), std::ios::binary) << bytes; }
  /// What opening says, without the file's name; empty: it is opened.
  std::string refusal() const {
    try {
      const StateFile file(path());
    } catch (const Error& error) {
      CHECK(error.error_class() == ErrorClass::input);
      const std::string text = error.what(), name = path().string() + ": ";
      REQUIRE(text.starts_with(name));
      CHECK(text.find('\n') == std::string::npos);
      return text.substr(name.size());
    }
    return "";
  }
  size_t files() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder_.path()), {}));
  }

 private:
  test::TemporaryFolder folder_;
};

template <class Action>
std::string message_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::input);
    return error.what();
  }
  return "";
}

/// Where the first record stands.
size_t first_record(const std::string& bytes) {
  layout::Start start;
  std::memcpy(&start, bytes.data(), sizeof start);
  return sizeof start + start.header_bytes;
}

/// Changes the first record and makes its checksum right again, as whoever wants to break a reader would.
std::string with_record(std::string bytes, void (*change)(layout::Record&)) {
  layout::Record record;
  const size_t at = first_record(bytes);
  std::memcpy(&record, bytes.data() + at, sizeof record);
  const std::string name = bytes.substr(at + sizeof record, record.name_bytes);
  change(record);
  record.checksum = Hasher().add_bytes(&record, 48).add_bytes(name.data(), name.size()).finish();
  std::memcpy(bytes.data() + at, &record, sizeof record);
  return bytes;
}

std::string with_header(const std::string& bytes, const std::string& text, uint32_t schema = layout::schema) {
  layout::Start start;
  std::memcpy(&start, bytes.data(), sizeof start);
  start.schema = schema;
  start.header_bytes = static_cast<uint32_t>(text.size());
  start.checksum = Hasher().add_bytes(&start, 16).add_bytes(text.data(), text.size()).finish();
  std::string result(sizeof start, '\0');
  std::memcpy(result.data(), &start, sizeof start);
  return result + text + bytes.substr(first_record(bytes));
}

}  // namespace

TEST_CASE("a state comes back as it was put, plain and compressed") {
  for (const bool compress : {false, true}) {
    CAPTURE(compress);
    const File file(compress);
    const StateFile state(file.path());
    const StateHeader &header = state.header(), expected = some_header();
    CHECK(header.program_version == expected.program_version);
    CHECK(header.scene == expected.scene);
    CHECK(header.scene_hash == expected.scene_hash);
    CHECK(header.technique == expected.technique);
    CHECK(header.technique_version == expected.technique_version);
    CHECK(header.parameters == expected.parameters);
    CHECK(header.path_set == expected.path_set);
    CHECK(header.max_bounces == expected.max_bounces);
    CHECK(header.seed == expected.seed);
    CHECK(header.width == expected.width);
    CHECK(header.height == expected.height);
    CHECK(header.seconds == expected.seconds);
    CHECK(state.get<float>("light") == std::vector<float>{0, 1.5f, -2, 1e30f});
    CHECK(state.get_finite<float>("light", 4).back() == 1e30f);
    CHECK(state.get<uint32_t>("index", 1000) == std::vector<uint32_t>(1000, 7));
    CHECK(state.get<double>("empty").empty());
    CHECK(state.get_value<uint64_t>("count") == uint64_t{1} << 40);
    CHECK(state.has("light"));
    CHECK_FALSE(state.has("lights"));
    REQUIRE(state.chunks().size() == 4);
    CHECK(state.chunks()[1].compressed == compress);
    CHECK_FALSE(state.chunks()[3].compressed);  // it would be larger
    CHECK((state.chunks()[1].stored_bytes < 100) == compress);
  }
}

TEST_CASE("a state that is cut off anywhere is refused") {
  for (const bool compress : {false, true}) {
    const File file(compress);
    const std::string whole = file.bytes();
    for (size_t length = 0; length < whole.size(); ++length) {
      CAPTURE(length);
      file.replace(whole.substr(0, length));
      const std::string refusal = file.refusal();
      CHECK_FALSE(refusal.empty());
      if (length >= sizeof layout::magic) CHECK(refusal.find("it is cut off in ") == 0);
    }
    file.replace(whole);
    CHECK(file.refusal().empty());
  }
}

TEST_CASE("a state of which any byte is another one is refused") {
  for (const bool compress : {false, true}) {
    const File file(compress);
    const std::string whole = file.bytes();
    for (size_t at = 0; at < whole.size(); at += at < 2000 ? 1 : 97) {
      std::string flipped = whole;
      flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at % 8)));
      file.replace(flipped);
      CAPTURE(at);
      CHECK_FALSE(file.refusal().empty());
    }
  }
}

TEST_CASE("what else a file may be: empty, something else, longer, newer, with a chunk less") {
  const File file;
  const std::string whole = file.bytes();
  const auto refusal = [&](const std::string& bytes) {
    file.replace(bytes);
    return file.refusal();
  };
  CHECK(refusal("") == "it is not a state of a technique; --save-state writes one");
  CHECK(refusal("#?RADIANCE and more of that") == "it is not a state of a technique; --save-state writes one");
  CHECK(refusal(whole + "x") == "1 bytes stand behind its end; save the state again");
  CHECK(refusal(with_header(whole, "{}")) == "its header is not that of a state; save the state again");
  CHECK(refusal(with_header(whole, "no JSON")) == "its header is not that of a state; save the state again");
  CHECK(
      refusal(with_header(whole, whole.substr(sizeof(layout::Start), first_record(whole) - sizeof(layout::Start)),
                          layout::schema + 1)) ==
      "it has schema 2, and this program reads up to 1; use the newer program that wrote it, or save the state again");
  const size_t first = first_record(whole), second = whole.find("CHNK", first + 1);
  CHECK(refusal(whole.substr(0, first) + whole.substr(second)) == "chunks are missing; save the state again");
  const std::string chunk = whole.substr(first, second - first);
  CHECK(refusal(whole.substr(0, first) + chunk + whole.substr(first)) ==
        "the record of chunk 1 is damaged; save the state again");
}

TEST_CASE("counts that a file cannot have are refused before memory is asked for") {
  const File file;
  const std::string whole = file.bytes();
  const auto refusal = [&](void (*change)(layout::Record&)) {
    file.replace(with_record(whole, change));
    return file.refusal();
  };
  const std::string impossible = "which it cannot have";
  const auto is_impossible = [&](const std::string& text) { return text.find(impossible) != std::string::npos; };
  CHECK(is_impossible(refusal([](layout::Record& r) { r.elements = std::numeric_limits<uint64_t>::max(); })));
  CHECK(is_impossible(refusal([](layout::Record& r) { r.elements = uint64_t{1} << 62; })));
  CHECK(is_impossible(refusal([](layout::Record& r) { r.elements = 5; })));
  CHECK(is_impossible(refusal([](layout::Record& r) { r.elements = 3; })));
  CHECK(is_impossible(refusal([](layout::Record& r) { r.element_bytes = 0; })));
  CHECK(is_impossible(refusal([](layout::Record& r) { r.element_bytes = 0xffffffffu; })));
  CHECK(refusal([](layout::Record& r) { r.stored_bytes = std::numeric_limits<uint64_t>::max(); }) ==
        "it is cut off in chunk 'light'; save the state again");
  CHECK(refusal([](layout::Record& r) { r.encoding = static_cast<layout::Encoding>(2); }) ==
        "the record of chunk 0 is damaged; save the state again");
  // More than zlib can hold in so few bytes; and less than it says, which unpacking finds.
  CHECK(is_impossible(refusal([](layout::Record& r) {
    r.encoding = layout::Encoding::zlib;
    r.elements = uint64_t{1} << 40;
  })));
  file.replace(with_record(whole, [](layout::Record& r) { r.encoding = layout::Encoding::zlib; }));
  // The end knows the record that was; so that it is reached, the file says what it holds.
  CHECK(file.refusal() == "chunks are missing; save the state again");
}

TEST_CASE("chunks are read by what they are: name, size of elements, their number, finite values") {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.state";
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  write_state_file(path, some_header(), false, [&](StateWriter& chunks) {
    put_some(chunks);
    chunks.put("nan", std::vector<float>{1, 2, nan, 4});
    chunks.put("infinite", std::vector<float>{infinite, 2});
  });
  const StateFile state(path);
  const std::string chunk = path.string() + ": chunk ";
  CHECK(message_of([&] { state.get<float>("lights"); }) == chunk + "'lights': it is missing; save the state again");
  CHECK(message_of([&] { state.get<double>("light"); }) ==
        chunk + "'light': its elements have 4 bytes, not 8; save the state again");
  CHECK(message_of([&] { state.get<float>("light", 5); }) ==
        chunk + "'light': it has 4 elements, not 5; save the state again");
  CHECK(message_of([&] { state.get_value<float>("light"); }) ==
        chunk + "'light': it has 4 elements, not 1; save the state again");
  CHECK(message_of([&] { state.get_finite<float>("nan", 4); }) ==
        chunk + "'nan': number 2 of 4 is not finite; save the state again");
  CHECK(message_of([&] { state.get_finite<float>("infinite", 2); }) ==
        chunk + "'infinite': number 0 of 2 is not finite; save the state again");
  CHECK(std::isnan(state.get<float>("nan", 4)[2]));
  CHECK(message_of([&] { state.fail("index", "tile 9 of 4"); }) ==
        chunk + "'index': tile 9 of 4; save the state again");
}

TEST_CASE("a file that changes behind its reader's back is an error, not a crash") {
  const File file;
  const StateFile state(file.path());
  file.replace("");
  CHECK(message_of([&] { state.get<float>("light"); }) ==
        file.path().string() + ": chunk 'light': it cannot be read any more; save the state again");
  std::string bytes = File().bytes();
  const float other = 1.25f, was = 1.5f;
  const auto at = std::search(bytes.begin(), bytes.end(), reinterpret_cast<const char*>(&was),
                              reinterpret_cast<const char*>(&was + 1));
  std::copy_n(reinterpret_cast<const char*>(&other), sizeof other, at);
  file.replace(bytes);
  CHECK(message_of([&] { state.get<float>("light"); }) ==
        file.path().string() + ": chunk 'light': it has changed since the file was opened; save the state again");
}

TEST_CASE("a state that is saved again while it is read stays the one that was opened") {
  const File file;
  const StateFile state(file.path());
  write_state_file(file.path(), some_header(), false,
                   [](StateWriter& chunks) { chunks.put("light", std::vector<float>(10000, 9)); });
  CHECK(state.get<float>("light") == std::vector<float>{0, 1.5f, -2, 1e30f});
  CHECK(state.get<uint32_t>("index") == std::vector<uint32_t>(1000, 7));
  CHECK(StateFile(file.path()).get<float>("light") == std::vector<float>(10000, 9));
}

TEST_CASE("writing is whole or not at all: what was there stays, and nothing lies beside it") {
  const File file;
  const std::string before = file.bytes();
  CHECK_THROWS_AS(write_state_file(file.path(), some_header(), false,
                                   [](StateWriter& chunks) {
                                     chunks.put("one", std::vector<float>(100, 1));
                                     throw Error(ErrorClass::technique, "fails on the way");
                                   }),
                  Error);
  CHECK(file.bytes() == before);
  CHECK(file.files() == 1);
  for (const char* name : {"", "Light", "a-b", "light"}) {
    CAPTURE(name);
    CHECK_THROWS_WITH_AS(write_state_file(file.path(), some_header(), false,
                                          [&](StateWriter& chunks) {
                                            chunks.put_value("light", 1);
                                            chunks.put_value(name, 1);
                                          }),
                         doctest::Contains("whose name is wrong or not new"), Error);
  }
  CHECK(file.bytes() == before);
  CHECK(file.files() == 1);
}

TEST_CASE("a disk that is full leaves the old state and no other file") {
  const File file;
  const std::string before = file.bytes();
  for (const size_t limit : {size_t{1}, size_t{100}, size_t{300}, before.size() - 1}) {
    CAPTURE(limit);
    const test::FileSizeLimit full(limit);
    const std::string message = message_of([&] { write_state_file(file.path(), some_header(), false, put_some); });
    CHECK(message.find("cannot write " + file.path().string()) == 0);
  }
  CHECK(file.bytes() == before);
  CHECK(file.files() == 1);
}
