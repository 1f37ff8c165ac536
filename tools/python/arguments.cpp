// SPDX-License-Identifier: Apache-2.0
#include "tools/python/arguments.h"

#include <algorithm>
#include <cctype>
#include <vector>

#include "host/base/spelling_suggestion.h"
#include "malha/error.h"
#include "malha/text.h"
#include "tools/python/arrays.h"

namespace malha::python {

namespace py = pybind11;

namespace {

PyCFunctionWithKeywords dispatcher = nullptr;  // pybind11's dispatcher, which all its functions share

/// Returns the types of the arguments as in the call: "(dict, threads=str)".
std::string types_of(const py::tuple& arguments, const py::dict& keywords, std::size_t first) {
  std::string all;
  const auto add = [&](const std::string& one) { all += (all.empty() ? "" : ", ") + one; };
  for (std::size_t i = first; i < arguments.size(); ++i) add(type_of(arguments[i]));
  for (const auto& [name, one] : keywords) add(text_of(name) + "=" + type_of(one));
  return "(" + all + ")";
}

/// Refuses texts with lone surrogates, which pybind11 does not accept as texts.
void refuse_surrogates(const py::tuple& arguments, const py::dict& keywords) {
  for (const py::handle one : arguments)
    if (py::isinstance<py::str>(one)) text_of(one);
  for (const auto& [name, one] : keywords)
    for (const py::handle text : {name, one})
      if (py::isinstance<py::str>(text)) text_of(text);
}

/// Returns the signature in pybind11's message: "malha.Scene(source: object, folder: object = None)".
std::string signature_in(const std::string& said) {
  const std::string before = "supported:\n    1. ";
  const std::size_t at = said.find(before), from = at + before.size();
  return at == std::string::npos ? "" : said.substr(from, said.find('\n', from) - from);
}

/// Returns the names of the parameters in a signature, in order and without self.
std::vector<std::string> names_in(const std::string& signature) {
  std::vector<std::string> names;
  const auto is_of_name = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  for (std::size_t at = 0; at < signature.size(); ++at) {
    const bool begins = signature[at] == '(' || (at > 0 && signature[at] == ' ' && signature[at - 1] == ',');
    if (!begins) continue;
    const auto from = signature.begin() + static_cast<std::ptrdiff_t>(at) + 1;
    const auto end = std::find_if_not(from, signature.end(), is_of_name);
    if (std::string name(from, end); end != signature.end() && *end == ':' && name != "self") names.push_back(name);
  }
  return names;
}

/// Refuses a keyword that the function does not have, by the name that was probably meant.
void refuse_keyword(const std::string& function, const std::string& signature, const py::dict& keywords) {
  if (signature.find("**") != std::string::npos) return;
  const std::vector<std::string> names = names_in(signature);
  for (const auto& [name, value] : keywords)
    if (const std::string word = text_of(name); std::find(names.begin(), names.end(), word) == names.end())
      throw py::type_error(function + ": found the keyword '" + word + "'" + did_you_mean(word, names) +
                           "; allowed: " + (names.empty() ? "none" : join(names)));
}

/// Replaces an error about arguments by a brief one; rethrows any other error.
void rethrow_briefly(PyObject* given, PyObject* named) {
  const py::error_already_set raised;  // clears Python's error
  if (raised.trace() || !raised.matches(PyExc_TypeError))
    throw raised;  // an error with a traceback comes from a called function
  const std::string said = text_of(py::str(raised.value()));
  const std::string signature = said.find("\nInvoked with: ") == std::string::npos ? "" : signature_in(said);
  if (signature.empty()) throw raised;
  const auto arguments = py::reinterpret_borrow<py::tuple>(given);
  const py::dict keywords = named ? py::reinterpret_borrow<py::dict>(named) : py::dict();
  refuse_surrogates(arguments, keywords);
  const std::string before = signature.substr(0, signature.find('('));  // "malha.Scene", or "" of what constructs none
  refuse_keyword(before.empty() ? said.substr(0, said.find('(')) : before, signature, keywords);
  const bool constructs = !arguments.empty() && signature.starts_with("malha." + type_of(arguments[0]) + "(");
  throw py::type_error("found " + types_of(arguments, keywords, constructs ? 1 : 0) + "; allowed: " + signature);
}

PyObject* call_briefly(PyObject* self, PyObject* given, PyObject* named) {
  try {
    if (PyObject* const result = dispatcher(self, given, named)) return result;  // otherwise an error is set
    rethrow_briefly(given, named);
  } catch (py::error_already_set& raised) {
    raised.restore();
  } catch (const py::builtin_exception& error) {
    error.set_error();
  } catch (const InputError& error) {
    PyErr_SetString(py::module_::import("malha").attr("InputError").ptr(), error.what());
  }
  return nullptr;
}

void replace(const py::handle& function) {
  const py::handle inner = py::detail::get_function(function);  // unwraps a method
  if (!inner || !PyCFunction_Check(inner.ptr())) return;
  PyMethodDef* const definition = reinterpret_cast<PyCFunctionObject*>(inner.ptr())->m_ml;
  const auto call = reinterpret_cast<PyCFunctionWithKeywords>(reinterpret_cast<void (*)()>(definition->ml_meth));
  if (call == call_briefly || (dispatcher && call != dispatcher)) return;
  dispatcher = call;
  definition->ml_meth = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(call_briefly));
}

}  // namespace

std::string text_of(const py::handle& text) {
  Py_ssize_t size = 0;
  if (const char* const utf8 = PyUnicode_AsUTF8AndSize(text.ptr(), &size)) return {utf8, std::size_t(size)};
  const py::error_already_set raised;
  const py::object at = raised.value().attr("start"), letter = py::reinterpret_borrow<py::object>(text)[at];
  const std::string number = py::str("U+{:04X}").format(py::module_::import("builtins").attr("ord")(letter));
  refuse("text", "character " + std::string(py::str(at)), "the lone surrogate " + number, "what UTF-8 has");
}

void refuse_arguments_briefly(const py::module_& module) {
  for (const py::handle one : py::dict(module.attr("__dict__")).attr("values")()) {
    if (!PyType_Check(one.ptr())) {
      replace(one);
      continue;
    }
    for (const py::handle member : one.attr("__dict__").attr("values")()) {
      replace(member);
      if (!py::isinstance(member, py::handle(reinterpret_cast<PyObject*>(&PyProperty_Type)))) continue;
      for (const char* const accessor : {"fget", "fset"}) replace(member.attr(accessor));
    }
  }
}

}  // namespace malha::python
