// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lucarium/base/seed.h"
#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/film/film.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/scene.h"
#include "lucarium/services/path_set.h"
#include "lucarium/technique/capabilities.h"
#include "lucarium/technique/cost.h"
#include "lucarium/technique/parameters.h"

namespace lucarium {

class Bvh;
class StateReader;
class StateWriter;

/// Settings that belong to the framework and are the same for all techniques of a comparison.
struct RenderSettings {
  uint32_t width = 640, height = 360;
  uint32_t pixel_sampling = 0;  ///< LUCARIUM_PIXEL_JITTER, _CENTRE, or n ≥ 2 for n×n
  int max_bounces = -1;         ///< -1: unlimited
  uint64_t seed = 1;
  SceneCamera camera;
};

/// The settings as kernels see them: camera for the image's aspect, size, pixel sampling, seed, bounces.
Frame make_frame(const RenderSettings& settings);

/// Everything a technique works with. All references outlive the technique.
struct TechniqueContext {
  std::shared_ptr<Device> device;
  KernelScheduler& scheduler;
  const Scene& scene;
  const SceneBuffers& scene_buffers;
  /// The scene's BVH, built at the first call (services/bvh.h) and kept up to date by the framework.
  std::function<Bvh&()> bvh;
  const RenderSettings& settings;
  /// Reports the progress of a prepare() or update() that takes seconds: `fraction` of the work (negative: unknown),
  /// and the present stage. May be called at any rate, from the calling thread; never empty.
  std::function<void(double fraction, const std::string& stage)> progress;
  /// What load_state() will be given behind prepare(), or null: prepare() need not compute what that brings, and may
  /// read it. Valid until load_state() has returned.
  const StateReader* state = nullptr;
};

/// Layers that only some values of parameters bring.
struct OptionalLayers {
  std::string parameters;  ///< in words of the command line, such as "debug=on"
  std::vector<std::string> names;
};

/// What shows the insides of one pixel: the names of two parameters, and of the layer that they bring.
struct PixelLayer {
  std::string x_parameter, y_parameter, layer;
};

struct TechniqueInfo {
  std::string name, version, summary;
  std::string citation;  ///< of the paper, or empty
  Capabilities capabilities;
  std::vector<std::string> layers;  ///< additive ones and further ones that it writes by default
  std::vector<OptionalLayers> optional_layers = {};
  PixelLayer pixel_layer = {};  ///< empty names: there is none
  /// Parameters (name, value) with which `lucarium check` takes at most 4 processor minutes; empty: the defaults do.
  std::vector<std::pair<std::string, std::string>> check_parameters;
  /// Set besides where Oclgrind interprets every kernel, a thousand times slower: the smallest sizes.
  std::vector<std::pair<std::string, std::string>> oclgrind_parameters = {};
};

/// State of progress after an iterate().
struct IterationResult {
  bool converged = false;  ///< nothing more to do: all is done, or accurate enough
  double progress = 0;     ///< of a known amount of work, 0…1; negative: unknown
  uint64_t samples = 0;    ///< per pixel so far, or the technique's own unit
  std::string
      phase;  ///< "propagate", "gather"; shown beside the progress. When converged, why: "all 200 rounds are done"
  bool visible = false;  ///< resolve() has a picture worth keeping though `samples` is 0: a coarse or an unfinished one
  /// Of view-independent techniques: what does not depend on the camera is finished, or held (hold_light()). From then
  /// on an iteration is a sample for the camera alone, and the image after n of them since the camera moved is always
  /// the same.
  bool light_done = false;
};

/// The first surface that is seen through the middle of a pixel.
struct SeenPoint {
  uint32_t x = 0, y = 0;      ///< the pixel, from the left and the top
  uint32_t triangle = 0;      ///< of the whole scene (SceneBuffers)
  float b1 = 0, b2 = 0;       ///< barycentric coordinates there
  bool front = true;          ///< of the triangle is seen
  glm::vec3 position{0};      ///< world space [m]
  glm::vec3 normal{0, 1, 0};  ///< geometric, towards the eye
};

/// (name, value with its unit), for people: ("texel side", "17 of 4096").
using InspectedValues = std::vector<std::pair<std::string, std::string>>;

/// A technique instance. Life cycle: construct → (set parameters) → prepare → { update | iterate | resolve | reset }*.
/// Same seed, device and parameters: the same image, bit for bit, whatever the clock says.
class Technique {
 public:
  virtual ~Technique() = default;

  virtual ParameterTable& parameters() = 0;
  /// Which paths are computed with the current parameters on this scene; callable before prepare().
  virtual PathSet path_set(const Scene& scene, const RenderSettings& settings) const = 0;
  /// Limitations on this scene, one line each; empty: none.
  virtual std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const = 0;
  /// Upper bound of its systematic error with the current parameters, measured as Capabilities::bias is; `declared`:
  /// that. Callable before prepare(). `lucarium check` holds the technique to it.
  virtual double admitted_bias(double declared) const { return declared; }
  /// Device bytes it will allocate, stated before it does.
  virtual size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const = 0;
  /// Seconds until the first picture with all its light, with the current parameters on an idle machine: prepare() and
  /// the first iterations, without upload, BVH and compilation. A model of its work, so that a budget of time can be
  /// planned (budget_plan.h): the same arguments, the same seconds. 0: too little to plan for.
  virtual double estimate_seconds(const Scene&, const RenderSettings&, const ComputePower&) const { return 0; }
  /// Parameters that a plan may lower, one step each in round-robin order.
  virtual std::vector<ParameterSaving> savings(const Scene&, const RenderSettings&) const { return {}; }
  /// (name, value) of the parameters by which it ends, with which it does not, but gets more accurate as long as it is
  /// let. A budget of time is used to its end with them. By default it never ends by itself.
  virtual std::vector<std::pair<std::string, std::string>> endless() const { return {}; }

  /// Compiles programs, allocates, records schedules; short. Long precomputation is done in iterations, or reports its
  /// progress and ends soon with Error{interrupted} when interrupt_requested() (base/interrupt.h).
  virtual void prepare(const TechniqueContext& context) = 0;
  /// The scene or camera changed; buffers are already up to date.
  virtual void update(const SceneChange& change) = 0;
  /// Does one iteration (aim: ≤ 250 ms of device time; its size never depends on a clock). Where the scheduler's run()
  /// says `cancelled`, the state must be what it was before the iteration, so that resolve() gives a true image.
  virtual IterationResult iterate() = 0;
  /// Fills the film's layers from the current state; legal after any iterate, changes nothing.
  virtual void resolve(Film& film) = 0;
  virtual void reset(uint64_t seed) = 0;
  /// Launches every kernel once without touching state, so that drivers compile outside the clocks.
  virtual void warm_up() = 0;

  // ---- What does not depend on the camera, kept, saved and loaded.

  /// From now on what does not depend on the camera stays as it is, however unfinished: iterations are samples for the
  /// camera. Ends with a change of anything but the camera, and with reset(). By default nothing is held.
  virtual void hold_light() {}
  /// Of techniques with Capabilities::resizes: until it is called again, iterations are samples for the camera alone,
  /// or not; the light then goes on where it was. A change of the camera comes next. By default it never rests.
  virtual void rest_light(bool) {}
  /// Why there is no state to save, in words that follow the technique's name: "keeps no light between pictures".
  /// Empty: save_state() and load_state() work with the current parameters. Callable before prepare().
  virtual std::string state_refusal() const { return "keeps nothing from picture to picture that a file could hold"; }
  /// Names of parameters that may differ between saving and loading, since the state does not depend on them.
  virtual std::vector<std::string> parameters_of_view() const { return {}; }
  /// Puts everything that does not depend on the camera. Legal after any iterate(); changes nothing. What chunks mean
  /// is stated by TechniqueInfo::version: files of another version are refused by the framework, as are those of
  /// another scene, path set or other parameters.
  virtual void save_state(StateWriter& chunks);
  /// Takes it, behind prepare() and warm_up(): light is held, as by hold_light(), and images have the bits that they
  /// would have had from the technique that saved. Values are checked (NaN, indices): StateReader::fail(). When it
  /// throws, the technique is not used any more.
  virtual void load_state(const StateReader& chunks);

  /// What it holds of the light at a point. Legal after any iterate(); changes nothing.
  virtual InspectedValues inspect(const SeenPoint&) const { return {}; }
  /// Counters for the report ("rays", "paths", "nonfinite"), cumulative.
  virtual std::map<std::string, double> counters() const { return {}; }
};

}  // namespace lucarium
