// SPDX-License-Identifier: Apache-2.0
// A run as one HTML file that replays it in a browser, without a server or a network.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/fields/fields.h"
#include "host/output/page_pack.h"
#include "malha/simulation.h"

namespace malha {

/// Frames of the present run, as many as the scene's outputs.page has room for. A frame is kept at the first step, then
/// every so many, at most 60 a simulated second; where they grow too large every second one goes, and from there on
/// half as many are kept. So their number follows from the room alone.
class Page {
 public:
  /// Of a scene that names outputs.page.
  explicit Page(const Simulation& simulation);

  /// Call at the start and after every step, which took so long.
  void look(double step_ms);

  /// Makes the present state the last frame.
  void finish();
  /// How many frames there are, in words.
  std::string kept() const;
  /// `report`: report.json. `warnings`: of the run. Throws std::runtime_error (disk).
  void write(const std::filesystem::path& path, const std::string& report,
             const std::vector<std::string>& warnings) const;

 private:
  struct Frame {
    std::int64_t step;
    double time, step_ms;
    std::size_t mesh;  // of meshes_
    PackedPoints points;
    std::optional<PackedValues> residual;  // of each particle, m
    std::optional<PackedTouches> touches;
    std::optional<PackedForces> forces;
    Measures measures;
    std::size_t bytes() const;
  };

  /// Whether there is to be a frame of this step.
  bool wants(std::int64_t step) const;
  void keep(double step_ms);
  void thin_out(bool keeps_last);
  void add_mesh();

  const Simulation& simulation_;
  std::size_t room_;                    // bytes of base64 that frames may take
  std::int64_t first_, every_;          // steps
  int tears_ = 0;                       // that the last mesh knows of
  double step_ms_ = 0;                  // of the last step
  std::string environment_;             // JSON
  std::optional<Contacts> contacts_;    // where there is something to touch
  std::optional<Residuals> residuals_;  // of the last mesh, where it has constraints
  std::optional<PinForces> forces_;     // likewise, where a force is known
  std::vector<std::string> meshes_;     // JSON; another one after each tear
  std::vector<Frame> frames_;
};

/// Both runs in one page, beside each other: of the folders' page.html. Throws InputError where a folder has none,
/// std::runtime_error (disk).
void write_comparison(const std::filesystem::path& one, const std::filesystem::path& other,
                      const std::filesystem::path& path);

}  // namespace malha
