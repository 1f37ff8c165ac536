// SPDX-License-Identifier: Apache-2.0
// Error messages for arguments that a function does not accept.
#pragma once
#include <pybind11/pybind11.h>

#include <string>

namespace malha::python {

/// Returns a text in UTF-8. Throws InputError for lone surrogates, which Python's texts may contain.
std::string text_of(const pybind11::handle& text);

/// Makes all functions of the module, with its classes' methods and properties, name the types of wrong arguments.
/// pybind11 would print their values, such as a whole scene for a misspelt keyword.
void refuse_arguments_briefly(const pybind11::module_& module);

}  // namespace malha::python
