#pragma once

#include <pybind11/pybind11.h>

namespace isosplat::python {

/// Adds the functions build_array and build_file to the module.
void bind_build(pybind11::module_& module);

}  // namespace isosplat::python
