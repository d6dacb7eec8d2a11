// SPDX-License-Identifier: Apache-2.0
// Devices end with 4, plug-ins with 5; one that fails does not stop the others.
#include "cli_support.h"

using namespace lucarium::test;

TEST_CASE("memory that is missing names the parameters that need it") {
  const TemporaryFolder folder;
  const std::string common = " --size 64x64 --memory-limit 8M -o " + (folder.path() / "a.exr").string();
  check_refused("render builtin:cornell -t bundle_exchange" + common, 4, "lower --size or --texture-size, texels");
  check_refused("render builtin:cornell -t bundle_exchange:texels=500000" + common, 4,
                "lower --size or --texture-size, texels");
  check_refused("render builtin:cornell -t micro_rendering" + common, 4, "lower --size or --texture-size, points_log2");
}

TEST_CASE("device: exit code 4") {
  const TemporaryFolder folder;
  const std::string render = "render builtin:cornell -o " + (folder.path() / "a.exr").string() + " ";
  check_refused(
      render + constant_technique() + "--device quantum", 4,
      "no OpenCL device matches 'quantum'; give an index, part of a name, cpu, gpu or accelerator: this machine "
      "has '0: ");
  check_refused("compare builtin:cornell " + constant_technique() + "--iterations 1 --device quantum -o " +
                    (folder.path() / "results").string(),
                4, "error: the reference was not rendered: no OpenCL device matches 'quantum'");
  std::filesystem::remove_all(folder.path() / "results");
  check_refused(render + constant_technique() + "--memory-limit 1K", 4, "KiB");
  check_refused(render + constant_technique("extra_megabytes=100000000"), 4, "TiB");
  const ProgramResult none = run_program("OCL_ICD_VENDORS=/nonexistent " + lucarium_program() + " devices");
  CHECK(none.exit_code == 4);
  CHECK(contains(none.err, "pocl-opencl-icd"));
  CHECK(count_files(folder.path()) == 0);
}

TEST_CASE("without PATH the driver ended the process when it linked a kernel") {
  const TemporaryFolder folder;
  const std::string render = lucarium_program() + " render builtin:cornell " + constant_technique() +
                             "--iterations 1 --no-cache -q -o " + (folder.path() / "a.exr").string();
  const ProgramResult without = run_program("unset PATH; " + render);
  CHECK_MESSAGE(without.exit_code == 0, without.err);
  if (!contains(run_program(lucarium_program() + " devices").out, "Portable Computing Language")) return skip("PoCL");
  const ProgramResult wrong = run_program("PATH=/nonexistent " + render + " --overwrite");
  CHECK(wrong.exit_code == 4);
  CHECK(contains(wrong.err, "links kernels with the program ld, which no folder of PATH (/nonexistent) holds"));
  CHECK(std::count(wrong.err.begin(), wrong.err.end(), '\n') == 1);
}

TEST_CASE("technique: exit code 5, and a failure leaves no file") {
  const TemporaryFolder folder;
  const std::string out = " -o " + (folder.path() / "a.exr").string() + " --iterations 3 ";
  const std::string plugins = environment("LUCARIUM_TEST_PLUGINS");
  check_refused("render builtin:cornell -t wrong_abi --technique-path " + plugins + "/wrong_abi" + out, 5,
                "is built for ABI");
  check_refused("render builtin:cornell -t throws_in_create --technique-path " + plugins + "/throws_in_create" + out, 5,
                "an exception of the plug-in's own");
  check_refused("render builtin:cornell " + constant_technique() + "--max-bounces 7" + out, 5, "at most 3 bounces");
  check_refused("render builtin:cornell " + constant_technique("failure=error,fail_at=2") + out, 5,
                "it fails as requested");
  check_refused("render builtin:cornell " + constant_technique("failure=exception,fail_at=2") + out, 5,
                "an exception that is no Error");
  check_refused("render builtin:cornell " + constant_technique("failure=nan,fail_at=2") + out, 5, "values are NaN");
  CHECK(count_files(folder.path()) == 0);
}

TEST_CASE("a plug-in that cannot be loaded does not stop the others, and says why") {
  const std::string plugins = environment("LUCARIUM_TEST_PLUGINS");
  const ProgramResult result = run_lucarium("techniques --technique-path " + plugins + "/wrong_abi --technique-path " +
                                            plugins + "/text_file --technique-path " + plugins + "/constant");
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "constant"));
  CHECK(contains(result.err, "wrong_abi.so: is built for ABI"));
  CHECK(contains(result.err, "text_file.so: cannot be loaded: "));
}

TEST_CASE("an executable without its program says what is missing: exit code 70") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "bin");
  const std::filesystem::path copy = folder.path() / "bin/lucarium";
  std::filesystem::copy_file(environment("LUCARIUM_TEST_PROGRAM"), copy);
  const ProgramResult result = run_program(copy.string() + " --version");
  CHECK(result.exit_code == 70);
  CHECK(result.out.empty());
  CHECK(result.err.starts_with("lucarium: error: " + copy.parent_path().string()));
  CHECK(contains(result.err, "lucarium_program.so: cannot open"));
  CHECK(contains(result.err, "; install the program again\n"));
}
