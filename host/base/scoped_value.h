// SPDX-License-Identifier: Apache-2.0
// A value that something has as long as a scope lasts, however it ends.
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
