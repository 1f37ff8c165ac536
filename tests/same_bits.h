// SPDX-License-Identifier: Apache-2.0
// The suite SameBits: a scene of any feature gives the same bits on any number of threads, when it is resumed, and when
// an earlier state is restored. A feature joins it by one INSTANTIATE_TEST_SUITE_P beside its other tests;
// tests/solver/same_bits_test.cpp asks the questions.
#pragma once
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "malha/simulation.h"
#include "tests/support.h"

namespace malha {

struct SameBitsScene {
  std::string name;
  std::function<Scene(const TemporaryFolder&)> make;  // meshes that it needs as files are written into the folder
  int steps;
  std::vector<int> stops;  // steps after which the state is saved, ascending
  std::function<void(const Simulation&)> has_feature = [](const Simulation&) {};  // expects at the end what it is about
  std::vector<UserConstraint> constraints = {};
};
inline void PrintTo(const SameBitsScene& scene, std::ostream* out) { *out << scene.name; }

class SameBits : public testing::TestWithParam<SameBitsScene> {
 protected:
  Simulation simulation(SimulationOptions options) const {
    options.constraints = GetParam().constraints;
    return Simulation(scene_, options);
  }
  static void run_to(Simulation& simulation, int step) {
    while (simulation.steps() < step) simulation.step();
  }
  std::uint64_t hash_after_all(const SimulationOptions& options) const {
    Simulation whole = simulation(options);
    run_to(whole, GetParam().steps);
    GetParam().has_feature(whole);
    return whole.state_hash();
  }

  TemporaryFolder folder_;
  Scene scene_ = GetParam().make(folder_);
};

inline std::string name_of_scene(const testing::TestParamInfo<SameBitsScene>& tested) { return tested.param.name; }

}  // namespace malha
