// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/technique/budget_plan.h"
#include "lucarium/technique/plugin.h"

namespace lucarium {

class StateFile;

/// How long to render; whichever ends first, 0: no limit. Checked between iterations.
struct RenderBudget {
  double seconds = 0;  ///< of iterating
  uint64_t iterations = 0;
  uint64_t samples = 0;  ///< per pixel
};

/// Refuses settings that a technique does not declare: image size, bounces, pixel sampling. Throws Error.
void check_settings(const TechniqueInfo& info, const RenderSettings& settings);

/// A scene and what is made of it on the device, for sessions that share it. It outlives none of the device's users:
/// whoever keeps one keeps the device.
struct SceneOnDevice;
std::shared_ptr<SceneOnDevice> share_scene(Scene scene);

/// One technique on one scene on one device: owns scene buffers, BVH, scheduler and the technique, in the right order,
/// with clocks. The programs render and compare, and tests, all go through it.
class RenderSession {
 public:
  /// Wall times [s] of the present state of the scene; each leaves out what the others count.
  struct Clocks {
    double upload = 0, bvh = 0, compile = 0, prepare = 0, warm_up = 0, iterate = 0;
    double light = 0;  ///< of finish_light()
    double load = 0;   ///< of a saved state
    /// Processor times [s] of all threads of the process: of what `upload`, `bvh` and `prepare` count, and of
    /// `iterate`. Of a device that is no CPU they say what the host had to do.
    double prepare_processor = 0, iterate_processor = 0;
  };

  /// How far the work before the first iteration is: `fraction` (negative: unknown), and what is being done.
  using OnPreparing = std::function<void(double fraction, const std::string& stage)>;

  /// Applies `parameters` (name, value), checks capabilities and memory, uploads the scene, prepares and warms up.
  /// `on_preparing` is kept, for later changes of the scene. Parameters that are not given are planned for
  /// `time` (technique/budget_plan.h); without a budget they have their defaults. `state` (null:
  /// none): what the technique begins with (Technique::load_state). Throws Error{usage} or {input} where it belongs to
  /// something else (session/saved_state.h).
  RenderSession(std::shared_ptr<Device> device, Scene scene, const TechniqueType& type, RenderSettings settings,
                const std::vector<std::pair<std::string, std::string>>& parameters = {}, OnPreparing on_preparing = {},
                const TimeBudget& time = {}, const StateFile* state = nullptr);
  /// The same on a scene that sessions share, each with its own technique and size: its buffers and its BVH serve all
  /// of them. While there are several none of them changes the scene (set_time, change_scene).
  RenderSession(std::shared_ptr<Device> device, std::shared_ptr<SceneOnDevice> scene, const TechniqueType& type,
                RenderSettings settings, const std::vector<std::pair<std::string, std::string>>& parameters = {},
                OnPreparing on_preparing = {}, const TimeBudget& time = {}, const StateFile* state = nullptr);
  ~RenderSession();

  Technique& technique();
  const Scene& scene() const;
  const RenderSettings& settings() const;
  KernelScheduler& scheduler();
  const Clocks& clocks() const;
  const std::vector<std::string>& limitations() const;
  const BudgetPlan& plan() const;  ///< of `time`

  IterationResult iterate();
  /// Iterates until the budget is used up, converged or interrupted, or `on_progress`, called after each iteration,
  /// returns false. Returns whether it was interrupted.
  bool run(const RenderBudget& budget, const std::function<bool(const IterationResult&)>& on_progress = {});
  uint64_t iterations() const;  ///< whole ones: one that was cancelled does not count
  IterationResult last() const;

  /// Of a view-independent technique: iterates until what does not depend on the camera is finished; the camera's
  /// samples then begin at the first one. The picture after n of them then depends on nothing that came before. Of
  /// others, and where it is finished already, it does nothing. Returns whether it was interrupted.
  bool finish_light(const std::function<void(const IterationResult&)>& on_progress = {});
  /// From now on what does not depend on the camera stays as it is, finished or not (Technique::hold_light).
  void hold_light();
  /// Writes what the technique has found that does not depend on the camera; replaces what is there. Throws
  /// Error{usage} for a technique that has no state.
  void save_state(const std::filesystem::path& file, bool compress);

  /// Starts over from zero samples with another seed; the clocks run on.
  void restart(uint64_t seed);
  /// Changes the time of the scene's animation, or the camera, and updates buffers, BVH and technique. Clocks and
  /// iterations then count from there. A change that the technique does not declare is refused: nothing has changed.
  /// View-independent techniques keep their data where nothing but the camera changes, or nothing at all.
  void set_time(double seconds);
  void set_camera(const SceneCamera& camera);
  /// The camera with another size of the image, of techniques with Capabilities::resizes; what does not depend on the
  /// camera stays. `moving`: pictures come first, and the light goes on only with a view that does not move. Throws
  /// Error for techniques that cannot, and for sizes that are refused.
  void set_view(const SceneCamera& camera, uint32_t width, uint32_t height, bool moving);
  /// The same for any change: `edit` alters a copy of the scene and says what it altered.
  void change_scene(const std::function<SceneChange(Scene&)>& edit);

  /// Film with layers and metadata (technique, parameters, those that were planned, scene hash, samples, seconds,
  /// seed, device, driver, version). Throws Error{technique} for NaN or infinite values, naming the first; negative
  /// ones are a warning.
  Film resolve();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
