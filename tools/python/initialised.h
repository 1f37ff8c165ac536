// SPDX-License-Identifier: Apache-2.0
// Refusal of uninitialised objects: of X.__new__(X), or of a subclass before super().__init__().
#pragma once
#include <pybind11/pybind11.h>

#include <string>

namespace malha::python {

/// Refuses uninitialised objects as arguments, for which pybind11's own caster returns uninitialised memory.
template <class T>
class InitialisedCaster : public pybind11::detail::type_caster_base<T> {
 public:
  bool load(pybind11::handle source, bool convert) {
    if (pybind11::isinstance<T>(source)) {
      auto* const instance = reinterpret_cast<pybind11::detail::instance*>(source.ptr());
      if (!instance->get_value_and_holder(pybind11::detail::get_type_info(typeid(T))).holder_constructed()) {
        const std::string kind = pybind11::str(pybind11::type::handle_of(source).attr("__name__"));
        throw pybind11::type_error(kind + ": found an object that __init__() has not initialised; allowed: " + kind +
                                   "(...), and super().__init__(...) first in classes that are derived from it");
      }
    }
    return pybind11::detail::type_caster_base<T>::load(source, convert);
  }
};

}  // namespace malha::python
