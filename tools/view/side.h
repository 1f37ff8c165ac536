// SPDX-License-Identifier: Apache-2.0
// One of the simulations of the window, and what is done to it. Only the solver's thread uses it.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "malha/simulation.h"
#include "tools/view/looks.h"

namespace malha::view {

/// A particle that is pulled or held by hand, and the point (m) that it is to be at.
struct Grip {
  Vec3 to;
  bool firm = false;  // held there, as by a pin
};

class Side {
 public:
  /// Throws InputError.
  Side(const Scene& scene, const SimulationOptions& options);

  /// Lays the scene out anew: at its start, or where the present one is. After an exception all is as it was.
  void change(const Scene& scene, bool from_start);

  /// To a scene that it had before, whose state is to come.
  void change_back(const std::shared_ptr<const Scene>& scene);

  /// One step. Throws Diverged.
  void step();
  /// Frames of all its substeps but the last, which is the step.
  std::vector<std::shared_ptr<const Frame>> step_in_parts();
  std::size_t bytes_of_parts() const;

  /// Measured: with what takes long to know.
  std::shared_ptr<const Frame> frame(bool measured);

  /// What this look, and those asked for before, need of the present bodies.
  std::shared_ptr<const Looks> looks(Look look);

  /// By hand; `firm`: where it is to stay. Throws InputError for a particle that cannot be taken.
  void grip(int particle, const Vec3& to, bool firm);
  void release(int particle);
  void release_all();
  const std::map<int, Grip>& grips() const { return grips_; }

  /// How many vertices were parted.
  int cut(const std::vector<Edge>& edges);

  /// Saves the scene, and the present state for malha run --resume.
  void save(const std::string& scene_path, const std::string& checkpoint_path) const;

  std::string save_state() const { return simulation_->save_state(); }
  /// To a state since the last change.
  void restore_state(const std::string& state);

  const Scene& scene() const { return *scene_; }
  std::shared_ptr<const Scene> shared_scene() const { return scene_; }
  double dt() const { return scene_->solver.dt; }
  double time() const { return simulation_->time(); }
  int threads() const { return simulation_->threads(); }
  const std::vector<std::string>& warnings() const { return warnings_; }
  double set_up_ms() const { return set_up_ms_; }

  /// The particle that a run which diverged lost: the first without a finite place, else the fastest.
  int lost() const;

 private:
  void note_body();

  SimulationOptions options_;
  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<Simulation> simulation_;
  std::shared_ptr<const Body> body_;
  std::shared_ptr<const std::vector<EnvironmentMesh>> environment_;
  std::shared_ptr<const Looks> looks_;
  std::vector<std::string> warnings_;
  std::map<int, Grip> grips_;
  int tears_ = 0;
  double set_up_ms_ = 0, step_ms_ = 0;
  std::array<double, kPassNames.size()> before_{}, pass_ms_{};
};

/// The same of a state that it had.
void save_state(const Scene& scene, const std::string& state, const SimulationOptions& options,
                const std::string& scene_path, const std::string& checkpoint_path);

}  // namespace malha::view
