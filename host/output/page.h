// SPDX-License-Identifier: Apache-2.0
// The page of a run: one HTML file that replays it in a browser, without a server or a network.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/attachments/pose.h"
#include "host/fields/fields.h"
#include "host/output/page_pack.h"
#include "malha/simulation.h"

namespace malha {

/// Frames of the present run, at most as large as the scene's outputs.page allows. A frame is stored at the first step
/// and then at a fixed interval, at most 60 a simulated second. Where they grow too large, every second frame is
/// removed and the interval doubles, so that their number follows from the limit alone.
class Page {
 public:
  /// The scene must name outputs.page.
  explicit Page(const Simulation& simulation);

  /// Stores a frame if one is due; called after every step with the step's duration.
  void add_frame(double step_ms);

  /// Makes the present state the last frame.
  void finish();
  /// Returns the number of frames in words.
  std::string kept() const;
  /// Writes the page. `report`: report.json. `warnings`: of the run. Throws std::runtime_error (disk).
  void write(const std::filesystem::path& path, const std::string& report,
             const std::vector<std::string>& warnings) const;

 private:
  struct PlacedObject {
    std::size_t object;  // in the environment
    Pose pose;
  };
  struct Frame {
    std::int64_t step;
    double time, step_ms;
    std::size_t mesh;  // index in meshes_
    PackedPoints points;
    std::vector<PlacedObject> placed;      // objects that move rigidly
    std::vector<PackedPoints> deformed;    // points of each object that deforms, m
    std::optional<PackedValues> residual;  // by particle, m
    std::optional<PackedContacts> touches;
    std::optional<PackedForces> forces;
    Measures measures;
    std::size_t bytes() const;
  };

  /// Returns whether a frame of this step is due.
  bool is_due(std::int64_t step) const;
  void store_frame(double step_ms);
  void thin_out(bool keeps_last);
  void add_mesh();

  const Simulation& simulation_;
  std::size_t max_bytes_;               // bytes of base64 that frames may occupy
  std::int64_t first_, every_;          // steps
  int tears_ = 0;                       // tears at the last mesh
  double step_ms_ = 0;                  // of the last step
  std::string environment_;             // JSON
  std::optional<Contacts> contacts_;    // if there is an environment
  std::optional<Residuals> residuals_;  // of the last mesh, if it has constraints
  std::optional<PinForces> forces_;     // likewise, if any force is known
  std::vector<std::string> meshes_;     // JSON; another one after each tear
  std::vector<Frame> frames_;
};

/// Writes the runs of two folders' page.html side by side in one page. Throws InputError if a folder has none,
/// std::runtime_error (disk).
void write_comparison(const std::filesystem::path& one, const std::filesystem::path& other,
                      const std::filesystem::path& path);

}  // namespace malha
