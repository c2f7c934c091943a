#include "shared/import/vtk_mesh/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "shared/import/vtk_mesh/ghosts.h"
#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {
namespace {

/// VTK's numbers of cell types (vtkCellType.h).
constexpr int kTetrahedron = 10, kVoxel = 11, kHexahedron = 12, kWedge = 13, kPyramid = 14;
constexpr int kMaxType = 82;

std::optional<CellShape> shape_of(int type) {
  if (type == kTetrahedron) return CellShape::tetrahedron;
  if (type == kVoxel || type == kHexahedron) return CellShape::hexahedron;
  if (type == kWedge) return CellShape::wedge;
  if (type == kPyramid) return CellShape::pyramid;
  return std::nullopt;
}

/// Whether cells of a type have no volume: of 0 to 2 dimensions, linear or of higher order.
bool is_flat(int type) {
  constexpr int kFlat[] = {21, 22, 23, 28, 30, 34, 35, 36, 51, 60,
                           61, 62, 63, 68, 69, 70, 75, 76, 77};
  return type < kTetrahedron ||
         std::find(std::begin(kFlat), std::end(kFlat), type) != std::end(kFlat);
}

/// The name and the remedy of cells that are not read.
std::string other_cells(int type) {
  if (type == 42 || type == 41 || type == 15 || type == 16) {
    return "polyhedra or prisms: in ParaView divide them with Filters > Tetrahedralize, and save "
           "the "
           "result as .vtu";
  }
  return "cells of higher order: in ParaView make them linear with Filters > Tessellate, and save "
         "the result as .vtu";
}

class CellReader {
 public:
  CellReader(UnstructuredMesh& mesh, const VtkXmlFile& file, const VtkXmlPiece& piece,
             uint64_t memory_bytes)
      : mesh_(mesh), file_(file), piece_(piece), memory_bytes_(memory_bytes) {}

  Result<AddedCells> read() {
    if (piece_.cells * 12 > memory_bytes_) return vtk_mesh_too_large(file_.path, memory_bytes_);
    for (const auto step : {&CellReader::read_types, &CellReader::read_ghosts,
                            &CellReader::read_offsets, &CellReader::read_corners}) {
      if (auto done = (this->*step)(); !done) return tl::unexpected(done.error());
    }
    return std::move(added_);
  }

 private:
  tl::unexpected<Error> malformed(const std::string& what) const {
    return malformed_vtk_xml(file_.path, what);
  }

  Result<const VtkXmlArray*> array(const char* name) const {
    for (const VtkXmlArray& each : piece_.topology) {
      if (each.name == name) return &each;
    }
    return malformed(fmt::format("expected the array '{}' in <Cells>", name));
  }

  Result<void> read_types() {
    const auto types = array("types");
    if (!types) return tl::unexpected(types.error());
    int other = -1;
    auto read = visit_vtk_xml_numbers(file_, **types, piece_.cells, [&](double number) {
      if (types_.empty()) types_.reserve(static_cast<size_t>(piece_.cells));
      const bool is_known = number >= 0 && number <= kMaxType;
      const int type = is_known ? static_cast<int>(number) : kMaxType;
      if (is_known && !shape_of(type) && !is_flat(type)) other = type;
      if (!is_known || other >= 0) return false;
      types_.push_back(static_cast<uint8_t>(type));
      return true;
    });
    if (!read) return read;
    if (other >= 0) {
      return fail(
          Status::unsupported_format,
          fmt::format("{}: expected tetrahedra, hexahedra, voxels, wedges and pyramids, found "
                      "cells of VTK's type {}, which are {}",
                      file_.path.string(), other, other_cells(other)));
    }
    if (types_.size() < piece_.cells) {
      return malformed(fmt::format("expected types of cells from 0 to {}", kMaxType));
    }
    return {};
  }

  Result<void> read_ghosts() {
    const auto left_out = left_out_vtk_cells(file_, piece_, piece_.cells);
    if (!left_out) return tl::unexpected(left_out.error());
    for (size_t i = 0; i < left_out->size(); ++i) {
      if (!(*left_out)[i] || !shape_of(types_[i])) continue;
      types_[i] = 0;
      ++added_.ghosts;
    }
    return {};
  }

  Result<void> read_offsets() {
    const auto offsets = array("offsets");
    if (!offsets) return tl::unexpected(offsets.error());
    uint64_t corners = 0, before = 0;
    size_t i = 0;
    std::string problem;
    auto read = visit_vtk_xml_numbers(file_, **offsets, piece_.cells, [&](double number) {
      if (ends_.empty()) ends_.reserve(static_cast<size_t>(piece_.cells));
      // Connectivity is below 2^32 numbers, as memory bounds it.
      if (!(number >= static_cast<double>(before)) || number > 4294967295.0) {
        problem = fmt::format(
            "expected offsets of cells that increase, up to 4294967295, found {} "
            "after {}",
            number, before);
        return false;
      }
      const auto end = static_cast<uint64_t>(number);
      if (const auto shape = shape_of(types_[i])) {
        const auto count = static_cast<uint64_t>(corner_count(*shape));
        if (end - before != count) {
          problem = fmt::format("expected {} points of cell {} of type {}, found {}", count, i,
                                types_[i], end - before);
          return false;
        }
        corners += count;
      }
      ends_.push_back(static_cast<uint32_t>(end));
      before = end;
      ++i;
      return true;
    });
    if (!read) return read;
    if (!problem.empty()) return malformed(problem);
    const uint64_t all = mesh_.corners.size() + corners;
    if (all > 0xffffffffu || (corners + piece_.cells * 4) * 4 > memory_bytes_) {
      return vtk_mesh_too_large(file_.path, memory_bytes_);
    }
    if (all > mesh_.corners.capacity()) {
      mesh_.corners.reserve(
          static_cast<size_t>(std::max<uint64_t>(all, mesh_.corners.size() * 3 / 2)));
    }
    return {};
  }

  Result<void> read_corners() {
    const auto connectivity = array("connectivity");
    if (!connectivity) return tl::unexpected(connectivity.error());
    const auto first_point = static_cast<uint32_t>(mesh_.points.size() - piece_.points);
    const uint64_t total = ends_.empty() ? 0 : ends_.back();
    size_t cell = 0;
    uint64_t at = 0;
    double wrong = -1;
    bool is_wrong = false;
    auto read = visit_vtk_xml_numbers(file_, **connectivity, total, [&](double point) {
      while (ends_[cell] <= at) ++cell;  // cells without points
      const auto shape = shape_of(types_[cell]);
      ++at;
      if (!shape) return true;
      if (!(point >= 0 && point < static_cast<double>(piece_.points))) {
        wrong = point;
        is_wrong = true;
        return false;
      }
      mesh_.corners.push_back(first_point + static_cast<uint32_t>(point));
      if (at == ends_[cell]) finish(cell, *shape);
      return true;
    });
    if (!read) return read;
    if (is_wrong) {
      return malformed(fmt::format("expected points of cells from 0 to {}, found {} in cell {}",
                                   piece_.points - 1, wrong, cell));
    }
    for (const uint8_t type : types_) added_.flat += shape_of(type) ? 0 : 1;
    added_.flat -= added_.ghosts;
    return {};
  }

  /// After the last corner of a cell.
  void finish(size_t cell, CellShape shape) {
    const size_t first = mesh_.corners.size() - static_cast<size_t>(corner_count(shape));
    if (types_[cell] == kVoxel) {  // its corners are in the order of x, y, z
      std::swap(mesh_.corners[first + 2], mesh_.corners[first + 3]);
      std::swap(mesh_.corners[first + 6], mesh_.corners[first + 7]);
    }
    mesh_.begins.push_back(static_cast<uint32_t>(first));
    mesh_.shapes.push_back(shape);
    added_.numbers.push_back(static_cast<uint32_t>(cell));
  }

  UnstructuredMesh& mesh_;
  const VtkXmlFile& file_;
  const VtkXmlPiece& piece_;
  uint64_t memory_bytes_;
  std::vector<uint8_t> types_;
  std::vector<uint32_t> ends_;  ///< of each cell in the connectivity
  AddedCells added_;
};

}  // namespace

Result<AddedCells> add_vtk_cells(UnstructuredMesh& mesh, const VtkXmlFile& file,
                                 const VtkXmlPiece& piece, uint64_t memory_bytes) {
  return CellReader(mesh, file, piece, memory_bytes).read();
}

tl::unexpected<Error> vtk_mesh_too_large(const std::filesystem::path& path, uint64_t memory_bytes) {
  return fail(Status::out_of_memory,
              fmt::format("{}: expected a mesh that fits into {} MiB, found a larger one: raise "
                          "--memory",
                          path.string(), memory_bytes >> 20));
}

}  // namespace isosplat::import
