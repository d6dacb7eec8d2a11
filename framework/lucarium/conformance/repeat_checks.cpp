// SPDX-License-Identifier: Apache-2.0
// Checks that the same request gives the same picture. Declared in checks.h.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/conformance/checks.h"
#include "lucarium/conformance/oclgrind_options.h"
#include "lucarium/conformance/temporary_folder.h"
#include "lucarium/film/image_io.h"
#include "lucarium/job/run_job.h"

namespace lucarium::check {
namespace fs = std::filesystem;
namespace {

using Parameters = std::vector<std::pair<std::string, std::string>>;

Outcome same_bits(const std::string& different, const std::string& when_same) {
  return verdict_of(different.empty(), different.empty() ? when_same : different);
}

/// A small picture of builtin:cornell with the technique under test, `side`² pixels large.
Job small_picture(const CheckContext& context, const Parameters& parameters, const fs::path& output, uint32_t side,
                  uint64_t iterations) {
  const RenderSettings settings = context.settings(context.plain_scene());
  Job job;
  job.scene = "builtin:cornell";
  job.width = job.height = side;
  job.max_bounces = settings.max_bounces;
  job.pixel_sampling = settings.pixel_sampling;
  job.technique_folders = context.options.technique_folders;
  RenderWork work;
  work.technique = context.type.info().name;
  work.parameters = parameters;
  work.iterations = iterations;
  work.output = output;
  job.work = work;
  return job;
}

std::string last_word(const ChildResult& result) {
  return result.last_words.empty() ? describe_end(result) : result.last_words.back();
}

fs::path find_on_path(const std::string& name) {
  const char* list = std::getenv("PATH");
  const std::string text(list ? list : "");
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(':', begin), text.size());
    const fs::path file = fs::path(text.substr(begin, end - begin)) / name;
    std::error_code unreadable;
    // A folder of that name may be entered, which X_OK means as well.
    if (fs::is_regular_file(file, unreadable) && ::access(file.c_str(), X_OK) == 0) return file;
    begin = end + 1;
  }
  return {};
}

}  // namespace

Outcome check_seed(CheckContext& context) {
  const Scene scene = context.plain_scene();
  RenderSession first = context.session(scene), second = context.session(scene);
  return same_bits(difference(context.run_short(first), context.run_short(second)), "two runs, same bits");
}

Outcome check_reset(CheckContext& context) {
  const Scene scene = context.plain_scene();
  RenderSettings other = context.settings(scene);
  other.seed = 2;
  RenderSession fresh = context.session(scene, other), used = context.session(scene);
  used.run({.iterations = 5});
  used.restart(2);
  return same_bits(difference(context.run_short(used), context.run_short(fresh)),
                   "after 5 iterations and a reset, same bits as a new run");
}

Outcome check_observing(CheckContext& context) {
  const Scene scene = context.plain_scene();
  RenderSession plain = context.session(scene), observed = context.session(scene);
  const Picture expected = context.run_short(plain);
  while (observed.iterations() < plain.iterations() && !interrupt_requested()) {
    observed.technique().warm_up();
    observed.iterate();
    const std::string twice = difference(context.picture(observed), context.picture(observed));
    if (!twice.empty()) return verdict_of(false, "a second resolve differs: " + twice);
  }
  return same_bits(difference(expected, context.picture(observed)),
                   "warm_up and resolve between iterations, same bits");
}

Outcome check_threads(CheckContext& context) {
  if (context.options.program.empty()) return {Verdict::skipped, "needs the program lucarium"};
  if (!context.device->info().is_pocl) return {Verdict::skipped, "only PoCL's CPU device has a number of threads"};
  const TemporaryFolder folder;
  RenderSession counted = context.session(context.plain_scene());
  context.run_short(counted);
  std::vector<Picture> pictures;
  for (const int threads : {1, 2}) {
    const fs::path file = folder.path() / fmt::format("{}.exr", threads);
    Job job = small_picture(context, context.options.parameters, file, 32, counted.iterations());
    job.device = context.options.device;
    job.device.threads = threads;
    const ChildResult result = run_job({context.options.program.string()}, job);
    if (result.exit_code != 0) return verdict_of(false, fmt::format("with {} threads: {}", threads, last_word(result)));
    pictures.push_back(picture_of(read_image(file)));
  }
  return same_bits(difference(pictures[0], pictures[1]), "1 and 2 threads, same bits");
}

Outcome check_oclgrind(CheckContext& context) {
  const fs::path oclgrind = find_on_path("oclgrind");
  if (context.options.program.empty()) return {Verdict::skipped, "needs the program lucarium"};
  if (oclgrind.empty()) return {Verdict::skipped, "oclgrind is not installed"};
  if (detail::plugin_header().sanitizers[0])
    return {Verdict::skipped, "not possible with the sanitizers of this build"};
  const TemporaryFolder folder;
  // The scalar traversal is short.
  const std::vector<std::string> interpreted = {
      "/usr/bin/env", "LUCARIUM_BVH=scalar",           oclgrind.string(), "--build-options", LUCARIUM_OCLGRIND_OPTIONS,
      "--data-races", context.options.program.string()};
  // Until there are samples: what is computed before the first of them must have run.
  Job job = small_picture(context, context.oclgrind_parameters, folder.path() / "a.exr", 4, CheckContext::longest_lead);
  std::get<RenderWork>(job.work).samples = 2;
  if (job.max_bounces < 0 || job.max_bounces > 2) job.max_bounces = 2;  // a third one would run the same kernels again
  job.device.use_cache = false;
  size_t errors = 0;
  std::string first, unknown;
  const ChildResult result = run_job(interpreted, job, [&](std::string_view line) {
    if (line.find("Undefined external function") != std::string_view::npos) unknown = line;
    for (const char* sign : {"Invalid read", "Invalid write", "data race"}) {
      if (line.find(sign) == std::string_view::npos) continue;
      if (errors++ == 0) first = line;
    }
  });
  if (!unknown.empty()) return {Verdict::skipped, "Oclgrind cannot interpret the kernels: " + unknown};
  if (errors > 0) return verdict_of(false, fmt::format("{} errors, the first: {}", errors, first));
  if (result.exit_code > 0) return verdict_of(false, last_word(result));
  std::string settings;
  for (const auto& [name, value] : context.oclgrind_parameters) settings += fmt::format(", {}={}", name, value);
  return verdict_of(true, fmt::format("no access outside a buffer, no data race (4×4 pixels{})", settings));
}

}  // namespace lucarium::check
