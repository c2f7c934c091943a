#include "native/python/exceptions.h"

namespace py = pybind11;

namespace isosplat::python {
namespace {

PyObject* exception_of(Status status) {
  switch (status) {
    case Status::io_error:
      return PyExc_OSError;
    case Status::out_of_memory:
      return PyExc_MemoryError;
    default:
      return PyExc_ValueError;
  }
}

}  // namespace

void raise(const Error& error) {
  // Names of files may have bytes that are not UTF-8.
  const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
      error.message.data(), static_cast<Py_ssize_t>(error.message.size()), "replace"));
  if (text) PyErr_SetObject(exception_of(error.status), text.ptr());
  throw py::error_already_set();
}

void Interruption::handle_signals() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_check_) return;
  next_check_ = now + std::chrono::milliseconds(50);
  const py::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() == 0) return;
  try {
    throw py::error_already_set();
  } catch (...) {
    set_current_exception();
  }
}

void Interruption::set_current_exception() {
  const std::lock_guard lock(mutex_);
  if (!exception_) exception_ = std::current_exception();
  is_set_ = true;
}

Result<void> Interruption::check() const {
  if (is_set_) return fail(Status::io_error, "interrupted");
  return {};
}

void Interruption::rethrow() {
  if (exception_) std::rethrow_exception(std::exchange(exception_, nullptr));
}

}  // namespace isosplat::python
