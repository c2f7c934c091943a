#include "native/python/picture_binding.h"

#include <pybind11/numpy.h>

#include <algorithm>
#include <string>

#include "native/headless/image.h"
#include "native/python/exceptions.h"

namespace py = pybind11;

namespace isosplat::python {
namespace {

/// The pixels of a PNG file, of shape (height, width, 4).
py::array_t<uint8_t> read_pixels(const py::bytes& path) {
  const Image image = value_or_raise(read_png(path));
  py::array_t<uint8_t> pixels({image.height, image.width, 4});
  std::copy(image.rgba.begin(), image.rgba.end(), pixels.mutable_data());
  return pixels;
}

}  // namespace

void bind_picture(py::module_& module) {
  module.def("read_png", read_pixels, py::arg("path"));
}

}  // namespace isosplat::python
