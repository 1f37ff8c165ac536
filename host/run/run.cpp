// SPDX-License-Identifier: Apache-2.0
#include "host/run/run.h"

#include <algorithm>
#include <chrono>
#include <iterator>

#include "host/base/file.h"
#include "host/base/stopwatch.h"
#include "host/output/frame_vertices.h"
#include "host/output/frames.h"
#include "host/output/gallery.h"
#include "host/output/page.h"
#include "host/output/results.h"
#include "host/report/amplification.h"
#include "host/report/momentum_drift.h"
#include "host/report/overstretched.h"
#include "host/report/report.h"
#include "host/report/warnings.h"
#include "host/report/whole_steps.h"
#include "host/run/summary.h"
#include "host/solver/solver.h"
#include "malha/text.h"

namespace malha {

namespace {

constexpr int kCountEvery = 16;  // steps between counts of crossings, which take about a hundredth of the time

/// Writers of the results of one run.
class RunOutputs {
 public:
  /// A new run replaces the results of an earlier one; a resumed run continues after `frames_before` frames.
  RunOutputs(const Simulation& simulation, const Results& results, std::int64_t last,
             std::optional<std::int64_t> frames_before, const RunOptions& options, const std::atomic<bool>& stop)
      : simulation_(simulation),
        spec_(simulation.model().scene.outputs),
        results_(results),
        on_activity_(options.on_activity),
        checkpoint_seconds_(options.checkpoint_seconds),
        stop_(stop),
        frames_(frames_before.value_or(0)) {
    if (!frames_before) results.remove();
    if (spec_.every > 0) open_writer();
    if (spec_.picture) gallery_.emplace(simulation, results, simulation.steps(), last, &stop);
    if (spec_.page)
      page_.emplace(simulation);
    else
      std::filesystem::remove(results.page);  // the page of the run before it was resumed
    if (!frames_before) write_frame();
    draw_picture();
  }

  void after_step(double step_ms) {
    write_frame();
    draw_picture();
    if (page_) page_->add_frame(step_ms);
    if (saves_checkpoint_) checkpoint();
  }

  /// Decides whether a checkpoint follows this step; called once a step, before after_step().
  bool decide_checkpoint() { return saves_checkpoint_ = checkpoint_is_due(); }

  void checkpoint() {
    report_activity("writing a checkpoint");
    const double took = seconds([&] { simulation_.save_checkpoint(results_.checkpoint, frames_); });
    pause_ = std::max(checkpoint_seconds_, kPausePerWrite * took), saved_at_ = Clock::now();
  }

  /// Writes the report, and the page, whose last frame is the present state unless the run diverged.
  void report(const std::string& status, const std::vector<std::string>& notes, bool diverged = false) {
    report_activity("writing the report");
    const std::string text = report_json(status, notes, simulation_.model(), simulation_.solver(),
                                         simulation_.threads(), simulation_.times(), results_.folder.string());
    write_whole(results_.report, text);
    if (!page_) return;
    report_activity("writing the page");
    if (!diverged) page_->finish();
    std::vector<std::string> lines = warnings(simulation_.model());
    lines.insert(lines.end(), notes.begin(), notes.end());
    page_->write(results_.page, text, lines);
  }

  /// The line about the page in the summary; "" without a page.
  std::string page_summary() const { return page_ ? "replay      " + page_->kept() + "\n" : ""; }

  void finish_frames() {
    if (!writer_) return;
    report_activity("writing the frames");
    writer_->finish();
  }

  void storyboard() const {
    if (!gallery_) return;
    report_activity("writing the storyboard");
    gallery_->write_storyboard();
  }

  void picture() const {
    if (!gallery_) return;
    report_activity("drawing a picture");
    gallery_->finish(simulation_.time(), simulation_.positions());
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kPausePerWrite = 100;  // checkpoints at default intervals take at most 1 % of the time

  void report_activity(const char* what) const {
    if (on_activity_) on_activity_(what);
  }

  bool checkpoint_is_due() const {
    if (!spec_.checkpoint_every) return std::chrono::duration<double>(Clock::now() - saved_at_).count() > pause_;
    const std::int64_t every = *spec_.checkpoint_every;
    return every > 0 && simulation_.steps() % every == 0;
  }

  void open_writer() {
    tears_ = simulation_.tears();
    vertices_.emplace(simulation_.model().render_mesh);
    writer_.emplace(results_.frames, spec_.formats, vertices_->topology(simulation_.model()),
                    static_cast<int>(frames_));
  }

  bool frame_is_due() const { return writer_ && simulation_.steps() % spec_.every == 0; }
  void write_frame() {
    if (!frame_is_due()) return;
    if (simulation_.tears() != tears_) open_writer();  // a tear has changed the mesh
    report_activity("writing a frame");
    writer_->write(simulation_.time(), vertices_->vertex_positions(simulation_.positions()),
                   vertices_->vertex_velocities(simulation_.velocities()));
    ++frames_;
  }

  void draw_picture() {
    if (!gallery_ || stop_ || !gallery_->is_due(simulation_.steps())) return;
    report_activity("drawing a picture");
    gallery_->draw_if_due(simulation_.steps(), simulation_.time(), simulation_.positions());
  }

  const Simulation& simulation_;
  const OutputSpec spec_;
  Results results_;
  const std::function<void(const char*)>& on_activity_;
  double checkpoint_seconds_, pause_ = checkpoint_seconds_;  // s of the clock between checkpoints
  Clock::time_point saved_at_ = Clock::now();
  const std::atomic<bool>& stop_;
  bool saves_checkpoint_ = false;
  std::int64_t frames_;  // written so far, by this run and those that it resumes
  int tears_ = 0;        // tears at the last open_writer()
  std::optional<FrameVertices> vertices_;
  std::optional<FrameWriter> writer_;
  std::optional<Gallery> gallery_;
  std::optional<Page> page_;
};

/// Returns a warning if edges crossed triangles where the scene does not allow it; otherwise "".
std::string crossing_warning(const Simulation& simulation) {
  const Scene& scene = simulation.model().scene;
  const std::int64_t most = simulation.times().most_crossings;
  if (most == 0 || scene.expect.max_crossings || (scene.self_collision && scene.self_collision->ignores_crossings))
    return "";
  return "collision: up to " + counted(most, "crossing") +
         " of edges with triangles were counted at one time; take more substeps, and see "
         "scenes/accuracy.md for the collisions that can fail";
}

/// Returns a warning if kinematic particles may have passed through bodies; otherwise "".
std::string kinematic_penetration_warning(const Simulation& simulation) {
  const auto& self = simulation.solver().facts().self;
  if (!self || self->substeps_kinematic_penetration == 0) return "";
  return "self-collision: in " + counted(self->substeps_kinematic_penetration, "substep") +
         " pins or moving objects may have passed through a body that could not move out of their way; move them "
         "more slowly, or take more substeps";
}

}  // namespace

void check_frames(const Simulation& simulation, std::int64_t last, std::optional<std::int64_t> before) {
  const Scene& scene = simulation.model().scene;
  const std::int64_t every = scene.outputs.every;
  if (every == 0 || std::ranges::count(scene.outputs.formats, "glb") == 0) return;
  const std::int64_t more = last / every - simulation.steps() / every;
  const Model& model = simulation.model();
  const std::size_t vertices = FrameVertices(model.render_mesh).count() + deforming_vertices(model.environment);
  check_glb(scene, vertices, before.value_or(1) + more);
}

RunResult run(const Scene& scene, const SimulationOptions& simulation_options, const RunOptions& options,
              const std::function<void(const Progress&)>& progress, const std::atomic<bool>& stop) {
  const Results results(options.out);
  std::optional<FolderLock> lock;
  if (std::filesystem::is_directory(results.folder)) lock.emplace(results.folder);
  Simulation simulation(scene, simulation_options);
  std::optional<std::int64_t> frames;
  if (options.resume) frames = simulation.load_checkpoint(results.checkpoint);
  const std::int64_t whole = whole_steps(scene.duration, scene.solver.dt);
  const std::int64_t last = options.steps.value_or(whole);
  if (simulation.steps() >= last)
    refuse(results.checkpoint, "", "the state of step " + std::to_string(simulation.steps()),
           "one from before the end of this run, step " + std::to_string(last));
  if (frames > simulation.steps() + 1)
    refuse(results.checkpoint, "frames", std::to_string(*frames),
           "at most one of the start and of each of its " + std::to_string(simulation.steps()) + " steps");
  check_frames(simulation, last, frames);

  const std::string rounding =
      options.steps ? options.rounding : rounding_of("the duration", scene.duration, scene.solver.dt);
  if (options.warn) {
    for (const std::string& line : warnings(simulation.model())) options.warn(line);
    const Model& model = simulation.model();
    const double affordable = amplification_steps_of_run(last - simulation.steps());
    for (const std::string& line :
         growth_warnings(model, measure_amplifications(model, affordable, simulation.threads())))
      options.warn(line);
    if (!rounding.empty()) options.warn(rounding);
  }
  const MomentumDrift momenta(simulation);
  if (options.ready) options.ready();
  make_folder(results.folder);
  if (!lock) lock.emplace(results.folder);
  RunOutputs outputs(simulation, results, last, frames, options, stop);
  try {
    while (simulation.steps() < last && !stop) {
      const double took = seconds([&] { simulation.step(); });
      if (outputs.decide_checkpoint() || simulation.steps() == last) simulation.check_divergence();
      if (scene.expect.max_crossings || simulation.steps() % kCountEvery == 0 || simulation.steps() == last)
        simulation.count_crossings();
      outputs.after_step(took * 1000);
      progress({simulation.steps(), last, simulation.time(), took * 1000});
    }
    if (simulation.steps() < last) simulation.check_divergence(), simulation.count_crossings();
  } catch (const Diverged& error) {
    outputs.report("diverged", {error.what()}, true);
    outputs.finish_frames();
    if (!stop) outputs.storyboard();
    throw;
  } catch (const DeviceLost&) {
    outputs.finish_frames();  // the state is lost with the device
    throw;
  }
  RunResult result;
  result.interrupted = simulation.steps() < last;
  result.complete = simulation.steps() == whole;
  if (result.complete) result.failed_expectations = simulation.failed_expectations();
  outputs.checkpoint();
  outputs.finish_frames();
  std::vector<std::string> notes = result.failed_expectations;
  if (!rounding.empty()) notes.push_back(rounding);
  std::vector<std::string> known = momenta.warnings(simulation);
  std::ranges::copy(overstretch_warnings(simulation), std::back_inserter(known));
  for (const std::string& line : {kinematic_penetration_warning(simulation), crossing_warning(simulation)})
    if (!line.empty()) known.push_back(line);
  for (const std::string& line : known) {
    if (options.warn) options.warn(line);
    notes.push_back(line);
  }
  outputs.report(result.interrupted ? "interrupted" : "finished", notes);
  // This includes a run that was stopped while the picture of its last step was drawn.
  result.pictures_missing = scene.outputs.picture && stop;
  if (!result.pictures_missing) outputs.storyboard(), outputs.picture();
  result.summary = summary(simulation) + outputs.page_summary();
  return result;
}

}  // namespace malha
