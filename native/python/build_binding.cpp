#include "native/python/build_binding.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "native/builder/field_build.h"
#include "native/builder/field_place.h"
#include "native/builder/machine_memory.h"
#include "native/builder/source_path.h"
#include "native/files/output_file.h"
#include "native/python/build_run.h"
#include "native/python/slice_reader.h"
#include "shared/core/preprocess/voxel_scan.h"
#include "shared/core/store/field_sections.h"
#include "shared/core/store/format.h"
#include "shared/import/geometry/conventions.h"
#include "shared/import/open_volume.h"
#include "shared/import/volume/type_names.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/missing_values.h"

namespace py = pybind11;

namespace isosplat::python {
namespace {

using Triple = std::array<double, 3>;

Vec3d vector_of(const Triple& t) {
  return {t[0], t[1], t[2]};
}

/// The options of a build. Names and units as in the command line.
struct BuildCall {
  std::string target;
  std::string title, units;
  double max_error = 0;
  std::optional<std::array<double, 2>> range;
  unsigned threads = 0;
  uint64_t memory_bytes = 0;
  bool overwrite = false;
  py::object progress;
  std::shared_ptr<VoxelScan> scan;  ///< of all volumes that are quantized together; null: this one

  BuildOptions options() const {
    BuildOptions options;
    options.title = title;
    options.value_units = units;
    options.max_error = max_error;
    if (range) options.range = ValueRange{(*range)[0], (*range)[1]};
    options.threads = threads;
    options.memory_bytes = memory_bytes;
    options.scan = scan;
    return options;
  }
};

/// Raises FileExistsError if the target is neither absent, nor empty, nor a store. Another file is
/// never replaced by accident.
void check_target(const BuildCall& call) {
  const std::string beginning = first_bytes(call.target, kStoreMagic.size());
  const bool is_store = beginning.size() == kStoreMagic.size() &&
                        std::equal(beginning.begin(), beginning.end(), kStoreMagic.begin(),
                                   [](char a, auto b) { return a == static_cast<char>(b); });
  if (call.overwrite || beginning.empty() || is_store) return;
  PyErr_SetString(PyExc_FileExistsError,
                  fmt::format("{}: expected no file, or a store, found another file: give another "
                              "name, or replace it with overwrite=True",
                              call.target)
                      .c_str());
  throw py::error_already_set();
}

/// An array whose voxels are numbers of one type, with the axes z, y and x.
struct ArrayCall {
  std::string type;  ///< "u8", …, "f64", or "f16"
  bool big_endian = false;
  std::array<int64_t, 3> shape{};  ///< along z, y and x
  bool z_is_fastest = false;       ///< the order of the bytes is Fortran's
  std::string name;
  Triple spacing{}, origin{};         ///< along x, y and z
  std::array<double, 9> direction{};  ///< row by row; the columns are the axes
  std::vector<std::string> notes;
};

/// The numbers of voxels. As the reader of .npy files has it: in Fortran's order, z is the fastest
/// axis of the volume.
Vec3<int64_t> voxels_of(const ArrayCall& array) {
  const auto [nz, ny, nx] = array.shape;
  return array.z_is_fastest ? Vec3<int64_t>{nz, ny, nx} : Vec3<int64_t>{nx, ny, nz};
}

Result<import::OpenVolume> open_array_call(const ArrayCall& array,
                                           std::unique_ptr<import::ByteReader> reader) {
  import::StoredVoxels stored;
  stored.big_endian = array.big_endian;
  stored.is_half = array.type == "f16";
  stored.type = stored.is_half ? VoxelType::f32 : import::voxel_type_of(array.type).value();
  const auto step = [&](size_t axis) {
    return column(array.direction, axis) * array.spacing[axis];
  };
  const bool z_first = array.z_is_fastest;
  const import::HeaderGeometry geometry = import::geometry_of_steps(
      z_first ? std::array{step(2), step(1), step(0)} : std::array{step(0), step(1), step(2)},
      vector_of(array.origin));
  import::ArrayVolume volume;
  volume.format = "NumPy";
  volume.name = array.name;
  volume.path = "the array";
  volume.voxels = voxels_of(array);
  volume.geometry = geometry;
  volume.stored = stored;
  auto opened = import::open_array(std::move(volume), std::move(reader), array.notes);
  if (!opened) return opened;
  return import::with_missing_values(std::move(*opened), {});
}

/// An array as a volume, with the buffer that the volume borrows.
struct OpenedArray {
  py::buffer_info buffer;
  import::OpenVolume volume;
};

/// `data`: an object with the buffer protocol, contiguous in the order of the call; or, if
/// read_count > 0, a function: see SliceReader. Borrows `data` and the interruption.
OpenedArray open_data(const py::object& data, uint64_t read_count, const ArrayCall& array,
                      Interruption& interruption) {
  if (!is_basis(array.direction)) {
    throw py::value_error(
        "direction: expected three columns of length 1 that do not lie in a plane, found others");
  }
  py::buffer_info buffer;
  std::unique_ptr<import::ByteReader> reader;
  if (read_count > 0) {
    const size_t voxel =
        array.type == "f16" ? 2 : voxel_bytes(import::voxel_type_of(array.type).value());
    const uint64_t slice = import::volume_bytes({array.shape[2], array.shape[1], 1}, voxel);
    reader = std::make_unique<SliceReader>(
        data, Slices{static_cast<uint64_t>(array.shape[0]), slice, read_count}, interruption);
  } else {
    buffer = py::buffer(data).request();
    const auto bytes = static_cast<size_t>(buffer.size) * static_cast<size_t>(buffer.itemsize);
    reader =
        std::make_unique<MemoryReader>(std::span(static_cast<const std::byte*>(buffer.ptr), bytes));
  }
  auto volume = [&] {
    const py::gil_scoped_release no_gil;
    return open_array_call(array, std::move(reader));
  }();
  interruption.rethrow();
  return {std::move(buffer), value_or_raise(std::move(volume))};
}

/// An array with the voxels of a field.
struct FieldCall {
  std::string name;
  py::object data;
  uint64_t read_count = 0;  ///< as in open_data
  ArrayCall array;
  bool is_placed = false;  ///< the array has its own geometry; else that of the volume
};

/// Checks the name of a field, and its size if it has no geometry of its own. Throws the exceptions
/// of raise().
void check_field_call(const FieldCall& field, const ArrayCall& volume) {
  FieldInfo info;
  info.name = field.name;
  value_or_raise(check_field(info));
  if (field.is_placed) return;
  const auto voxels = [](const ArrayCall& array) {
    const auto [x, y, z] = voxels_of(array);  // at most 2^20 each
    return Index3{static_cast<int32_t>(x), static_cast<int32_t>(y), static_cast<int32_t>(z)};
  };
  value_or_raise(check_field_grid(field.name, voxels(volume), voxels(field.array)));
}

void build_array(const py::object& data, uint64_t read_count, const ArrayCall& array,
                 const BuildCall& call, const std::vector<FieldCall>& fields) {
  check_target(call);
  if (fields.size() > kMaxFields) {
    throw py::value_error(
        fmt::format("fields: expected at most {}, found {}", kMaxFields, fields.size()));
  }
  for (const FieldCall& field : fields) check_field_call(field, array);  // before any is read
  Interruption interruption;
  const OpenedArray opened = open_data(data, read_count, array, interruption);
  std::vector<OpenedArray> opened_fields;
  std::vector<FieldInput> inputs;
  for (const FieldCall& field : fields) {
    opened_fields.push_back(open_data(field.data, field.read_count, field.array, interruption));
  }
  const VolumeGrid& grid = opened.volume.source->header().grid;
  for (size_t i = 0; i < fields.size(); ++i) {
    import::OpenVolume& field = opened_fields[i].volume;
    const FieldPlace place =
        fields[i].is_placed
            ? value_or_raise(find_field_place(fields[i].name, grid, field.source->header().grid))
            : FieldPlace{grid};
    inputs.push_back({fields[i].name, "",
                      [&field, &grid, name = fields[i].name, from = place.grid,
                       memory = call.options().memory_bytes] {
                        return field_at_voxels(name, std::move(field.source), from, grid, memory);
                      },
                      field.notes});
  }
  run_build(opened.volume, call.target, call.options(), call.progress, interruption,
            std::move(inputs));
}

/// The values of an array, as BuildCall has them. Ctrl-C is handled between slices that a function
/// returns, else at the end.
std::shared_ptr<VoxelScan> scan_array(const py::object& data, uint64_t read_count,
                                      const ArrayCall& array, const BuildCall& call) {
  Interruption interruption;
  const OpenedArray opened = open_data(data, read_count, array, interruption);
  auto scan = [&] {
    const py::gil_scoped_release no_gil;
    return scan_for_build(*opened.volume.source, call.options());
  }();
  interruption.rethrow();
  return std::make_shared<VoxelScan>(value_or_raise(std::move(scan)));
}

void build_file(const std::string& path, const std::optional<Triple>& spacing,
                const BuildCall& call) {
  check_target(call);
  import::ImportOptions import_options;
  if (spacing) import_options.spacing = vector_of(*spacing);
  import_options.memory_bytes = call.memory_bytes;
  Interruption interruption;
  auto volume = [&] {
    const py::gil_scoped_release no_gil;
    return import::open_volume(path, import_options);
  }();
  const import::OpenVolume opened = value_or_raise(std::move(volume));
  for (const auto& file : opened.source->files()) {
    std::error_code error;
    if (std::filesystem::equivalent(call.target, file, error)) {
      throw py::value_error(
          fmt::format("{}: expected an output that is not an input: give another "
                      "name",
                      call.target));
    }
  }
  BuildOptions options = call.options();
  options.source_file = source_file_name(path);
  options.source_path_hash = source_path_hash(path, call.target);
  run_build(opened, call.target, options, call.progress, interruption);
}

}  // namespace

void bind_build(py::module_& module) {
  py::class_<VoxelScan, std::shared_ptr<VoxelScan>>(module, "VoxelScan")
      .def_property_readonly("is_settled", &VoxelScan::is_settled)
      .def(
          "add", [](VoxelScan& scan, const VoxelScan& other) { scan.add(other); },
          py::arg("other"));
  py::class_<BuildCall>(module, "BuildCall")
      .def(py::init([](py::bytes target, std::string title, std::string units, double max_error,
                       std::optional<std::array<double, 2>> range, unsigned threads,
                       uint64_t memory_bytes, bool overwrite, py::object progress,
                       std::shared_ptr<VoxelScan> scan) {
             return BuildCall{target,
                              std::move(title),
                              std::move(units),
                              max_error,
                              range,
                              threads,
                              std::min(memory_bytes, machine_memory()),
                              overwrite,
                              std::move(progress),
                              std::move(scan)};
           }),
           py::kw_only(), py::arg("target"), py::arg("title"), py::arg("units"),
           py::arg("max_error"), py::arg("range"), py::arg("threads"), py::arg("memory_bytes"),
           py::arg("overwrite"), py::arg("progress"), py::arg("scan"));
  py::class_<ArrayCall>(module, "ArrayCall")
      .def(py::init<std::string, bool, std::array<int64_t, 3>, bool, std::string, Triple, Triple,
                    std::array<double, 9>, std::vector<std::string>>(),
           py::kw_only(), py::arg("type"), py::arg("big_endian"), py::arg("shape"),
           py::arg("z_is_fastest"), py::arg("name"), py::arg("spacing"), py::arg("origin"),
           py::arg("direction"), py::arg("notes"))
      .def_readonly("type", &ArrayCall::type)
      .def_readonly("z_is_fastest", &ArrayCall::z_is_fastest);
  py::class_<FieldCall>(module, "FieldCall")
      .def(py::init<std::string, py::object, uint64_t, ArrayCall, bool>(), py::kw_only(),
           py::arg("name"), py::arg("data"), py::arg("read_count"), py::arg("array"),
           py::arg("is_placed"));
  module.def("build_array", build_array, py::arg("data"), py::arg("read_count"), py::arg("array"),
             py::arg("call"), py::arg("fields"));
  module.def("scan_array", scan_array, py::arg("data"), py::arg("read_count"), py::arg("array"),
             py::arg("call"));
  module.def(
      "build_file",
      [](py::bytes path, const std::optional<Triple>& spacing, const BuildCall& call) {
        build_file(path, spacing, call);
      },
      py::arg("path"), py::arg("spacing"), py::arg("call"));
}

}  // namespace isosplat::python
