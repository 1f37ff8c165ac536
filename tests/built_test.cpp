// What a build may be made without: see kernels/built.h and tools/without.
#include "kernels/built.h"

#include <gtest/gtest.h>

#include <type_traits>

#include "host/solver/optional_part.h"
#include "kernels/constraint_registry.h"

namespace malha {
namespace {

TEST(Built, IsEverythingInThisBuild) {
  for (const char* what : {"distance", "bending", "air", "double"}) EXPECT_TRUE(built(what)) << what;
  EXPECT_TRUE((std::is_same_v<ConstraintKinds, KindList<Distance, DistanceLimit, Membrane, Bending, IsometricBending,
                                                        Plate, Volume, NeoHookean>>));
}

TEST(Built, IsNotWhatIsNamedByAWholeWord) {
  EXPECT_TRUE(has_word("isometric_bending air", "air"));
  EXPECT_TRUE(has_word("isometric_bending air", "isometric_bending"));
  for (const char* word : {"bending", "isometric", "ai", "airy", ""})
    EXPECT_FALSE(has_word("isometric_bending air", word)) << word;
  EXPECT_FALSE(has_word("", "air"));
}

TEST(Built, APartThatIsNotIsRefusedToAScene) {
  OptionalPart<int, false> part;
  EXPECT_FALSE(part);
  EXPECT_THROW(part.emplace(1), InputError);
}

}  // namespace
}  // namespace malha
