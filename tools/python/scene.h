// SPDX-License-Identifier: Apache-2.0
// malha.Scene, and bodies made from arrays.
#pragma once
#include <pybind11/pybind11.h>

#include "malha/scene.h"
#include "tools/python/initialised.h"

namespace pybind11::detail {
template <>
class type_caster<malha::Scene> : public malha::python::InitialisedCaster<malha::Scene> {};
}  // namespace pybind11::detail

namespace malha::python {

/// Returns a scene from a path, JSON text, or a dict that Python's json module can write, with numpy arrays.
Scene scene_of(const pybind11::object& source, const pybind11::object& folder);

/// Parses JSON text to Python's dicts and lists.
pybind11::object parsed(const std::string& json);

void add_scene(pybind11::module_& module);

}  // namespace malha::python
