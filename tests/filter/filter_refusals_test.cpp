// SPDX-License-Identifier: Apache-2.0
// Systems that cannot be factored are refused with a message, before anything large is computed.
#include <gtest/gtest.h>

#include "host/base/memory_size.h"
#include "host/solver/solver.h"
#include "tests/filter/filter_reference.h"
#include "tests/refusal.h"

namespace malha {
namespace {

/// The message of the InputError that refuses the scene; "" if it is accepted.
std::string filter_refusal(Scene scene) {
  scene.file = "test.json";
  return refusal([&] { Simulation(scene, {.threads = 1}); });
}

class SingularSystem : public testing::TestWithParam<std::tuple<FilterKind, std::optional<Storage>>> {
 protected:
  static Scene scene(const BodySpec& body, double stiffness) {
    Scene scene = desbrun_scene({body}, stiffness, Precision::Float);
    std::tie(scene.solver.desbrun.filter, scene.solver.desbrun.storage) = GetParam();
    return scene;
  }
};

// The mass of a free body is its softest mode, and lost where k dt^2 is 1e17 times that: A is then -dt^2 H alone.
TEST_P(SingularSystem, IsRefusedWhereTheMassOfAFreeBodyIsLost) {
  for (const int cells : {2, 5, 16}) {
    BodySpec sheet = sprung_sheet(cells);
    sheet.density = 0.003;
    const double stiffness = 1e17 * cells * 0.05 * 0.05 * 0.003 * 3600;
    const std::string said = filter_refusal(scene(sheet, stiffness));
    EXPECT_EQ(said.find("test.json: /solver/dt: found a system that is singular to working precision at particle "), 0u)
        << said;
    EXPECT_NE(said.find(" of body 'sheet'; allowed: a stiffness times dt^2 that is less than 1e14 times"),
              std::string::npos)
        << said;
    EXPECT_EQ(filter_refusal(scene(sheet, 1e-5 * stiffness)), "") << "1e12 times is not too much";
  }
}

// Between systems that can be solved and those that cannot, none is accepted whose solution is rounding.
TEST(ANearlySingularSystem, IsSolvedOrRefused) {
  int solved_ones = 0, refused = 0;
  for (const int cells : {2, 3, 5, 12})
    for (double ratio = 1e12; ratio < 1e18; ratio *= 3) {  // k dt^2 / m
      BodySpec sheet = sprung_sheet(cells);
      sheet.density = 0.003;
      const Scene scene = desbrun_scene({sheet}, ratio * 0.05 * 0.05 * 0.003 * 3600);
      const SolvedSystem solved(scene);
      try {
        const FilterUnderTest<double> filter(solved, FilterKind::Sparse);
        // The reference is A with all digits of the masses, in long double.
        const auto A = matrix_of<long double>(solved.model, solved.dt, solved.system.particle);
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<long double>> factor(A);
        const std::vector<double> noise = noise_forces(solved.system);
        Eigen::Matrix<long double, Eigen::Dynamic, 3, Eigen::RowMajor> F(solved.system.count(), 3);
        for (int k = 0; k < F.size(); ++k) F.data()[k] = noise[k];
        const decltype(F) a = factor.solve(F);
        std::vector<double> expected(a.data(), a.data() + a.size());
        remove_mean(solved.system, expected);
        EXPECT_LT(relative_difference(filter(noise), expected), 1e-9) << cells << ", " << ratio;
        ++solved_ones;
      } catch (const InputError&) {
        ++refused;
      }
    }
  EXPECT_GT(solved_ones, 10);
  EXPECT_GT(refused, 10);
}

TEST_P(SingularSystem, IsNoneWhereTheBodyIsPinnedHoweverStiff) {
  const Scene pinned = scene(sprung_sheet(8, {ListPin{{0}}}), 1e18);
  EXPECT_EQ(filter_refusal(pinned), "");
  Simulation simulation(pinned, {.threads = 1});
  for (int step = 0; step < 3; ++step) simulation.step();
  // Its springs keep it together, to the rounding of positions of 0.5 m.
  for (const Vec3& x : simulation.positions()) EXPECT_NEAR(x[1], 0, 1e-6);
}

std::string filter_name(const testing::TestParamInfo<std::tuple<FilterKind, std::optional<Storage>>>& tested) {
  const auto [kind, storage] = tested.param;
  const std::string name = kind == FilterKind::Sparse ? "Sparse" : kind == FilterKind::Dense ? "Dense" : "Auto";
  return name + (!storage ? "" : *storage == Storage::Double ? "Double" : "Int16");
}

INSTANTIATE_TEST_SUITE_P(, SingularSystem,
                         testing::Values(std::tuple{FilterKind::Sparse, std::optional<Storage>{}},
                                         std::tuple{FilterKind::Sparse, std::optional{Storage::Double}},
                                         std::tuple{FilterKind::Dense, std::optional<Storage>{}},
                                         std::tuple{FilterKind::Dense, std::optional{Storage::Int16}},
                                         std::tuple{FilterKind::Auto, std::optional<Storage>{}}),
                         filter_name);

// n^2 / 2 numbers of 4 bytes are 1.8 TiB, which is more than any machine has that runs this; with more, the test would
// not apply.
TEST(ADenseFilter, ThatDoesNotFitIntoMemoryIsRefusedBeforeItIsOrderedOrFactoredAndTheSparseOneNamed) {
  if (static_cast<double>(available_memory()) > 1.9e12) GTEST_SKIP() << "a machine with more memory than that";
  Scene scene = desbrun_scene({sprung_chain(1000000, true, 1e-3)}, 1e3, Precision::Float);
  scene.file = "test.json";
  scene.solver.desbrun.filter = FilterKind::Dense;
  const Model model = build_model(scene);
  const SpringSystem system = spring_system(model, 0.01);
  bool began = false;
  const ShowProgress progress = [&](const char*, double) { began = true; };
  const std::string said = refusal([&] {
    make_filter<OpenMP, float>(OpenMP{1, widest_instructions()}, 1, model, system, progress);
  });
  EXPECT_EQ(
      said.find("test.json: /solver/filter: found a dense filter of 1.86e+03 GiB for 1000000 particles in 1 body; "
                "allowed: what fits into the "),
      0u)
      << said;
  EXPECT_NE(said.find("\"sparse\" or \"auto\" needs far less"), std::string::npos) << said;
  EXPECT_FALSE(began);
}

TEST(ADenseFilterOfIntegers, ThatDoesNotFitNamesAStorageThatDoes) {
  BodySpec sheet = sprung_sheet(2);
  sheet.shape = GridShape{{1, 1}, {699, 699}};
  Scene scene = desbrun_scene({sheet}, 1000, Precision::Float);
  scene.solver.desbrun.storage = Storage::Int16;
  const std::string said = filter_refusal(scene);
  EXPECT_NE(said.find("/solver/filter: found a dense filter of "), std::string::npos) << said;
  EXPECT_NE(said.find("\"sparse\" with the storage \"float\" needs far less"), std::string::npos) << said;
}

TEST(SpringsWithoutStiffness, MakeNoFilter) {
  BodySpec sheet = sprung_sheet(2);
  sheet.constraints = {stiff("distance", {"edges"}, 0)};
  EXPECT_FALSE(Simulation(desbrun_scene({sheet}, 1000), {.threads = 1}).solver().facts().filter);
}

}  // namespace
}  // namespace malha
