// SPDX-License-Identifier: Apache-2.0
// The JSON form of a job. visit_…() say each key once; Writer and Reader visit them.
#include "lucarium/job/job_file.h"

#include <limits>
#include <type_traits>

#include "lucarium/base/error.h"
#include "lucarium/base/files/json_file.h"
#include "lucarium/base/request_limits.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/services/path_set.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr const char* job_schema = "lucarium-job-1";
constexpr const char* render_key = "render";
constexpr const char* reference_key = "reference";

using Parameters = std::vector<std::pair<std::string, std::string>>;

template <class Visitor, class TheJob>
void visit_scene(Visitor& visit, TheJob& job) {
  visit("source", job.scene);
  visit("camera", job.overrides.camera);
  visit("camera_path", job.overrides.camera_path);
  visit("environment", job.overrides.environment);
  visit("lights", job.overrides.lights);
  visit.exposure("exposure", job.overrides.exposure);
  visit("at_seconds", job.overrides.at_seconds);
  visit("animation", job.overrides.animation);
  visit("materials", job.overrides.materials);
  visit("sidecar", job.overrides.use_sidecar);
  visit("texture_size", job.import.max_texture_size, 1u, largest_texture_size);
}

template <class Visitor, class TheJob>
void visit_image(Visitor& visit, TheJob& job) {
  visit("width", job.width, 1u, largest_image_side);
  visit("height", job.height, 1u, largest_image_side);
  visit("max_bounces", job.max_bounces, -1, int{PathSet::kMaxBounces});
  visit("pixel_sampling", job.pixel_sampling, 0u, finest_pixel_grid);
  visit("seed", job.seed);
}

template <class Visitor, class Device>
void visit_device(Visitor& visit, Device& device) {
  visit("name", device.selector);
  visit("threads", device.threads, 0, max_threads);
  visit("memory_limit_bytes", device.memory_limit_bytes);
  visit("allocation_limit_bytes", device.allocation_limit_bytes);
  visit("cache_folder", device.cache_dir);
  visit("use_cache", device.use_cache);
}

template <class Visitor, class TheJob>
void visit_program(Visitor& visit, TheJob& job) {
  visit("technique_folders", job.technique_folders);
  visit("verbose", job.verbose);
}

template <class Visitor, class Work>
void visit_render(Visitor& visit, Work& work) {
  visit("technique", work.technique);
  visit("parameters", work.parameters);
  visit("seconds", work.seconds);
  visit("iterations", work.iterations);
  visit("samples", work.samples);
  visit("work_iterations", work.work_iterations);
  visit("relmse", work.relmse);
  visit("reference", work.reference);
  visit("curve", work.curve);
  visit("output", work.output);
  visit("walk_frames", work.walk.frames, 0u, max_walk_frames);
  visit("walk_samples", work.walk.samples);
  visit("walk_reference_frames", work.walk.reference_frames);
  visit("walk_references", work.walk.references);
}

template <class Visitor, class Work>
void visit_reference(Visitor& visit, Work& work) {
  visit("path_set", work.path_set);
  visit("samples", work.samples);
  visit("relmse", work.relmse);
  visit("output", work.output);
  visit("round_samples", work.round_samples);
}

class Writer {
 public:
  template <class Value, class... Range>
  void operator()(const char* key, const Value& value, Range...) {
    json_[key] = form(value);
  }
  /// The number of stops, or "auto".
  void exposure(const char* key, const std::optional<float>& stops) {
    const bool automatic = stops && is_automatic(*stops);
    json_[key] = automatic ? ordered_json(exposure_text(*stops)) : form(stops);
  }
  const ordered_json& json() const { return json_; }

 private:
  template <class Value>
  static ordered_json form(const Value& value) {
    return value;
  }
  static ordered_json form(const fs::path& path) { return path.string(); }
  static ordered_json form(const std::vector<fs::path>& paths) {
    ordered_json list = ordered_json::array();
    for (const fs::path& path : paths) list.push_back(path.string());
    return list;
  }
  template <class Value>
  static ordered_json form(const std::optional<Value>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
  }
  /// [["name", "value"], …]: their order counts.
  static ordered_json form(const Parameters& parameters) {
    ordered_json list = ordered_json::array();
    for (const auto& [name, value] : parameters) list.push_back(ordered_json::array({name, value}));
    return list;
  }

  ordered_json json_ = ordered_json::object();
};

/// Reads the members of the object at `pointer`; finish() throws on unknown and on missing ones.
class Reader {
 public:
  Reader(const JsonFile& file, const json& object, std::string pointer)
      : file_(file), object_(object), pointer_(std::move(pointer)) {
    if (!object_.is_object()) file_.fail(pointer_, "must be an object");
  }

  template <class Value, class... Range>
  void operator()(const char* key, Value& value, Range... range) {
    if (const json* member = find(key)) read(*member, pointer_ + "/" + key, value, range...);
  }
  void exposure(const char* key, std::optional<float>& stops) {
    const json* member = find(key);
    if (!member || member->is_null()) return;
    const std::string at = pointer_ + "/" + key;
    if (member->is_string() && *member == exposure_text(exposure_automatic)) {
      stops = exposure_automatic;
    } else {
      stops = static_cast<float>(file_.number(*member, at));
    }
  }
  /// The member of that name, or null; finish() reports the first absent one.
  const json* find(const char* key) {
    keys_.emplace_back(key);
    const auto found = object_.find(key);
    if (found != object_.end()) return &*found;
    if (missing_.empty()) missing_ = key;
    return nullptr;
  }
  void finish() const {
    file_.check_keys(object_, pointer_, keys_);
    if (!missing_.empty()) file_.fail(pointer_, fmt::format("\"{}\" is missing", missing_));
  }

 private:
  void read(const json& member, const std::string& at, std::string& value) const { value = file_.text(member, at); }
  void read(const json& member, const std::string& at, fs::path& value) const { value = file_.text(member, at); }
  void read(const json& member, const std::string& at, bool& value) const {
    if (!member.is_boolean()) file_.fail(at, "must be true or false");
    value = member.get<bool>();
  }
  void read(const json& member, const std::string& at, double& value) const {
    value = file_.number(member, at);
    if (!(value >= 0)) file_.fail(at, "must not be below 0");
  }
  template <class Number>
  requires std::is_integral_v<Number>
  void read(const json& member, const std::string& at, Number& value, Number low = 0,
            Number high = std::numeric_limits<Number>::max()) const {
    const bool whole = member.is_number_integer() && (std::is_signed_v<Number> || member.is_number_unsigned());
    const bool inside =
        whole && (std::is_signed_v<Number> ? member.get<int64_t>() >= static_cast<int64_t>(low) &&
                                                 member.get<int64_t>() <= static_cast<int64_t>(high)
                                           : member.get<uint64_t>() >= low && member.get<uint64_t>() <= high);
    if (!inside) file_.fail(at, fmt::format("must be a whole number from {} to {}", low, high));
    value = member.get<Number>();
  }
  void read(const json& member, const std::string& at, std::optional<std::string>& value) const {
    if (!member.is_null()) value = file_.text(member, at);
  }
  void read(const json& member, const std::string& at, std::optional<double>& value) const {
    if (!member.is_null()) value = file_.number(member, at);
  }
  template <class Item>
  void read(const json& member, const std::string& at, std::vector<Item>& list) const {
    if (!member.is_array()) file_.fail(at, "must be an array");
    list.resize(member.size());
    for (size_t i = 0; i < list.size(); ++i) read(member[i], fmt::format("{}/{}", at, i), list[i]);
  }
  void read(const json& member, const std::string& at, std::pair<std::string, std::string>& pair) const {
    if (!member.is_array() || member.size() != 2) file_.fail(at, "must be [\"name\", \"value\"]");
    pair = {file_.text(member[0], at + "/0"), file_.text(member[1], at + "/1")};
  }

  const JsonFile& file_;
  const json& object_;
  std::string pointer_, missing_;
  std::vector<std::string> keys_;
};

template <class Visit>
ordered_json write(const Visit& visit) {
  Writer writer;
  visit(writer);
  return writer.json();
}

template <class Visit>
void read(const JsonFile& file, Reader& root, const char* key, const Visit& visit) {
  const json* member = root.find(key);
  if (!member) return;
  Reader reader(file, *member, fmt::format("/{}", key));
  visit(reader);
  reader.finish();
}

std::variant<RenderWork, ReferenceWork> read_work(const JsonFile& file, Reader& root) {
  if (!file.root().contains(reference_key)) {
    RenderWork work;
    read(file, root, render_key, [&](Reader& visit) { visit_render(visit, work); });
    return work;
  }
  if (file.root().contains(render_key))
    file.fail("", fmt::format("has both \"{}\" and \"{}\"", render_key, reference_key));
  ReferenceWork work;
  read(file, root, reference_key, [&](Reader& visit) { visit_reference(visit, work); });
  return work;
}

}  // namespace

std::string job_json(const Job& job) {
  ordered_json document = {{"schema", job_schema}};
  document["scene"] = write([&](Writer& visit) { visit_scene(visit, job); });
  document["image"] = write([&](Writer& visit) { visit_image(visit, job); });
  document["device"] = write([&](Writer& visit) { visit_device(visit, job.device); });
  document.update(write([&](Writer& visit) { visit_program(visit, job); }));
  if (const auto* render = std::get_if<RenderWork>(&job.work)) {
    document[render_key] = write([&](Writer& visit) { visit_render(visit, *render); });
  } else {
    document[reference_key] = write([&](Writer& visit) { visit_reference(visit, std::get<ReferenceWork>(job.work)); });
  }
  try {
    return document.dump(2) + "\n";
  } catch (const ordered_json::type_error&) {
    throw_error(ErrorClass::usage, "a name of a file or folder is not UTF-8: {}",
                document.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
  }
}

Job read_job(const fs::path& path) {
  const JsonFile file(path);
  check_schema(file, job_schema);
  Job job;
  Reader root(file, file.root(), "");
  root.find("schema");
  read(file, root, "scene", [&](Reader& visit) { visit_scene(visit, job); });
  read(file, root, "image", [&](Reader& visit) { visit_image(visit, job); });
  read(file, root, "device", [&](Reader& visit) { visit_device(visit, job.device); });
  visit_program(root, job);
  job.work = read_work(file, root);
  root.finish();
  return job;
}

}  // namespace lucarium
