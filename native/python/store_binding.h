#pragma once

#include <pybind11/pybind11.h>

namespace isosplat::python {

/// Adds the classes StoreHandle and MeshData and the function open_store to the module.
void bind_store(pybind11::module_& module);

}  // namespace isosplat::python
