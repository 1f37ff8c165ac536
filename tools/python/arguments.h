// SPDX-License-Identifier: Apache-2.0
// The refusal of arguments that a function does not take.
#pragma once
#include <pybind11/pybind11.h>

#include <string>

namespace malha::python {

/// A text in UTF-8. Throws InputError where it has none: Python's texts may hold lone surrogates.
std::string text_of(const pybind11::handle& text);

/// Lets all functions of the module, its classes' methods and properties included, refuse arguments by their types.
/// pybind11 prints their values: a whole scene for a keyword that is misspelt.
void refuse_arguments_briefly(const pybind11::module_& module);

}  // namespace malha::python
