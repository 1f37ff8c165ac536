// SPDX-License-Identifier: Apache-2.0
// Contact queries on a device: a mesh's triangle lists answer most of them, the host the rest, and together the
// contacts are those of the host alone.
#include "host/environment/contact_query_device.h"

#include <gtest/gtest.h>

#include <bit>
#include <vector>

#include "host/base/point_array.h"
#include "host/environment/find_contact.h"
#include "host/environment/proximity_cache.h"
#include "host/mesh/generate.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kSphereThickness = 0.01;

/// Particles close to a surface that move independently, and their contact cache.
class NearASurface {
 public:
  NearASurface(const ClosestPointIndex& surface, int count, Sides sides)
      : mesh_{&surface, surface.view(), sides, kSphereThickness, {}, {}},
        count_(count),
        w_(static_cast<std::size_t>(count), 1.0f),
        memory_(static_cast<std::size_t>(count)) {
    std::vector<Vec3> places;
    Random random(5);
    for (int i = 0; i < count; ++i) {
      const Vector3<double> at = random.direction() * (0.5 + kSphereThickness * random(0.3, 4));
      places.push_back({at.x, at.y, at.z});
    }
    x_ = PointArray<Serial, float>(places), v_ = PointArray<Serial, float>(places);
    d_ = PointArray<Serial, float>(places.size()), low_ = PointArray<Serial, float>(places.size());
  }

  /// Ends the substep, and displaces each particle by up to `way` (m) in any direction.
  void move(double way, Random& random) {
    for (int i = 0; i < count_; ++i) {
      particles().p.advance_x(i);
      d_.points().set(i, rounded<float>(random.in_cube(way)));
    }
    for (int s = 0; s < memory_.slots(); ++s) invalidate(memory_.view().contacts[s]);
  }

  /// Detects contacts; the result is how many queries are left to the host.
  int find(bool by_lists) {
    const auto groups = static_cast<int>(groups_of(static_cast<std::size_t>(count_)));
    memory_.reserve_slots(Serial{}, count_, *memory_.view().slot_count, groups, *memory_.view().entry_count);
    const ProximityCacheView<float> cache = memory_.view();
    const EnvironmentView<float> all{&mesh_, 1, particles(), &cache};
    std::vector<unsigned long long> bits(groups_of(static_cast<std::size_t>(count_)), 0);
    for (int i = 0; i < count_; ++i) bits[i / kGroupSize] |= 1ull << i % kGroupSize;
    if (by_lists) {
      const ActiveMask active{bits.data(), 1, static_cast<int>(bits.size())};
      const ContactQuery<float> query = all.query(0);
      parallel_for(Serial{}, active.groups, AllocateEntries<float>{&query, active});
      parallel_for(Serial{}, count_, QueryOctrees<float>{&query, active, INFINITY});
    }
    int left = 0;
    for (const unsigned long long word : bits) left += std::popcount(word);
    parallel_for_interleaved(Serial{}, static_cast<int>(bits.size()), FindContact<float>(all, 0, bits.data()));
    return left;
  }

  void expect_as(const NearASurface& other) const {
    const ProximityCacheView<float> a = memory_.view(), b = other.memory_.view();
    for (int i = 0; i < count_; ++i) {
      ASSERT_TRUE(same(x_.points()[i], other.x_.points()[i]) && same(d_.points()[i], other.d_.points()[i])) << i;
      const Vector3<double> at = in_double(x_.points()[i]);
      const ClosestPointRecord seen = a.record(i, at), also = b.record(i, at);
      ASSERT_TRUE(same_bits(seen.at, also.at) && same_bits(seen.distance, also.distance)) << i;
      ASSERT_EQ(seen.triangle, also.triangle) << i;
      const Contact<float>*one = a.contact(i), *two = b.contact(i);
      ASSERT_EQ(one != nullptr, two != nullptr) << i;
      if (!one) continue;
      ASSERT_TRUE(same_bits(one->plane.w, two->plane.w)) << i;
      const bool laid = one->plane.w > -INFINITY;
      ASSERT_TRUE(!laid || (same(one->plane.xyz(), two->plane.xyz()) && same_bits(one->surface, two->surface))) << i;
      const ClosestFeature &held = a.near[a.slot(i)].feature, &also_held = b.near[b.slot(i)].feature;
      ASSERT_TRUE(same_bits(held.radius, also_held.radius)) << i;
      ASSERT_TRUE(!(held.radius > 0) || held.kind == also_held.kind) << i;
    }
  }

 private:
  Particles<float> particles() {
    return {count_, x_.points(), v_.points(), {x_.points(), d_.points(), low_.points()}, w_.data()};
  }

  MovingMesh mesh_;
  int count_;
  PointArray<Serial, float> x_, low_, v_, d_;
  std::vector<float> w_;
  ProximityCache<Serial, float> memory_;
};

class DeviceQueriesOf : public testing::TestWithParam<Sides> {};

TEST_P(DeviceQueriesOf, ASphereAnswerMostAndLeaveTheHostsAnswersUnchanged) {
  const Device device;
  const Mesh mesh = generate(SphereShape{0.5, 3});
  const ClosestPointIndex surface(device, mesh), other(device, mesh);
  constexpr int count = 1000;
  NearASurface lists(surface, count, GetParam()), host(other, count, GetParam());
  Random one(3), same_one(3);
  int left = 0, queries = 0;
  for (int substep = 0; substep < 30; ++substep) {
    // one substep in ten has a large displacement
    const double way = substep % 10 == 9 ? 3 * kSphereThickness : 0.02 * kSphereThickness;
    lists.move(way, one), host.move(way, same_one);
    const int now = lists.find(true);
    EXPECT_EQ(host.find(false), count);
    if (substep % 10 > 1) left += now, queries += count;
    ASSERT_NO_FATAL_FAILURE(lists.expect_as(host)) << substep;
  }
  EXPECT_LT(left, queries / 3) << "after the first queries, in which cells are made";
}

INSTANTIATE_TEST_SUITE_P(Kinds, DeviceQueriesOf, testing::Values(Sides::Solid, Sides::OneSided, Sides::TwoSided));

}  // namespace
}  // namespace malha
