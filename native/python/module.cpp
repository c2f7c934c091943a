#include <isosplat/version.h>
#include <pybind11/pybind11.h>

#include "native/python/build_binding.h"
#include "native/python/picture_binding.h"
#include "native/python/scene_binding.h"
#include "native/python/store_binding.h"

// The part of the package isosplat that is in C++. Its functions are called by the modules beside
// it, which check and convert arguments: package/isosplat/_core.pyi declares them.
PYBIND11_MODULE(_core, module) {
  module.attr("version") = ISOSPLAT_VERSION;
  isosplat::python::bind_build(module);
  isosplat::python::bind_picture(module);
  isosplat::python::bind_store(module);
  isosplat::python::bind_scene(module);
}
