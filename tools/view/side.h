// SPDX-License-Identifier: Apache-2.0
// One simulation of the window with the operations on it. Only the solver's thread uses it.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "malha/simulation.h"
#include "tools/view/visual_fields.h"

namespace malha::view {

/// Handle of a particle: the point (m) to which it is pulled, or where it is held.
struct Handle {
  Vec3 to;
  bool is_held = false;  // held like a pin
};

class Side {
 public:
  /// Throws InputError.
  Side(const Scene& scene, const SimulationOptions& options);

  /// Sets up another scene at its start, or with the state of the present one. An exception leaves everything
  /// unchanged.
  void change(const Scene& scene, bool from_start);

  /// Returns to an earlier scene, whose state is restored afterwards.
  void restore_scene(const std::shared_ptr<const Scene>& scene);

  /// One step. Throws Diverged.
  void step();
  /// Takes a step and returns the frames of all its substeps but the last, which is the end of the step.
  std::vector<std::shared_ptr<const Frame>> step_by_substeps();
  std::size_t bytes_of_substeps() const;

  /// Returns the present frame. `measured`: with measures, which take long.
  std::shared_ptr<const Frame> frame(bool measured);

  /// Returns the visual fields of the present bodies, with this one and all that were requested before.
  std::shared_ptr<const VisualFields> fields(VisualField field);

  /// Sets a handle that pulls a particle, or holds it (`is_held`). Throws InputError for a particle that cannot have
  /// one.
  void set_handle(int particle, const Vec3& to, bool is_held);
  void release(int particle);
  void release_all();
  const std::map<int, Handle>& handles() const { return handles_; }

  /// Cuts along edges and returns the number of split vertices.
  int cut(const std::vector<Edge>& edges);

  /// Saves the scene, and the present state for malha run --resume.
  void save(const std::string& scene_path, const std::string& checkpoint_path) const;

  std::string save_state() const { return simulation_->save_state(); }
  /// Restores a state since the last change of the scene.
  void restore_state(const std::string& state);

  const Scene& scene() const { return *scene_; }
  std::shared_ptr<const Scene> shared_scene() const { return scene_; }
  double dt() const { return scene_->solver.dt; }
  double time() const { return simulation_->time(); }
  int threads() const { return simulation_->threads(); }
  const std::vector<std::string>& warnings() const { return warnings_; }
  double set_up_ms() const { return set_up_ms_; }

  /// Returns the particle that shows a divergence: the first whose position is not finite, otherwise the fastest.
  int diverged_particle() const;

 private:
  void update_body();

  SimulationOptions options_;
  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<Simulation> simulation_;
  std::shared_ptr<const Body> body_;
  std::shared_ptr<const std::vector<EnvironmentMesh>> environment_;
  std::shared_ptr<const VisualFields> fields_;
  std::vector<std::string> warnings_;
  std::map<int, Handle> handles_;
  int tears_ = 0;
  double set_up_ms_ = 0, step_ms_ = 0;
  std::array<double, kPassNames.size()> before_{}, pass_ms_{};
};

/// Saves a scene, and a stored state of it for malha run --resume.
void save_state(const Scene& scene, const std::string& state, const SimulationOptions& options,
                const std::string& scene_path, const std::string& checkpoint_path);

}  // namespace malha::view
