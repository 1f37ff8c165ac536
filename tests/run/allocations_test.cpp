// SPDX-License-Identifier: Apache-2.0
// Steps allocate nothing: malloc is replaced by functions that count while a step runs, on every thread and for every
// library, so that operator new counts too.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "host/model/model.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tests/small_scenes.h"

namespace {

std::atomic<bool> counts_allocations{false};
std::atomic<long> allocations{0};

void note_allocation() noexcept {
  if (counts_allocations.load(std::memory_order_relaxed)) ++allocations;
}

}  // namespace

// The names by which glibc exports its own functions.
extern "C" {
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* data, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);

void* malloc(std::size_t bytes) noexcept {
  note_allocation();
  return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) noexcept {
  note_allocation();
  return __libc_calloc(count, bytes);
}
void* realloc(void* data, std::size_t bytes) noexcept {
  note_allocation();
  return __libc_realloc(data, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  note_allocation();
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  note_allocation();
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** data, std::size_t alignment, std::size_t bytes) noexcept {
  note_allocation();
  *data = __libc_memalign(alignment, bytes);
  return *data == nullptr ? ENOMEM : 0;
}
}

namespace malha {
namespace {

template <class Work>
long allocations_of(const Work& work) {
  allocations = 0, counts_allocations = true;
  work();
  counts_allocations = false;
  return allocations;
}

TEST(Allocations, AreCountedWhoeverMakesThem) {
  static void* volatile kept = nullptr;  // so that the compiler leaves nothing out
  EXPECT_EQ(allocations_of([] { kept = ::operator new(100), ::operator delete(kept); }), 1);
  EXPECT_EQ(allocations_of([] { kept = std::aligned_alloc(64, 640), std::free(kept); }), 1);
  EXPECT_GE(allocations_of([] { std::thread([] { kept = std::malloc(10), std::free(kept); }).join(); }), 1);
  EXPECT_EQ(allocations_of([] {}), 0);
}

/// Bytes of the lists of contacts, which may grow.
std::size_t bytes_of_contacts(const Simulation& simulation) { return simulation.solver().facts().collision_bytes; }

class StepsOf : public testing::TestWithParam<std::string> {};

// After the tenth step, one allocates only if it has more contacts, or more particles near an object, than any step
// before, or if it tears. Lists grow by a quarter or more, so that few steps are of that kind.
TEST_P(StepsOf, AllocateOnlyWhereAListGrowsBeyondAllBefore) {
  const Scene scene = load_shipped(GetParam());
  Simulation simulation(scene, {.threads = 2});
  const long long steps = std::min(std::llround(scene.duration / scene.solver.dt), 25ll);  // most have contacts by then
  std::size_t most = 0;
  int grew = 0;
  for (long long step = 1; step <= steps; ++step) {
    const int torn = simulation.tears();
    const long found = allocations_of([&] { simulation.step(); });
    const std::size_t now = bytes_of_contacts(simulation);
    if (step > 10 && simulation.tears() == torn && found > 0) {
      ++grew;
      EXPECT_GT(now, most) << "step " << step << " has " << found << " allocations";
    }
    most = std::max(most, now);
  }
  EXPECT_LE(grew, 15) << "of " << steps << " steps";
  // In a scene without contacts nothing can grow.
  if (!scene.self_collision && scene.environment.empty()) {
    EXPECT_EQ(grew, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(, StepsOf, testing::ValuesIn(shipped_scenes()),
                         [](const auto& tested) { return tested.param; });

TEST(Allocations, AreNoneWhereTheStateIsCopiedOrForcesAreSet) {
  Simulation simulation(load_shipped("sheet_shear"), {.threads = 2});
  const std::size_t particles = simulation.positions().size();
  std::vector<Vec3> forces(particles, Vec3{0, 0, 1e-4});
  std::vector<float> to(3 * particles);
  simulation.set_forces(forces), simulation.copy_normals(to.data());
  for (int step = 0; step < 10; ++step) simulation.step();
  for (int step = 0; step < 20; ++step)
    EXPECT_EQ(allocations_of([&] {
                simulation.set_forces(forces);
                simulation.step();
                simulation.copy_positions(to.data());
                simulation.copy_velocities(to.data());
                simulation.copy_normals(to.data());
              }),
              0);
}

TEST(Allocations, AreNoneOnThreadsOfTheCaller) {
  const auto in_line = [](int groups, const std::function<void(int)>& function) {
    for (int g = 0; g < groups; ++g) function(g);
  };
  Simulation simulation(load_shipped("long_cloth"), {.threads = 4, .parallel_for = in_line});
  for (int step = 0; step < 10; ++step) simulation.step();
  for (int step = 0; step < 5; ++step) EXPECT_EQ(allocations_of([&] { simulation.step(); }), 0);
}

}  // namespace
}  // namespace malha
