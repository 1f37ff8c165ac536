// A part of a solver: there if the scene asks for it, and never in a build without it.
#pragma once
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <type_traits>

#include "host/error.h"
#include "kernels/built.h"

namespace malha {

/// A scene asks for what this build lacks.
[[noreturn]] inline void refuse_unbuilt() {
  throw InputError("found a scene that needs what this build of malha was made without (" MALHA_WITHOUT
                   "); allowed: any other, or a whole build");
}

/// Instead of a part: the compiler sees that what would be done with it never is.
template <class T>
struct Unbuilt {
  constexpr explicit operator bool() const { return false; }
  [[noreturn]] T* operator->() const { std::abort(); }
  [[noreturn]] T& operator*() const { std::abort(); }
  template <class... From>
  [[noreturn]] void emplace(From&&...) {
    refuse_unbuilt();
  }
};

/// Of a part that may be there.
template <class Part>
std::size_t bytes_of(const Part& part) {
  return part ? part->bytes() : 0;
}

/// OptionalPart<LongRange<Executor, R>, built("long_range")>
template <class T, bool is_built>
using OptionalPart = std::conditional_t<is_built, std::optional<T>, Unbuilt<T>>;

}  // namespace malha
