// SPDX-License-Identifier: Apache-2.0
// Assigns a value to a variable for the duration of a scope.
#pragma once

namespace malha {

template <class T>
class ScopedValue {
 public:
  ScopedValue(T& place, T value) : place_(place), before_(place) { place = value; }
  ~ScopedValue() { place_ = before_; }
  ScopedValue(const ScopedValue&) = delete;
  ScopedValue& operator=(const ScopedValue&) = delete;

 private:
  T& place_;
  T before_;
};

}  // namespace malha
