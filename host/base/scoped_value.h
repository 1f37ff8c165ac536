// A value that something has as long as a scope lasts, however it ends.
#pragma once

namespace malha {

template <class T>
class ForNow {
 public:
  ForNow(T& place, T value) : place_(place), before_(place) { place = value; }
  ~ForNow() { place_ = before_; }
  ForNow(const ForNow&) = delete;
  ForNow& operator=(const ForNow&) = delete;

 private:
  T& place_;
  T before_;
};

}  // namespace malha
