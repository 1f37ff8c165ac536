// SPDX-License-Identifier: Apache-2.0
// Conversion of arrays between C++ and numpy.
#pragma once
#include <pybind11/numpy.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "malha/error.h"
#include "malha/mesh.h"
#include "malha/text.h"

namespace malha::python {

/// Returns an array (n, k) that owns these rows, without another copy. It is read-only, because writing to a copy would
/// not change the simulation.
template <class T, std::size_t k>
pybind11::array_t<T> array_of(std::vector<std::array<T, k>> rows) {
  auto* kept = new std::vector<std::array<T, k>>(std::move(rows));
  const pybind11::capsule owner(kept, [](void* p) { delete static_cast<std::vector<std::array<T, k>>*>(p); });
  const auto n = static_cast<pybind11::ssize_t>(kept->size());
  pybind11::array_t<T> array({n, static_cast<pybind11::ssize_t>(k)}, kept->empty() ? nullptr : kept->front().data(),
                             owner);
  array.attr("setflags")(pybind11::arg("write") = false);
  return array;
}
template <class T>
pybind11::array_t<T> array_of(const std::vector<T>& values) {
  pybind11::array_t<T> array(static_cast<pybind11::ssize_t>(values.size()), values.data());
  array.attr("setflags")(pybind11::arg("write") = false);
  return array;
}

using Doubles = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;
using Ints = pybind11::array_t<int, pybind11::array::c_style>;

/// Returns the shape as "(4, 3)".
inline std::string shape_of(const pybind11::array& array) {
  return pybind11::str(array.attr("shape")).cast<std::string>();
}

/// Returns the description of an array, or of null, for messages.
inline std::string found_in(const pybind11::array& array) {
  return array ? "an array of shape " + shape_of(array) : "what is no array of numbers";
}
inline std::string type_of(const pybind11::handle& value) {
  return pybind11::str(pybind11::type::handle_of(value).attr("__name__")).cast<std::string>();
}

/// Converts an object by numpy to an array of whole numbers or, unless `whole`, real ones; returns null for others.
/// Texts, dates, complex and masked numbers are not accepted, because the conversion would change them.
inline pybind11::array numbers_of(const pybind11::handle& given, bool whole) {
  pybind11::array array = pybind11::array::ensure(given);
  if (!array) {
    PyErr_Clear();
    return array;
  }
  const char kind = array.dtype().kind();
  if (array.size() > 0 && kind != 'i' && kind != 'u' && (whole || kind != 'f'))
    return pybind11::reinterpret_steal<pybind11::array>(nullptr);
  if (pybind11::hasattr(given, "mask") &&
      pybind11::module_::import("numpy").attr("any")(given.attr("mask")).cast<bool>())
    return pybind11::reinterpret_steal<pybind11::array>(nullptr);
  return array;
}

/// Converts real numbers to doubles; returns null for others.
inline Doubles doubles_of(const pybind11::handle& given) {
  const pybind11::array array = numbers_of(given, false);
  return array ? Doubles::ensure(array) : pybind11::reinterpret_steal<Doubles>(nullptr);
}

/// Converts an object by numpy to an array (n, 3). Throws InputError, which names `what`, for another shape.
inline std::vector<Vec3> rows_of(const pybind11::handle& given, const char* what) {
  const Doubles array = doubles_of(given);
  if (!array || array.ndim() != 2 || array.shape(1) != 3) refuse(what, "", found_in(array), "an array (N, 3)");
  std::vector<Vec3> rows(static_cast<std::size_t>(array.shape(0)));
  std::copy_n(array.data(), 3 * rows.size(), rows.empty() ? nullptr : rows.front().data());
  return rows;
}

/// Converts an object by numpy to a list of whole numbers. Throws InputError likewise.
inline std::vector<int> integers_of(const pybind11::handle& given, const char* what, int most_dimensions = 2) {
  const pybind11::array array = numbers_of(given, true);
  if (!array) refuse(what, "", "what is no array of whole numbers", "an array of them");
  if (array.ndim() > most_dimensions) refuse(what, "", found_in(array), "an array (N,)");
  std::vector<int> all;
  const auto add = [&]<class Wide>(Wide) {
    const auto wide = pybind11::array_t<Wide, pybind11::array::c_style | pybind11::array::forcecast>::ensure(array);
    for (pybind11::ssize_t i = 0; i < wide.size(); ++i) {
      const Wide number = wide.data()[i];
      if (!std::in_range<int>(number)) refuse(what, "", std::to_string(number), "whole numbers up to 2147483647");
      all.push_back(static_cast<int>(number));
    }
  };
  array.dtype().kind() == 'u' ? add(0ULL) : add(0LL);
  return all;
}

/// Converts an object to three numbers. Throws InputError likewise.
inline Vec3 vector_of(const pybind11::handle& given, const char* what) {
  const Doubles array = doubles_of(given);
  if (!array || array.ndim() != 1 || array.shape(0) != 3) refuse(what, "", found_in(array), "three numbers");
  return {array.data()[0], array.data()[1], array.data()[2]};
}

}  // namespace malha::python
