// SPDX-License-Identifier: Apache-2.0
// Job files: writer and reader are a pair, and the reader takes nothing else.
#include "lucarium/job/job_file.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/json.h"
#include "lucarium/scene/exposure.h"
#include "test_support.h"

using namespace lucarium;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// No member has its default.
Job example_render() {
  Job job;
  job.scene = "/scenes/a \"b\".glb";
  job.overrides.camera = "0,1,2:0,0,0:45";
  job.overrides.camera_path = "linear:0@0,1,2:0,0,0;1@0,1,3:0,0,0";
  job.overrides.environment = "sky.hdr*2@30";
  job.overrides.lights = {"none", "point:0,1,0:5,5,5"};
  job.overrides.exposure = -1.7f;
  job.overrides.at_seconds = 0.1;
  job.overrides.animation = "walk";
  job.overrides.materials = {"wall*:roughness=0.5"};
  job.overrides.use_sidecar = false;
  job.import.max_texture_size = 512;
  job.width = 48;
  job.height = 32;
  job.max_bounces = 3;
  job.pixel_sampling = 4;
  job.seed = ~uint64_t{0};
  job.device = {"cpu", 2, size_t{3} << 30, size_t{1} << 29, "/some/cache", false};
  job.technique_folders = {"/a folder", "--not-an-option"};
  job.verbose = true;
  job.work = RenderWork{"bundle_exchange",
                        {{"b", "1,2=3"}, {"a", ""}},
                        2.5,
                        64,
                        1e-3,
                        "r.exr",
                        true,
                        "o.exr",
                        32,
                        2,
                        {5, 3, {0, 4}, {"a.exr", "b.exr"}}};
  return job;
}

Job example_reference() {
  Job job;
  job.scene = "builtin:cornell";
  job.work = ReferenceWork{"max_bounces=3", 512, 1e-4, "r.exr"};
  return job;
}

Job read_text(const std::string& text) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "job.json";
  write_file_atomically(file, text);
  return read_job(file);
}

/// What the reader says of the example with one change, from the file's name on.
std::string complaint(const std::string& text) {
  try {
    read_text(text);
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::input);
    const std::string what = error.what();
    CHECK(what.find('\n') == std::string::npos);
    return what.substr(std::min(what.find("job.json"), what.size()));
  }
  return "accepted";
}

std::string changed(const std::string& pointer, const json& value) {
  ordered_json job = ordered_json::parse(job_json(example_render()));
  job[ordered_json::json_pointer(pointer)] = value;
  return complaint(job.dump(2));
}

}  // namespace

TEST_CASE("a job that is written and read is the same job") {
  for (const Job& job : {example_render(), example_reference(), Job()}) {
    const std::string text = job_json(job);
    CHECK(job_json(read_text(text)) == text);
  }
  const Job job = read_text(job_json(example_render()));
  CHECK(job.overrides.exposure == -1.7f);
  CHECK(job.overrides.camera_path == "linear:0@0,1,2:0,0,0;1@0,1,3:0,0,0");
  CHECK(job.overrides.at_seconds == 0.1);
  CHECK(job.seed == ~uint64_t{0});
  const auto& work = std::get<RenderWork>(job.work);
  CHECK(work.parameters == std::get<RenderWork>(example_render().work).parameters);
  CHECK(work.relmse == 1e-3);
  CHECK(work.work_iterations == 2);
  CHECK(work.walk.reference_frames == std::vector<uint32_t>{0, 4});
  CHECK(work.walk.references[1] == "b.exr");
}

TEST_CASE("the example has no member of its default, so that reading it back says of each that it is read") {
  const json example = json::parse(job_json(example_render())).flatten(),
             plain = json::parse(job_json(Job())).flatten();
  for (const auto& [pointer, value] : example.items()) {
    CAPTURE(pointer);
    CHECK((pointer == "/schema" || !plain.contains(pointer) || plain[pointer] != value));
  }
}

TEST_CASE("no exposure, an automatic one and a number are three things") {
  Job job = example_render();
  job.overrides.exposure = std::nullopt;
  CHECK(!read_text(job_json(job)).overrides.exposure);
  job.overrides.exposure = exposure_automatic;
  const Job read = read_text(job_json(job));
  REQUIRE(read.overrides.exposure);
  CHECK(is_automatic(*read.overrides.exposure));
}

TEST_CASE("a job file that job_json() would not write is refused with file, line and key") {
  CHECK(complaint(job_json(example_render())) == "accepted");
  CHECK(changed("/image/widht", 1) == "job.json:27: image/widht: unknown key; did you mean 'width'?");
  CHECK(changed("/image/width", 0) == "job.json:22: image/width: must be a whole number from 1 to 32768");
  CHECK(changed("/image/width", "8") == "job.json:22: image/width: must be a whole number from 1 to 32768");
  CHECK(changed("/image/max_bounces", -2) == "job.json:24: image/max_bounces: must be a whole number from -1 to 4095");
  CHECK(changed("/device/threads", 4097) == "job.json:30: device/threads: must be a whole number from 0 to 4096");
  CHECK(changed("/device/use_cache", 1) == "job.json:34: device/use_cache: must be true or false");
  CHECK(changed("/scene/exposure", "bright") == "job.json:12: scene/exposure: must be a number");
  CHECK(changed("/scene/lights", "none") == "job.json:8: scene/lights: must be an array");
  CHECK(changed("/scene/materials/0", json::object()) == "job.json:16: scene/materials/0: must be a string");
  CHECK(changed("/render/iterations", -1)
            .ends_with("render/iterations: must be a whole number from 0 to "
                       "18446744073709551615"));
  CHECK(changed("/render/relmse", -0.5).ends_with("render/relmse: must not be below 0"));
  CHECK(changed("/render/parameters/0", "b=1").ends_with("render/parameters/0: must be [\"name\", \"value\"]"));
  CHECK(changed("/reference", json::object()) == "job.json:1: the file: has both \"render\" and \"reference\"");
  CHECK(changed("/schema", "lucarium-job-2") == "job.json:2: schema: must be \"lucarium-job-1\"");
  CHECK(changed("/image", json::array()) == "job.json:21: image: must be an object");

  ordered_json job = ordered_json::parse(job_json(example_render()));
  job["render"].erase("curve");
  CHECK(complaint(job.dump(2)).ends_with("render: \"curve\" is missing"));
  job.erase("render");
  CHECK(complaint(job.dump(2)) == "job.json:1: the file: \"render\" is missing");
  CHECK(complaint("{\"schema\": \"lucarium-job-1\",\n\"scene\": {},\n\"scene\": {}}") ==
        "job.json:3: the key \"scene\" is given twice in one object");
  CHECK(complaint("[]") == "job.json:1: schema: must be \"lucarium-job-1\"");
}

TEST_CASE("a name that is not UTF-8 cannot be written into a job, which says so") {
  Job job = example_render();
  job.device.cache_dir = "/tmp/\xff";
  CHECK_THROWS_WITH_AS(job_json(job), doctest::Contains("is not UTF-8"), Error);
}
