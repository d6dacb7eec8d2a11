// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/source_library.h"

#include <doctest/doctest.h>

#include <fstream>

#include "compute_fixture.h"
#include "lucarium/compute/program/program.h"

using namespace lucarium;
using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

std::string preprocess(const EmbeddedSources& sources, const std::vector<std::string>& files = {"main.cl"}) {
  SourceLibrary library;
  library.add(sources);
  return library.preprocess(files);
}

void write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

}  // namespace

TEST_CASE("includes are resolved once and the lines keep their numbers") {
  const EmbeddedSources sources = {
      {"main.cl", "int a;\n#include \"x/one.clh\"\nint b;\n#include \"x/two.clh\"\nint c;\n"},
      {"x/one.clh", "#pragma once\nint one;\n"},
      {"x/two.clh", "# include \"x/one.clh\" // again\nint two;"},
  };
  const std::string text = preprocess(sources);
  CHECK(count(text, "int one;") == 1);
  CHECK(count(text, "int two;") == 1);
  CHECK(!has(text, "#include"));
  CHECK(!has(text, "pragma once"));
  CHECK(has(text, "#line 1 \"main.cl\"\nint a;\n"));
  CHECK(has(text, "#line 3 \"main.cl\"\nint b;\n"));
  CHECK(has(text, "#line 5 \"main.cl\"\nint c;\n"));
  CHECK(has(text, "#line 2 \"x/two.clh\"\nint two;\n"));
}

TEST_CASE("files that include each other end") {
  const EmbeddedSources sources = {{"main.cl", "#include \"b.clh\"\nint a;\n"},
                                   {"b.clh", "#include \"main.cl\"\nint b;\n"}};
  const std::string text = preprocess(sources, {"main.cl", "b.clh"});
  CHECK(count(text, "int a;") == 1);
  CHECK(count(text, "int b;") == 1);
}

TEST_CASE("an include in a comment is none") {
  const EmbeddedSources sources = {
      {"main.cl",
       "// #include \"no.h\"\n/* #include \"no.h\"\n#include \"no.h\"\n*/ int a; /* \" */\n"
       "constant char* s = \"/*\";\n#include \"b.clh\"\n/**/ #include \"c.clh\"\n"},
      {"b.clh", "int b;\n"},
      {"c.clh", "int c;\n"},
  };
  const std::string text = preprocess(sources);
  CHECK(count(text, "int b;") == 1);
  CHECK(count(text, "int c;") == 1);
  CHECK(count(text, "#include \"no.h\"") == 3);
}

TEST_CASE("an include inside #if does not swallow a later one outside it") {
  const EmbeddedSources sources = {
      {"main.cl",
       "#ifdef NEVER\n#include \"types.h\"\n#endif\n#include \"types.h\"\nkernel void fill(global uint* v) { "
       "v[get_global_id(0)] = VALUE; }\n"},
      {"types.h", "#ifndef TYPES_H\n#define TYPES_H\n#include \"value.h\"\n#endif\n"},
      {"value.h", "#define VALUE 7\n"},
  };
  SourceLibrary library;
  library.add(sources);
  const Program program(*test_device(), library, {"conditional", {"main.cl"}, {}});
  CHECK(launch(program, "fill", 2, 1) == std::vector<uint32_t>{7, 7});
}

TEST_CASE("C++ includes in a branch that OpenCL never sees are left alone, elsewhere they are refused") {
  const EmbeddedSources shared = {
      {"main.cl", "#ifdef __cplusplus\n#include <vector>\n#include \"host_only.h\"\n#endif\n"}};
  CHECK(has(preprocess(shared), "#include <vector>\n#include \"host_only.h\""));
  const EmbeddedSources system = {{"main.cl", "\n#include <math.h>\n"}};
  CHECK(has(error_of([&] { preprocess(system); }).what(), "main.cl:2: #include <math.h> is not possible in OpenCL C"));
}

TEST_CASE("an unknown include names who wants it, the places searched and the nearest name") {
  const TemporaryFolder root;
  const ScopedVariable path("LUCARIUM_KERNEL_PATH", root.path().string());
  const EmbeddedSources sources = {{"main.cl", "int a;\n#include \"lib/bsfd.clh\"\n"}, {"lib/bsdf.clh", ""}};
  const Error error = error_of([&] { preprocess(sources); });
  CHECK(error.error_class() == ErrorClass::device);
  CHECK(std::string(error.what()) ==
        "OpenCL source 'lib/bsfd.clh', included from main.cl:2, is in none of: the embedded sources, " +
            root.path().string() + "; did you mean 'lib/bsdf.clh'?");
  CHECK(has(error.details(), "lib/bsdf.clh"));
}

TEST_CASE("the framework's own sources are always there") {
  const SourceLibrary library;
  CHECK(library.contains("lucarium/shared/dialect.h"));
  CHECK(has(library.find("lucarium/shared/dialect.h").text, "LUCARIUM_STRUCT_BEGIN"));
}

TEST_CASE("files under LUCARIUM_KERNEL_PATH win, the first root first, and messages name them") {
  const TemporaryFolder first, second;
  write(first.path() / "x/one.clh", "#define ONE first\nbroken_in_first\n");
  write(second.path() / "x/one.clh", "second\n");
  write(second.path() / "x/two.clh", "typedef int two_of_second;\n");
  const ScopedVariable path("LUCARIUM_KERNEL_PATH", first.path().string() + ":" + second.path().string());
  const EmbeddedSources sources = {
      {"main.cl", "#include \"x/two.clh\"\n#include \"x/one.clh\"\nkernel void k(global uint* v) { v[0] = 1; }\n"},
      {"x/one.clh", "embedded\n"},
      {"x/two.clh", "embedded\n"}};
  const std::string text = preprocess(sources);
  CHECK(has(text, "int two_of_second;"));
  CHECK(has(text, "#define ONE first"));
  CHECK(!has(text, "embedded"));
  SourceLibrary library;
  library.add(sources);
  const Error error = error_of([&] { Program(*test_device(), library, {"probe", {"main.cl"}, {}}); });
  CHECK(has(error.what(), "program probe does not compile: " + (first.path() / "x/one.clh").string() + ":2:"));
}
