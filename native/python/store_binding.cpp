#include "native/python/store_binding.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <optional>
#include <string>

#include "native/extract/chunk_reading.h"
#include "native/extract/extract_mesh.h"
#include "native/extract/mesh_components.h"
#include "native/extract/mesh_file.h"
#include "native/extract/simplify_mesh.h"
#include "native/python/active_cells.h"
#include "native/python/arrays.h"
#include "native/python/exceptions.h"
#include "native/python/read_values.h"
#include "native/python/store_handle.h"
#include "native/python/surface_measures.h"

namespace py = pybind11;

namespace isosplat::python {
namespace {

using Box = std::array<double, 6>;

/// A part of a store: the cells of a level, and in a box.
struct Part {
  uint32_t level = 0;
  std::optional<Box> box;  ///< low and high corner, in the world
  unsigned threads = 0;
};

py::object text_of(const std::string& utf8) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(utf8.data(), static_cast<Py_ssize_t>(utf8.size()), "replace"));
}

ExtractOptions options_of(const StoreHandle& store, const StoreFile& file, const Part& part) {
  ExtractOptions options{part.level, store.threads(part.threads)};
  if (part.box) {
    const Box& b = *part.box;
    options.region = CellRegion::in_world(file.info().grid, {b[0], b[1], b[2]}, {b[3], b[4], b[5]});
  }
  return options;
}

/// Calls work(check) without the GIL. `check` is to be called on this thread from time to time: it
/// handles Ctrl-C. Returns the value of the result.
template <class Work>
auto run_interruptible(Work work) {
  Interruption interruption;
  auto result = [&] {
    const py::gil_scoped_release no_gil;
    return work([&interruption] {
      interruption.handle_signals();
      return interruption.check();
    });
  }();
  interruption.rethrow();
  return value_or_raise(std::move(result));
}

/// Upper limit of the number of points of an isosurface.
Result<uint64_t> max_points(const StoreFile& file, double isovalue, const ExtractOptions& options) {
  const auto chunks = chunks_of(file, isovalue, options);
  if (!chunks) return tl::unexpected(chunks.error());
  uint64_t cells = 0;
  for (const ChunkRef& chunk : *chunks) cells += chunk.cells;
  return cells;
}

/// Opens fields of a store, which may fetch their headers.
OpenedFields fields_of(const StoreFile& file, const std::vector<std::string>& names) {
  return run_interruptible([&](const auto&) { return open_fields(file, names); });
}

/// Positions, normals, and a list of the values of each field.
py::tuple points(const StoreHandle& store, double isovalue, const Part& part, bool smooth,
                 bool exact, const std::vector<std::string>& fields) {
  const auto file = store.file();
  ExtractOptions options = options_of(store, *file, part);
  options.smooth_normals = smooth;
  options.fields = fields_of(*file, fields);
  ProjectionOptions projection;
  projection.exact = exact;
  PointsWithFields all = run_interruptible([&](const auto& check) -> Result<PointsWithFields> {
    PointsWithFields points;
    points.fields.resize(options.fields.size());
    const auto limit = max_points(*file, isovalue, options);
    if (!limit) return tl::unexpected(limit.error());
    auto done = catch_out_of_memory(*file, [&]() -> Result<uint64_t> {
      // Memory that is not written to takes no place.
      points.positions.reserve(*limit);
      points.normals.reserve(*limit);
      return extract_points(
          *file, isovalue, projection, options, [&](const PointsWithFields& batch) {
            points.positions.insert(points.positions.end(), batch.positions.begin(),
                                    batch.positions.end());
            points.normals.insert(points.normals.end(), batch.normals.begin(), batch.normals.end());
            append_values(points.fields, batch.fields);
            return check();
          });
    });
    if (!done) return tl::unexpected(done.error());
    return points;
  });
  py::list values;
  for (auto& of_field : all.fields) values.append(take_values(std::move(of_field)));
  return py::make_tuple(take_rows<double>(std::move(all.positions)),
                        take_rows<float>(std::move(all.normals)), values);
}

py::array_t<int32_t> active_cells_array(const StoreHandle& store, double isovalue,
                                        const Part& part) {
  const auto file = store.file();
  const ExtractOptions options = options_of(store, *file, part);
  return take_rows<int32_t>(run_interruptible(
      [&](const auto& check) { return active_cells(*file, isovalue, options, check); }));
}

/// `values`: a C-contiguous array of shape (z, y, x), whose first voxel is `first` (x, y, z).
template <class Scalar>
void read(const StoreHandle& store, const Part& part, const std::array<int32_t, 3>& first,
          py::array_t<Scalar, py::array::c_style> values) {
  const auto file = store.file();
  const ExtractOptions options = options_of(store, *file, part);
  const auto count = [&](py::ssize_t axis) { return static_cast<int32_t>(values.shape(axis)); };
  const VoxelBox box{{first[0], first[1], first[2]}, {count(2), count(1), count(0)}};
  const std::span all(values.mutable_data(), static_cast<size_t>(values.size()));
  run_interruptible(
      [&](const auto& check) { return read_values(*file, box, options, check, all); });
}

uint64_t bytes_of(const StoreHandle& store, double isovalue, const Part& part) {
  const auto file = store.file();
  const ExtractOptions options = options_of(store, *file, part);
  return run_interruptible([&](const auto&) -> Result<uint64_t> {
    const auto chunks = chunks_of(*file, isovalue, options);
    if (!chunks) return tl::unexpected(chunks.error());
    uint64_t bytes = 0;
    for (const ChunkRef& chunk : *chunks) bytes += chunk.bytes;
    return bytes;
  });
}

py::tuple measures(const StoreHandle& store, double isovalue, unsigned threads) {
  const auto file = store.file();
  ExtractOptions options;
  options.threads = store.threads(threads);
  const auto measured = run_interruptible(
      [&](const auto& check) { return measure_surface(*file, isovalue, options, check); });
  return py::make_tuple(measured.area, measured.volume_above);
}

/// A mesh in memory, and what its files state.
struct MeshData {
  MeshPart mesh;
  std::vector<FieldColumn> fields;  ///< whose values the vertices have
  VolumeGrid grid;
  double isovalue = 0;
};

struct MeshChanges {
  std::optional<size_t> components;
  std::optional<double> simplify_error;
};

std::unique_ptr<MeshData> mesh_of(const StoreHandle& store, double isovalue, const Part& part,
                                  const MeshChanges& changes,
                                  const std::vector<std::string>& fields) {
  const auto file = store.file();
  ExtractOptions options = options_of(store, *file, part);
  options.fields = fields_of(*file, fields);
  auto data = std::make_unique<MeshData>();
  data->fields = columns_of(options.fields);
  data->mesh.vertices.fields.resize(fields.size());
  data->grid = file->info().grid;
  data->isovalue = isovalue;
  run_interruptible([&](const auto& check) -> Result<void> {
    MeshPart& mesh = data->mesh;
    return catch_out_of_memory(*file, [&]() -> Result<void> {
      auto done = extract_mesh(*file, isovalue, options, [&](const MeshPart& layer) {
        append_part(mesh, layer);
        return check();
      });
      if (!done) return tl::unexpected(done.error());
      if (changes.components) keep_largest_components(mesh, *changes.components);
      if (!changes.simplify_error) return {};
      const auto simplified = simplify_mesh(mesh, *changes.simplify_error);
      if (!simplified) return tl::unexpected(simplified.error());
      return {};
    });
  });
  return data;
}

void save_mesh(const MeshData& data, const std::string& path, const std::string& comment) {
  run_interruptible([&](const auto&) -> Result<void> {
    const auto format = mesh_format(path, SurfaceContent::triangles);
    if (!format) return tl::unexpected(format.error());
    if (!data.fields.empty()) {
      auto holds = check_holds_fields(path, **format, SurfaceContent::triangles);
      if (!holds) return holds;
    }
    auto file = (*format)->create(
        path, {data.grid, data.isovalue, comment, SurfaceContent::triangles, {}, data.fields});
    if (!file) return tl::unexpected(file.error());
    if (auto written = (*file)->append(data.mesh); !written) return written;
    return (*file)->publish();
  });
}

/// The fields of a store, each as a dict.
py::list field_list(const StoreHandle& store) {
  const auto file = store.file();
  std::vector<std::string> names;
  for (const FieldRef& field : file->info().fields) names.push_back(field.info.name);
  const std::vector<FieldColumn> columns = columns_of(fields_of(*file, names));
  py::list list;
  for (size_t i = 0; i < columns.size(); ++i) {
    const FieldInfo& field = file->info().fields[i].info;
    py::dict one;
    one["name"] = field.name;
    one["title"] = text_of(columns[i].title);
    one["units"] = text_of(columns[i].units);
    one["value_range"] =
        py::make_tuple(field.mapping.value(field.range.min), field.mapping.value(field.range.max));
    one["max_error"] = field.mapping.max_error;
    one["missing_voxels"] = field.missing_voxels;
    list.append(one);
  }
  return list;
}

py::dict info_of(const StoreHandle& store) {
  const auto file = store.file();
  const StoreInfo& info = file->info();
  const VolumeGrid& grid = info.grid;
  const ValueMapping& mapping = info.mapping;
  py::dict result;
  result["voxels"] = py::make_tuple(grid.voxels.x, grid.voxels.y, grid.voxels.z);
  result["spacing"] = py::make_tuple(grid.spacing.x, grid.spacing.y, grid.spacing.z);
  result["origin"] = py::make_tuple(grid.origin.x, grid.origin.y, grid.origin.z);
  result["direction"] = grid.direction;
  result["max_error"] = mapping.max_error;
  result["value_range"] =
      py::make_tuple(mapping.value(info.range.min), mapping.value(info.range.max));
  result["levels"] = info.levels;
  result["missing_voxels"] = info.missing_voxels;
  result["file_bytes"] = info.file_bytes;
  result["content_id"] = file->content();
  result["metadata"] = text_of(info.metadata);
  return result;
}

}  // namespace

void bind_store(py::module_& module) {
  py::class_<Part>(module, "Part")
      .def(py::init<uint32_t, std::optional<Box>, unsigned>(), py::kw_only(), py::arg("level"),
           py::arg("box"), py::arg("threads"));
  py::class_<MeshData>(module, "MeshData")
      .def_property_readonly("vertices",
                             [](const py::object& self) {
                               return view_rows<double>(
                                   self.cast<const MeshData&>().mesh.vertices.positions, self);
                             })
      .def_property_readonly("normals",
                             [](const py::object& self) {
                               return view_rows<float>(
                                   self.cast<const MeshData&>().mesh.vertices.normals, self);
                             })
      .def_property_readonly("triangles",
                             [](const py::object& self) {
                               return view_rows<uint32_t>(
                                   self.cast<const MeshData&>().mesh.triangles, self);
                             })
      .def_property_readonly(
          "fields",
          [](const py::object& self) {
            py::list list;
            const auto& data = self.cast<const MeshData&>();
            for (size_t i = 0; i < data.fields.size(); ++i) {
              list.append(py::make_tuple(data.fields[i].name,
                                         view_values(data.mesh.vertices.fields[i], self)));
            }
            return list;
          })
      .def("column_names",
           [](const MeshData& data, const std::vector<std::string>& used) {
             const std::vector<std::string_view> views(used.begin(), used.end());
             return column_names(data.fields, views);
           })
      .def("save", [](const MeshData& data, py::bytes path, const std::string& comment) {
        save_mesh(data, path, comment);
      });
  py::class_<StoreHandle>(module, "StoreHandle")
      .def("close", &StoreHandle::close)
      .def_property_readonly("is_open", &StoreHandle::is_open)
      .def("info", info_of)
      .def("fields", field_list)
      .def("points", points, py::arg("isovalue"), py::arg("part"), py::kw_only(), py::arg("smooth"),
           py::arg("exact"), py::arg("fields"))
      .def("active_cells", active_cells_array, py::arg("isovalue"), py::arg("part"))
      .def("read", read<float>, py::arg("part"), py::arg("first"), py::arg("values").noconvert())
      .def("read", read<double>, py::arg("part"), py::arg("first"), py::arg("values").noconvert())
      .def("bytes", bytes_of, py::arg("isovalue"), py::arg("part"))
      .def("measures", measures, py::arg("isovalue"), py::kw_only(), py::arg("threads"))
      .def(
          "mesh",
          [](const StoreHandle& store, double isovalue, const Part& part,
             std::optional<size_t> components, std::optional<double> simplify_error,
             const std::vector<std::string>& fields) {
            return mesh_of(store, isovalue, part, {components, simplify_error}, fields);
          },
          py::arg("isovalue"), py::arg("part"), py::kw_only(), py::arg("components"),
          py::arg("simplify_error"), py::arg("fields"));
  module.def(
      "open_store",
      [](py::bytes path) {
        return run_interruptible(
            [text = std::string(path)](const auto&) { return StoreHandle::open(text); });
      },
      py::arg("path"));
}

}  // namespace isosplat::python
