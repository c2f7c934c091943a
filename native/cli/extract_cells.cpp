#include "native/cli/extract_cells.h"

#include <fmt/format.h>
#include <isosplat/version.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "native/builder/machine_memory.h"
#include "native/cli/command.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "shared/core/unstructured/cell_points.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"

namespace isosplat::cli {
namespace {

/// Points that are in memory at a time.
constexpr size_t kBatch = size_t{1} << 16;

constexpr const char* kSizeColumn = "size";

/// Refuses what needs a store or a scene.
Result<void> check_options(const ExtractCall& call) {
  const auto refuse = [&](std::string_view option) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a store or a scene, found the mesh {}: isosplat build "
                            "makes a scene of it",
                            option, call.input));
  };
  if (call.mesh) return refuse("--mesh");
  if (call.level > 0) return refuse("--level");
  if (!call.box.empty()) return refuse("--box");
  if (!call.layers.empty()) return refuse("--layer");
  if (call.step) return refuse("--step");
  if (call.projection.exact) return refuse("--exact");
  if (call.projection.displaced != Displaced::clamp) return refuse("--drop-displaced");
  return {};
}

Result<import::OpenMesh> open_array(const ExtractCall& call, const std::string& dataset,
                                    uint64_t memory_bytes) {
  import::ImportOptions options;
  options.dataset = dataset;
  return import::open_vtk_mesh(call.input, options, memory_bytes);
}

/// A grid around the points, whose voxels are as large as the smallest cell: it decides whether
/// positions need double precision.
VolumeGrid grid_around(const UnstructuredMesh& mesh) {
  Box box{mesh.points.front(), mesh.points.front()};
  for (const Vec3d point : mesh.points) box.add(point);
  float smallest = std::numeric_limits<float>::max();
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    const float size = mesh.size(cell);
    if (size > 0) smallest = std::min(smallest, size);
  }
  const Vec3d extent = box.high - box.low;
  VolumeGrid grid;
  grid.origin = box.low;
  grid.spacing = {smallest, smallest, smallest};
  const auto voxels = [&](double length) {
    return static_cast<int32_t>(
        std::clamp(length / smallest + 1, 2.0, static_cast<double>(kMaxVoxelsPerAxis)));
  };
  grid.voxels = {voxels(extent.x), voxels(extent.y), voxels(extent.z)};
  return grid;
}

/// The points of a mesh with the values of other arrays, which have the same points and cells.
class CellPoints {
 public:
  CellPoints(const UnstructuredMesh& mesh, std::span<const UnstructuredMesh> fields, bool has_sizes)
      : mesh_(mesh), fields_(fields), has_sizes_(has_sizes) {}

  /// Appends all points to a file. Returns their number.
  Result<uint64_t> append(double isovalue, MeshFile& file) {
    uint64_t count = 0;
    for (size_t cell = 0; cell < mesh_.cells(); ++cell) {
      const auto point = point_of_cell(mesh_, cell, isovalue);
      if (!point) continue;
      add(cell, *point, isovalue);
      ++count;
      if (batch_.positions.size() < kBatch) continue;
      if (auto written = flush(file); !written) return tl::unexpected(written.error());
    }
    if (auto written = flush(file); !written) return tl::unexpected(written.error());
    return count;
  }

 private:
  void add(size_t cell, const CellPoint& point, double isovalue) {
    batch_.positions.push_back(point.position);
    batch_.normals.push_back({static_cast<float>(point.normal.x),
                              static_cast<float>(point.normal.y),
                              static_cast<float>(point.normal.z)});
    batch_.values.push_back(static_cast<float>(isovalue));
    batch_.fields.resize(fields_.size() + (has_sizes_ ? 1 : 0));
    if (has_sizes_) batch_.fields.back().push_back(static_cast<float>(point.size));
    if (fields_.empty()) return;
    const auto weights = weights_in_cell(mesh_.geometry(cell), point.position);
    for (size_t i = 0; i < fields_.size(); ++i) {
      const double value =
          weights ? fields_[i].value(cell, *weights) : std::numeric_limits<double>::quiet_NaN();
      batch_.fields[i].push_back(static_cast<float>(value));
    }
  }

  Result<void> flush(MeshFile& file) {
    if (batch_.positions.empty()) return {};
    return file.append({std::exchange(batch_, {}), {}});
  }

  const UnstructuredMesh& mesh_;
  std::span<const UnstructuredMesh> fields_;
  bool has_sizes_;
  PointsWithFields batch_;
};

Result<std::vector<UnstructuredMesh>> open_fields(const ExtractCall& call,
                                                  const UnstructuredMesh& mesh,
                                                  uint64_t memory_bytes) {
  std::vector<UnstructuredMesh> fields;
  for (const std::string& name : call.fields) {
    auto opened = open_array(call, name, memory_bytes);
    if (!opened) return tl::unexpected(opened.error());
    if (opened->mesh.corners != mesh.corners || opened->mesh.points.size() != mesh.points.size()) {
      return fail(Status::malformed_volume,
                  fmt::format("--field {}: expected values at the points and cells of the mesh, "
                              "found others",
                              name));
    }
    fields.push_back(std::move(opened->mesh));
  }
  return fields;
}

Result<void> extract(const ExtractCall& call) {
  if (auto checked = check_options(call); !checked) return checked;
  // Half of it is for the mesh and for those of other arrays.
  const uint64_t memory = machine_memory() / 2 / (1 + call.fields.size());
  const auto opened = open_array(call, call.dataset, memory);
  if (!opened) return tl::unexpected(opened.error());
  for (const std::string& text : opened->notes) note(text);
  const UnstructuredMesh& mesh = opened->mesh;
  const double isovalue = *call.isovalue;
  const std::filesystem::path path =
      call.output.empty() ? fmt::format("{}_{}.ply", opened->name, isovalue) : call.output;
  if (auto checked = check_not_input(path, opened->files); !checked) return checked;
  const auto format = mesh_format(path, SurfaceContent::points);
  if (!format) return tl::unexpected(format.error());
  if (!call.fields.empty()) {
    auto holds = check_holds_fields(path, **format, SurfaceContent::points);
    if (!holds) return holds;
  }
  auto replaceable = check_replaceable(path, (*format)->beginning, (*format)->name, call.force);
  if (!replaceable) return replaceable;
  const auto fields = open_fields(call, mesh, memory);
  if (!fields) return tl::unexpected(fields.error());
  std::vector<FieldColumn> columns;
  for (const std::string& name : call.fields) columns.push_back({name, "", ""});
  const bool has_sizes = (*format)->has_fields;
  if (has_sizes) columns.push_back({kSizeColumn, "Size of the mesh's cell", ""});
  const VolumeGrid grid = grid_around(mesh);
  const std::string comment =
      fmt::format("isosurface {} of {}, a point for each cell, by isosplat " ISOSPLAT_VERSION,
                  isovalue, std::filesystem::path(call.input).filename().string());
  const auto file =
      (*format)->create(path, {grid, isovalue, comment, SurfaceContent::points, {}, columns});
  if (!file) return tl::unexpected(file.error());
  const auto count = CellPoints(mesh, *fields, has_sizes).append(isovalue, **file);
  if (!count) return tl::unexpected(count.error());
  if (auto published = (*file)->publish(); !published) return published;
  fmt::print("{}: {} points with normals, {}\n", path.string(), with_commas(*count),
             format_bytes((*file)->bytes()));
  if (*count > 0) return {};
  const auto [least, most] = std::minmax_element(mesh.values.begin(), mesh.values.end());
  note(fmt::format("no cell has values on both sides of {}: they are {} to {}", isovalue, *least,
                   *most));
  return {};
}

}  // namespace

int extract_cells(const ExtractCall& call) {
  const auto done = extract(call);
  return done ? kSuccess : report(done.error());
}

}  // namespace isosplat::cli
