// SPDX-License-Identifier: Apache-2.0
// The CUDA backend: without a device, or in a build without it, a message says so; with a device, it has the bits of
// the host.
#include <gtest/gtest.h>

#include <string>

#include "host/model/machine.h"
#include "host/solver/solver.h"
#include "tests/parallel/has_cuda.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

TEST(Cuda, IsRefusedBeforeAnythingIsReadWhereThereIsNone) {
  if (has_cuda()) GTEST_SKIP() << "there is a device";
  Scene scene = load_shipped("sheet_shear");
  scene.bodies.front().shape = MeshFile{"nowhere.obj"};
  const std::string said = refusal([&] { Simulation(scene, {.backend = Backend::Cuda}); });
  EXPECT_TRUE(said.starts_with("backend: found ") && said.ends_with("; allowed: openmp, serial")) << said;
}

TEST(Backends, AreNamed) {
  EXPECT_EQ(backend_named("openmp"), Backend::OpenMP);
  EXPECT_EQ(backend_named("serial"), Backend::Serial);
  EXPECT_EQ(backend_named("cuda"), Backend::Cuda);
  EXPECT_EQ(refusal([] { backend_named("Cuda"); }),
            "simulation: backend: found \"Cuda\"; allowed: \"openmp\", \"serial\", \"cuda\"");
}

class SceneOnCuda : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!has_cuda()) GTEST_SKIP() << "no CUDA device";
  }
};

TEST_P(SceneOnCuda, HasTheHostsBits) {
  for (const char* machine : {"cpu", "h200"}) {
    Scene scene = load_shipped(GetParam());
    for (const Precision precision : {Precision::Float, Precision::Double}) {
      scene.solver.precision = precision;
      const Model model = build_model(scene, 2, machine_named(machine).patch_bounds(precision));
      const auto host = make_solver(model, 2), device = make_solver_on_cuda(model, 2);
      for (int step = 0; step < 30; ++step) host->step(), device->step();
      EXPECT_EQ(device->state_hash(), host->state_hash()) << machine;
      EXPECT_EQ(device->measure().kinetic, host->measure().kinetic) << machine;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, SceneOnCuda, testing::ValuesIn(shipped_scenes()),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace malha
