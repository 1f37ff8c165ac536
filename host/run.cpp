#include "host/run.h"

#include <cmath>
#include <filesystem>

#include "host/file.h"
#include "host/frames.h"
#include "host/gallery.h"
#include "host/stopwatch.h"

namespace malha {

namespace {

FrameTopology topology(const Model& model) {
  const Appearance& look = model.look;
  FrameTopology result{look.faces, look.lines, {}, {}};
  std::vector<bool> used(look.points.size(), false);
  for (const Quad& face : look.faces)
    for (int corner : face)
      if (corner >= 0) used[corner] = true;
  for (const Edge& line : look.lines) used[line[0]] = used[line[1]] = true;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (!used[i]) result.loose.push_back(static_cast<int>(i));
  for (const Vec3& x : look.points) result.rest.push_back({float(x[0]), float(x[1]), float(x[2])});
  return result;
}

std::vector<std::array<float, 3>> to_float(const std::vector<Vec3>& values) {
  std::vector<std::array<float, 3>> result;
  for (const Vec3& a : values) result.push_back({float(a[0]), float(a[1]), float(a[2])});
  return result;
}

/// What one run writes while it goes.
class Outputs {
 public:
  Outputs(const Simulation& simulation, const std::filesystem::path& folder, std::int64_t last)
      : simulation_(simulation), spec_(simulation.model().scene.outputs), folder_(folder) {
    make_folder(folder);
    const bool resumed = simulation.steps() > 0;
    if (!resumed) {
      std::filesystem::remove(report_path());
      std::filesystem::remove(checkpoint_path());
    }
    if (spec_.every > 0) {
      const int written = resumed ? static_cast<int>(simulation.steps() / spec_.every) + 1 : 0;
      frames_.emplace(folder / "frames", spec_.formats, topology(simulation.model()), written);
    }
    if (spec_.picture) gallery_.emplace(simulation.model(), folder, last, simulation.threads());
    if (!resumed) after_step();
  }

  void after_step() {
    const std::int64_t step = simulation_.steps();
    if (frames_ && step % spec_.every == 0)
      frames_->write(simulation_.time(), to_float(simulation_.positions()), to_float(simulation_.velocities()));
    if (gallery_ && gallery_->wants(step)) gallery_->look(step, simulation_.time(), simulation_.positions());
    if (step > 0 && spec_.checkpoint_every > 0 && step % spec_.checkpoint_every == 0) checkpoint();
  }

  void checkpoint() const { simulation_.save_checkpoint(checkpoint_path()); }

  std::string finish(const std::string& status) {
    if (gallery_ && status != "diverged") gallery_->finish(simulation_.time(), simulation_.positions());
    std::string report = simulation_.report(status);
    write_whole(report_path(), report);
    return report;
  }

 private:
  std::filesystem::path report_path() const { return folder_ / "report.json"; }
  std::filesystem::path checkpoint_path() const { return folder_ / "checkpoint.malha"; }

  const Simulation& simulation_;
  const OutputSpec& spec_;
  std::filesystem::path folder_;
  std::optional<FrameWriter> frames_;
  std::optional<Gallery> gallery_;
};

}  // namespace

RunResult run(const Scene& scene, const SimulationOptions& simulation_options, const RunOptions& options,
              const std::function<void(const Progress&)>& progress, const std::atomic<bool>& stop) {
  Simulation simulation(scene, simulation_options);
  const std::filesystem::path folder = options.out;
  if (options.resume) simulation.load_checkpoint(folder / "checkpoint.malha");
  const std::int64_t whole = std::max<std::int64_t>(1, std::llround(scene.duration / scene.solver.dt));
  const std::int64_t last = options.steps.value_or(whole);
  if (simulation.steps() >= last)
    refuse(folder / "checkpoint.malha", "", "step " + std::to_string(simulation.steps()) + " reached already",
           "a later end than step " + std::to_string(last));

  RunResult result;
  Outputs outputs(simulation, folder, last);
  try {
    while (simulation.steps() < last && !stop) {
      const double took = seconds([&] { simulation.step(); });
      outputs.after_step();
      progress({simulation.steps(), last, simulation.time(), took * 1000});
    }
  } catch (const Diverged&) {
    outputs.finish("diverged");
    throw;
  }
  result.interrupted = simulation.steps() < last;
  result.complete = simulation.steps() >= whole;
  if (result.interrupted) outputs.checkpoint();
  if (result.complete) result.unmet = simulation.unmet();
  result.report = outputs.finish(result.interrupted ? "interrupted" : "finished");
  return result;
}

}  // namespace malha
