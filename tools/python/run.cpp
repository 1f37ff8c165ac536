// SPDX-License-Identifier: Apache-2.0
#include "host/run/run.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <atomic>
#include <exception>

#include "tools/python/interrupts.h"
#include "tools/python/running.h"
#include "tools/python/scene.h"
#include "tools/python/simulation.h"

namespace malha::python {

namespace py = pybind11;
using namespace py::literals;

namespace {

py::dict run_into(const py::object& source, const std::filesystem::path& out, std::optional<long long> steps,
                  bool resume, int threads, const std::string& backend, const py::object& progress) {
  const Scene scene = scene_of(source, py::none());
  const SimulationOptions simulation_options = options_of(threads, backend);
  std::vector<std::string> warned;
  RunOptions options;
  options.out = out.string(), options.resume = resume;
  if (steps && (*steps < 1 || *steps > 1000000000))
    refuse("run", "steps", std::to_string(*steps), "a whole number from 1 to 1000000000");
  if (steps) options.steps = *steps;
  options.warn = [&](const std::string& line) { warned.push_back(line); };
  std::atomic<bool> stop{false};
  std::exception_ptr raised;  // by a signal or by `progress`; the run then ends as by Ctrl-C, with a checkpoint
  SignalPolling interrupts;
  const auto after_step = [&](const Progress& now) {
    if (Shutdown::is_pending()) stop = true;
    if (progress.is_none() && !interrupts.is_due() && !stop) return;
    const py::gil_scoped_acquire hold;
    try {
      Shutdown::exit_thread_if_pending();
      if (!progress.is_none() && ends_loop(progress(now.step, now.steps, now.time))) stop = true;
      interrupts.poll();
    } catch (...) {
      raised = std::current_exception(), stop = true;
    }
  };
  RunResult result;
  {
    const Shutdown::Guard inside;
    const py::gil_scoped_release release;
    result = run(scene, simulation_options, options, after_step, stop);
  }
  if (raised) std::rethrow_exception(raised);
  return py::dict("complete"_a = result.complete, "failed_expectations"_a = result.failed_expectations,
                  "warnings"_a = warned, "summary"_a = result.summary);
}

}  // namespace

void add_run(py::module_& module) {
  module.def(
      "run", &run_into, "scene"_a, "out"_a, py::kw_only(), "steps"_a = py::none(), "resume"_a = false, "threads"_a = 0,
      "backend"_a = "openmp", "progress"_a = py::none(),
      "A whole run, as by `malha run`: report.json, a checkpoint, and the frames, pictures and page that the\n"
      "scene's \"outputs\" ask for, in the folder out. steps: fewer than the scene's duration has. resume: goes on\n"
      "from the folder's checkpoint. progress(step, steps, time) is called after each step, and ends the run where\n"
      "it returns False, as Ctrl-C does: after a step, with a checkpoint. Returns a dict: complete, "
      "failed_expectations, warnings, "
      "summary.");
}

}  // namespace malha::python
