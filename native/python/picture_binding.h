#pragma once

#include <pybind11/pybind11.h>

namespace isosplat::python {

/// Adds the function read_png to the module.
void bind_picture(pybind11::module_& module);

}  // namespace isosplat::python
