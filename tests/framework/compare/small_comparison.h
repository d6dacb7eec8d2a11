// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdlib>

#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/compare/run/comparison.h"
#include "test_support.h"

namespace lucarium::test {

namespace fs = std::filesystem;

/// One run of one scene at a size that takes no time.
struct SmallComparison {
  TemporaryFolder folder;
  TechniqueRegistry registry;
  ComparisonSpec spec;
  ComparisonOptions options;

  SmallComparison() {
    spec.scenes.resize(1);
    spec.scenes[0].source = "builtin:cornell";
    spec.variants = {{"path_tracing", {}, ""}};
    spec.budgets = {{0, 1, 0, 0}};
    spec.seeds = 1;
    spec.width = spec.height = 8;
    spec.max_bounces = 0;
    spec.reference.samples = 32;
    options.folder = folder.path() / "results";
    options.cache_dir = folder.path() / "cache";
    options.program = std::getenv("LUCARIUM_TEST_PROGRAM");
    // References of its own, but compiled kernels of all tests.
    const fs::path programs = fs::path(std::getenv("LUCARIUM_CACHE_DIR")) / "programs";
    fs::create_directories(programs);
    fs::create_directories(options.cache_dir);
    fs::create_directory_symlink(fs::absolute(programs), options.cache_dir / "programs");
  }
  ~SmallComparison() { set_interrupt_requested(false); }

  ComparisonResult run() const { return run_comparison(spec, registry, options); }
  std::string results() const { return read_file(options.folder / "results.json"); }
};

}  // namespace lucarium::test
