// SPDX-License-Identifier: Apache-2.0
// Layouts take their memory from the program, and give it back.
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory_resource>
#include <new>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/solver/solver.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// Counts what is taken, up to a limit, and checks what comes back.
class CountedMemory : public std::pmr::memory_resource {
 public:
  explicit CountedMemory(std::size_t most = SIZE_MAX) : most_(most) {}
  ~CountedMemory() override { EXPECT_EQ(live(), 0u) << "does not come back"; }
  std::size_t live() const { return live_; }
  long taken() const { return taken_; }

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    EXPECT_EQ(alignment, 64u);
    EXPECT_EQ(std::this_thread::get_id(), thread_);
    if (live_ + bytes > most_) throw std::bad_alloc();
    live_ += bytes, ++taken_;
    void* const data = std::pmr::new_delete_resource()->allocate(bytes, alignment);
    sizes_[data] = bytes;
    return data;
  }
  void do_deallocate(void* data, std::size_t bytes, std::size_t alignment) override {
    const auto found = sizes_.find(data);
    ASSERT_NE(found, sizes_.end()) << "came from elsewhere";
    EXPECT_EQ(found->second, bytes);
    sizes_.erase(found), live_ -= bytes;
    std::pmr::new_delete_resource()->deallocate(data, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  std::size_t most_, live_ = 0;
  long taken_ = 0;
  std::map<void*, std::size_t> sizes_;
  std::thread::id thread_ = std::this_thread::get_id();
};

/// The bytes of arrays that a report names, without meshes of the environment.
std::size_t named_bytes(const Simulation& simulation) {
  const SolverStats& facts = simulation.solver().facts();
  std::size_t meshes = 0;
  if (facts.contact) meshes = facts.collision_bytes;  // mostly trees and triangles
  return facts.particle_bytes + facts.constraint_bytes + facts.long_range_bytes + facts.air_bytes +
         facts.collision_bytes + facts.level_bytes + facts.spring_bytes - meshes;
}

std::uint64_t hash_after(Simulation& simulation, int steps) {
  for (int step = 0; step < steps; ++step) simulation.step();
  return simulation.state_hash();
}

class MemoryOf : public testing::TestWithParam<std::string> {};

// The scenes have levels, a filter, contacts with all kinds of objects, self-collision, pressure, wind, tears and
// attachments.
TEST_P(MemoryOf, WhatIsLaidOutIsTheProgramsWithTheSameBits) {
  const Scene scene = load_shipped(GetParam());
  CountedMemory memory;
  {
    Simulation simulation(scene, {.threads = 2, .memory = &memory}), usual(scene, {.threads = 2});
    EXPECT_GE(memory.live() * 1.05, named_bytes(simulation));
    EXPECT_EQ(hash_after(simulation, 12), hash_after(usual, 12));
    EXPECT_EQ(simulation.measure().kinetic, usual.measure().kinetic);
    simulation.count_crossings();
    const std::string state = simulation.save_state();
    const std::uint64_t then = hash_after(simulation, 3);
    simulation.restore_state(state);
    EXPECT_EQ(hash_after(simulation, 3), then);
  }
  EXPECT_EQ(memory.live(), 0u);
}

INSTANTIATE_TEST_SUITE_P(, MemoryOf,
                         testing::Values("long_cloth", "desbrun_sheet", "rotating_sphere", "folded_sheet", "pillow",
                                         "soft_bunny", "turning_flag", "torn_sheet", "carried_sheet", "ramp",
                                         "cantilever"),
                         [](const auto& tested) { return tested.param; });

TEST(MemoryResource, GivesAllOfASheet) {
  const Scene scene = load_shipped("sheet_shear");
  CountedMemory memory;
  const Simulation simulation(scene, {.threads = 1, .memory = &memory});
  const std::size_t named = named_bytes(simulation);
  EXPECT_GE(memory.live(), named);
  EXPECT_LT(memory.live(), 1.3 * named) << "and little else";
}

// In these scenes no step after the tenth has more contacts than any before, which would let a list grow (StepsOf).
TEST(MemoryResource, IsNotAskedByStepsAfterTheTenth) {
  for (const char* name : {"sheet_shear", "long_cloth", "desbrun_sheet", "ramp", "carried_sheet"}) {
    CountedMemory memory;
    Simulation simulation(load_shipped(name), {.threads = 2, .memory = &memory});
    for (int step = 0; step < 10; ++step) simulation.step();
    const long taken = memory.taken();
    for (int step = 0; step < 20; ++step) simulation.step();
    EXPECT_EQ(memory.taken(), taken) << name;
  }
}

TEST(MemoryResource, GetsALayoutBackThatIsReplaced) {
  const Scene scene = load_shipped("sheet_shear");
  CountedMemory memory;
  Simulation simulation(scene, {.threads = 1, .memory = &memory, .interactive = true});
  const std::size_t live = memory.live();
  std::vector<int> pins = simulation.pins();
  for (int round = 0; round < 3; ++round) {
    pins.push_back(40 + round);
    simulation.set_pins(pins), simulation.step();
    Scene other = simulation.scene();
    other.bodies[0].constraints[0].stiffness = 0.9 - 0.1 * round;
    simulation.set_scene(other), simulation.step();
    EXPECT_LT(memory.live(), 1.2 * live);
  }
}

TEST(MemoryResource, StaysWithASimulationThatMoves) {
  const Scene scene = load_shipped("rotating_sphere");
  CountedMemory first, second;
  Simulation one(scene, {.threads = 1, .memory = &first}), other(scene, {.threads = 1, .memory = &second});
  one.step(), other.step();
  one = std::move(other);  // the arrays of the first may go back now or with the moved one
  Simulation moved(std::move(one));
  const std::size_t live = second.live();
  EXPECT_GT(live, 0u);
  for (int step = 0; step < 5; ++step) moved.step();
  Simulation usual(scene, {.threads = 1});
  EXPECT_EQ(moved.state_hash(), hash_after(usual, 6));
}

TEST(MemoryResource, IsAnotherOneForEachSimulationOfAThread) {
  const Scene scene = load_shipped("folded_sheet");
  CountedMemory first, second;
  Simulation usual(scene, {.threads = 1}), one(scene, {.threads = 1, .memory = &first}),
      other(scene, {.threads = 1, .memory = &second});
  for (int step = 0; step < 8; ++step) usual.step(), one.step(), other.step();
  EXPECT_EQ(first.live(), second.live());
  EXPECT_EQ(first.taken(), second.taken());
  EXPECT_EQ(one.state_hash(), usual.state_hash());
  EXPECT_EQ(other.state_hash(), usual.state_hash());
}

TEST(MemoryResource, IsAnotherOneForEachThread) {
  const Scene scene = load_shipped("folded_sheet");
  std::vector<std::uint64_t> found(3);
  std::vector<std::thread> threads;
  for (std::uint64_t& hash : found)
    threads.emplace_back([&] {
      CountedMemory memory;  // which checks that it is asked by this thread
      Simulation simulation(scene, {.threads = 2, .memory = &memory});
      hash = hash_after(simulation, 8);
    });
  for (std::thread& one : threads) one.join();
  Simulation usual(scene, {.threads = 1});
  const std::uint64_t expected = hash_after(usual, 8);
  for (const std::uint64_t hash : found) EXPECT_EQ(hash, expected);
}

TEST(MemoryResource, MayBeAnyOfTheStandardOnes) {
  const Scene scene = load_shipped("rotating_sphere");
  Simulation usual(scene, {.threads = 1});
  const std::uint64_t expected = hash_after(usual, 5);
  std::pmr::monotonic_buffer_resource monotonic;
  std::pmr::unsynchronized_pool_resource pool;
  for (std::pmr::memory_resource* memory :
       {static_cast<std::pmr::memory_resource*>(&monotonic), static_cast<std::pmr::memory_resource*>(&pool)}) {
    Simulation simulation(scene, {.threads = 1, .memory = memory});
    EXPECT_EQ(hash_after(simulation, 5), expected);
  }
}

TEST(MemoryResource, ThatIsUsedUpLeavesNothingBehind) {
  const Scene scene = load_shipped("rotating_sphere");
  std::size_t all = 0;
  {
    CountedMemory memory;
    const Simulation simulation(scene, {.threads = 1, .memory = &memory});
    all = memory.live();
  }
  for (int part = 0; part < 10; ++part) {
    CountedMemory memory(all * part / 10);
    EXPECT_THROW(Simulation(scene, {.threads = 1, .memory = &memory}), std::bad_alloc);
    EXPECT_EQ(memory.live(), 0u);
  }
}

TEST(MemoryResource, IsRefusedWithADevice) {
  CountedMemory memory;
  EXPECT_EQ(refusal([&] { Simulation(load_shipped("sheet_shear"), {.memory = &memory, .backend = Backend::Cuda}); }),
            "simulation: memory: found the backend \"cuda\" beside it; allowed: memory of the host, for \"openmp\" and "
            "\"serial\"");
}

}  // namespace
}  // namespace malha
