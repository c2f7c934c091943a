#include "native/python/scene_binding.h"

#include <memory>
#include <string>

#include "native/python/exceptions.h"
#include "native/python/store_handle.h"
#include "shared/system/scene_file/scene_file.h"

namespace py = pybind11;

namespace isosplat::python {
namespace {

/// A scene that has been read. Threads may share it.
struct SceneHandle {
  std::shared_ptr<const SceneFile> file;
};

/// Null if the file is no scene. Raises the exceptions of SceneFile::open().
std::unique_ptr<SceneHandle> open_scene(const py::bytes& path) {
  const std::string text = path;
  auto opened = [&]() -> Result<std::optional<SceneFile>> {
    const py::gil_scoped_release no_gil;
    if (scene_kind(text) == SceneKind::none) return std::nullopt;
    auto file = SceneFile::open(text);
    if (!file) return tl::unexpected(file.error());
    return std::move(*file);
  }();
  auto file = value_or_raise(std::move(opened));
  if (!file) return nullptr;
  auto handle = std::make_unique<SceneHandle>();
  handle->file = std::make_shared<const SceneFile>(std::move(*file));
  return handle;
}

/// Raises the exceptions of SceneFile::open_store().
StoreHandle store_of(const SceneHandle& scene, const std::string& path) {
  auto opened = [&] {
    const py::gil_scoped_release no_gil;
    return scene.file->open_store(path);
  }();
  return StoreHandle::of(value_or_raise(std::move(opened)));
}

}  // namespace

void bind_scene(py::module_& module) {
  py::class_<SceneHandle>(module, "SceneHandle")
      .def_property_readonly("document",
                             [](const SceneHandle& scene) { return py::bytes(scene.file->text()); })
      .def("store", store_of, py::arg("path"));
  module.def("open_scene", open_scene, py::arg("path"));
}

}  // namespace isosplat::python
