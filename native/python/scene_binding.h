#pragma once

#include <pybind11/pybind11.h>

namespace isosplat::python {

/// Adds the class SceneHandle and the function open_scene to the module. Call it after bind_store.
void bind_scene(pybind11::module_& module);

}  // namespace isosplat::python
