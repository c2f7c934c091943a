#include "shared/import/vtk_mesh/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "shared/import/vtk_mesh/cell_division.h"
#include "shared/import/vtk_mesh/ghosts.h"
#include "shared/import/vtk_mesh/polyhedra.h"
#include "shared/import/vtk_mesh/polyhedron_tables.h"
#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {
namespace {

/// VTK's numbers of cell types (vtkCellType.h).
constexpr int kTetrahedron = 10, kPentagonalPrism = 15, kHexagonalPrism = 16, kConvexSet = 41,
              kPolyhedron = 42;
constexpr int kMaxType = 82;
constexpr uint64_t kMaxCount = 4294967295;

bool is_prism(int type) {
  return type == kPentagonalPrism || type == kHexagonalPrism;
}

bool is_volume(int type) {
  return division_of(type) || is_prism(type) || type == kPolyhedron;
}

/// The number of nodes of a cell. Nothing for polyhedra, which have any number.
std::optional<uint64_t> node_count(int type) {
  if (const CellDivision* const division = division_of(type)) return division->nodes;
  if (is_prism(type)) return type == kPentagonalPrism ? 10 : 12;
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
  if (type == kConvexSet) {
    return "sets of points: in ParaView divide them with Filters > Tetrahedralize, and save the "
           "result as .vtu";
  }
  return "cells of higher order: in ParaView make them linear with Filters > Tessellate, and save "
         "the result as .vtu";
}

/// The bytes for the parts of a cell. Polyhedra: without those of their faces.
uint64_t bytes_of(int type) {
  uint64_t bytes = 0;
  if (const CellDivision* const division = division_of(type)) {
    for (const CellPart& part : division->parts) {
      bytes += sizeof(CellShape) +
               (2 + static_cast<uint64_t>(corner_count(part.shape))) * sizeof(uint32_t);
    }
    for (const CellPoint& point : division->points) {
      bytes += MeshBuilder::point_bytes(point.corner_count + point.middle_count);
    }
  } else if (const auto nodes = node_count(type)) {
    bytes = polyhedron_bytes(3 * *nodes + 2 + *nodes / 2);
  }
  return bytes;
}

class CellReader {
 public:
  CellReader(MeshBuilder& builder, const VtkXmlFile& file, const VtkXmlPiece& piece,
             uint64_t memory_bytes)
      : builder_(builder), file_(file), piece_(piece), memory_bytes_(memory_bytes) {}

  Result<AddedCells> read() {
    if (piece_.cells * 12 > memory_bytes_) return vtk_mesh_too_large(file_.path, memory_bytes_);
    for (const auto step :
         {&CellReader::read_types, &CellReader::read_ghosts, &CellReader::read_offsets,
          &CellReader::read_faces, &CellReader::read_corners}) {
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
      if (is_known && !is_volume(type) && !is_flat(type)) other = type;
      if (!is_known || other >= 0) return false;
      types_.push_back(static_cast<uint8_t>(type));
      return true;
    });
    if (!read) return read;
    if (other >= 0) {
      return fail(
          Status::unsupported_format,
          fmt::format("{}: expected linear and quadratic cells, prisms and polyhedra, found "
                      "cells of VTK's type {}, which are {}",
                      file_.path.string(), other, other_cells(other)));
    }
    if (types_.size() < piece_.cells) {
      return malformed(fmt::format("expected types of cells from 0 to {}", kMaxType));
    }
    return {};
  }

  Result<void> read_ghosts() {
    for (const uint8_t type : types_) added_.flat += is_volume(type) ? 0 : 1;
    const auto left_out = left_out_vtk_cells(file_, piece_, piece_.cells);
    if (!left_out) return tl::unexpected(left_out.error());
    for (size_t i = 0; i < left_out->size(); ++i) {
      if (!(*left_out)[i] || !is_volume(types_[i])) continue;
      types_[i] = 0;
      ++added_.ghosts;
    }
    return {};
  }

  Result<void> read_offsets() {
    const bool has_counts = piece_.layout == VtkCellLayout::counts;
    const auto offsets = array(has_counts ? "cells" : "offsets");
    if (!offsets) return tl::unexpected(offsets.error());
    uint64_t bytes = 0, before = 0, parts = 0, points = 0, corners = 0;
    size_t i = 0;
    std::string problem;
    const auto add_end = [&](double number) {
      if (ends_.empty()) ends_.reserve(static_cast<size_t>(piece_.cells));
      // Connectivity is below 2^32 numbers, as memory bounds it.
      if (!(number >= static_cast<double>(before)) || number > static_cast<double>(kMaxCount)) {
        problem = fmt::format(
            "expected offsets of cells that increase, up to {}, found {} "
            "after {}",
            kMaxCount, number, before);
        return false;
      }
      const auto end = static_cast<uint64_t>(number);
      const uint64_t nodes = end - before - (has_counts ? 1 : 0);
      const auto count = node_count(types_[i]);
      if (count && nodes != *count) {
        problem = fmt::format("expected {} points of cell {} of type {}, found {}", *count, i,
                              types_[i], nodes);
        return false;
      }
      if (types_[i] == kPolyhedron && nodes < 4) {
        problem =
            fmt::format("expected at least 4 points of cell {}, a polyhedron, found {}", i, nodes);
        return false;
      }
      bytes += bytes_of(types_[i]);
      if (types_[i] == kPolyhedron && has_inline_faces()) bytes += polyhedron_bytes(nodes);
      if (const CellDivision* const division = division_of(types_[i])) {
        parts += division->parts.size();
        points += division->points.size();
        for (const CellPart& part : division->parts) {
          corners += static_cast<uint64_t>(corner_count(part.shape));
        }
      }
      ends_.push_back(static_cast<uint32_t>(end));
      before = end;
      ++i;
      return true;
    };
    // The numbers of the array, and those of them that are no ends.
    const uint64_t first = piece_.layout == VtkCellLayout::offsets ? 1 : 0;
    const uint64_t total = has_counts ? (*offsets)->words : piece_.cells + first;
    uint64_t at = 0, next = first;
    auto read = visit_vtk_xml_numbers(file_, **offsets, total, [&](double number) {
      if (at++ < next) return true;  // a node, or the 0 before the offsets
      if (!has_counts) return add_end(number);
      if (i == piece_.cells || !(number >= 0) || number > static_cast<double>(total - at)) {
        problem = fmt::format(
            "expected CELLS with the nodes of {} cells, found {} as the number of "
            "nodes of cell {}",
            piece_.cells, number, i);
        return false;
      }
      next = at + static_cast<uint64_t>(number);
      return add_end(static_cast<double>(before) + 1 + number);
    });
    if (!read) return read;
    if (!problem.empty()) return malformed(problem);
    if (i < piece_.cells) {
      return malformed(
          fmt::format("expected the nodes of {} cells, found those of {}", piece_.cells, i));
    }
    bytes_ = bytes;
    if (auto fits = check_size(); !fits) return fits;
    UnstructuredMesh& mesh = builder_.mesh;
    reserve_more(mesh.shapes, parts);
    reserve_more(mesh.begins, parts);
    reserve_more(mesh.corners, corners);
    reserve_more(mesh.points, points);
    reserve_more(added_.numbers, parts);
    return {};
  }

  /// Reserves exactly for the first piece, and at least half as much more for others, so that many
  /// pieces do not copy a vector many times.
  template <class T>
  static void reserve_more(std::vector<T>& of, uint64_t more) {
    const auto needed = of.size() + static_cast<size_t>(more);
    if (needed > of.capacity()) of.reserve(std::max(needed, of.capacity() * 3 / 2));
  }

  /// Before cells are allocated.
  Result<void> check_size() const {
    const uint64_t own = piece_.cells * 5;  // types_ and ends_
    // Each corner and point has at least four bytes, and their numbers have 32 bits.
    const UnstructuredMesh& mesh = builder_.mesh;
    const uint64_t before = std::max(mesh.corners.size(), mesh.points.size());
    if (bytes_ + own > memory_bytes_ || bytes_ / sizeof(uint32_t) + before > kMaxCount) {
      return vtk_mesh_too_large(file_.path, memory_bytes_);
    }
    return {};
  }

  /// Legacy files have the faces of a polyhedron in place of its nodes.
  bool has_inline_faces() const { return piece_.layout != VtkCellLayout::ends; }

  /// The faces of all polyhedra: of each its number of faces, and then of each face the number of
  /// its points and the points.
  Result<void> read_faces() {
    if (has_inline_faces()) return {};
    if (std::find(types_.begin(), types_.end(), kPolyhedron) == types_.end()) return {};
    if (has_polyhedron_tables(piece_)) return read_tables();
    const auto offsets = array("faceoffsets"), faces = array("faces");
    if (!offsets) return tl::unexpected(offsets.error());
    if (!faces) return tl::unexpected(faces.error());
    uint64_t before = 0;
    size_t i = 0;
    std::optional<double> wrong;
    auto read = visit_vtk_xml_numbers(file_, **offsets, piece_.cells, [&](double number) {
      if (face_ends_.empty()) face_ends_.reserve(static_cast<size_t>(piece_.cells));
      // Cells of other types have −1.
      if (number >= 0 || types_[i] == kPolyhedron) {
        if (!(number >= static_cast<double>(before)) || number > static_cast<double>(kMaxCount)) {
          wrong = number;
          return false;
        }
        before = static_cast<uint64_t>(number);
      }
      face_ends_.push_back(static_cast<uint32_t>(before));
      ++i;
      return true;
    });
    if (!read) return read;
    if (wrong) {
      return malformed(
          fmt::format("expected faceoffsets that increase, up to {}, found {} after {}", kMaxCount,
                      *wrong, before));
    }
    bytes_ += polyhedron_bytes(before) + before * sizeof(uint32_t);
    if (auto fits = check_size(); !fits) return fits;
    return visit_vtk_xml_numbers(file_, **faces, before, [&](double number) {
      if (faces_.empty()) faces_.reserve(static_cast<size_t>(before));
      const bool fits = number >= 0 && number <= static_cast<double>(kMaxCount);
      faces_.push_back(fits ? static_cast<uint32_t>(number) : uint32_t{kMaxCount});
      return true;
    });
  }

  Result<void> read_tables() {
    const uint64_t own = bytes_ + piece_.cells * 5;  // as in check_size()
    auto tables =
        read_polyhedron_tables(file_, piece_, memory_bytes_ - std::min(memory_bytes_, own));
    if (!tables) return tl::unexpected(tables.error());
    face_ends_ = std::move(tables->ends);
    faces_ = std::move(tables->stream);
    bytes_ += polyhedron_bytes(faces_.size()) + faces_.size() * sizeof(uint32_t);
    return check_size();
  }

  Result<void> read_corners() {
    const bool has_counts = piece_.layout == VtkCellLayout::counts;
    const auto connectivity = array(has_counts ? "cells" : "connectivity");
    if (!connectivity) return tl::unexpected(connectivity.error());
    first_point_ = builder_.mesh.points.size() - piece_.points;
    const uint64_t total = ends_.empty() ? 0 : ends_.back();
    size_t cell = 0;
    uint64_t at = 0;
    Result<void> added;
    auto read = visit_vtk_xml_numbers(file_, **connectivity, total, [&](double point) {
      while (ends_[cell] <= at) added = finish(cell++);  // cells without points
      const bool is_count = has_counts && at == (cell == 0 ? 0 : ends_[cell - 1]);
      ++at;
      if (has_inline_faces() && !is_count && types_[cell] == kPolyhedron) {
        const bool fits = point >= 0 && point <= static_cast<double>(kMaxCount);
        nodes_.push_back(fits ? static_cast<uint32_t>(point) : uint32_t{kMaxCount});
      } else if (!is_count && is_volume(types_[cell])) {
        const auto index = index_of(point, cell);
        if (!index) {
          added = tl::unexpected(index.error());
          return false;
        }
        nodes_.push_back(*index);
      }
      if (at == ends_[cell]) added = finish(cell++);
      return added.has_value();
    });
    if (!read) return read;
    return added;
  }

  /// The index of a point of the piece in the mesh.
  Result<uint32_t> index_of(double point, size_t cell) const {
    if (point >= 0 && point < static_cast<double>(piece_.points)) {
      return static_cast<uint32_t>(first_point_) + static_cast<uint32_t>(point);
    }
    return malformed(fmt::format("expected points of cells from 0 to {}, found {} in cell {}",
                                 static_cast<int64_t>(piece_.points) - 1, point, cell));
  }

  /// After the last node of a cell.
  Result<void> finish(size_t cell) {
    const int type = types_[cell];
    size_t parts = 0;
    if (division_of(type)) {
      parts = add_divided(builder_, type, nodes_);
    } else if (is_prism(type)) {
      parts = add_polyhedron(builder_, prism_faces(nodes_));
    } else if (type == kPolyhedron) {
      const auto faces = faces_of(cell);
      if (!faces) return tl::unexpected(faces.error());
      parts = add_polyhedron(builder_, *faces);
    }
    nodes_.clear();
    added_.numbers.insert(added_.numbers.end(), parts, static_cast<uint32_t>(cell));
    added_.cells += parts > 0 ? 1 : 0;
    added_.divided += parts > 1 ? 1 : 0;
    return {};
  }

  /// The faces of a polyhedron, with the indices of the mesh's points.
  Result<std::vector<uint32_t>> faces_of(size_t cell) const {
    std::span<const uint32_t> of_cell = nodes_;
    if (!has_inline_faces()) {
      const size_t begin = cell == 0 ? 0 : face_ends_[cell - 1];
      of_cell = std::span(faces_).subspan(begin, face_ends_[cell] - begin);
    }
    if (of_cell.empty() || !is_polyhedron(of_cell.subspan(1), of_cell[0])) {
      return malformed(
          fmt::format("expected the faces of cell {}, at least 4 with at least 3 points, found "
                      "others",
                      cell));
    }
    std::vector<uint32_t> faces(of_cell.begin() + 1, of_cell.end());
    for (size_t at = 0; at < faces.size();) {
      const size_t end = at + faces[at] + 1;
      while (++at < end) {
        const auto index = index_of(faces[at], cell);
        if (!index) return tl::unexpected(index.error());
        faces[at] = *index;
      }
    }
    return faces;
  }

  MeshBuilder& builder_;
  const VtkXmlFile& file_;
  const VtkXmlPiece& piece_;
  uint64_t memory_bytes_;
  std::vector<uint8_t> types_;
  std::vector<uint32_t> ends_;       ///< of each cell in the connectivity
  std::vector<uint32_t> face_ends_;  ///< of each cell in the faces; empty without polyhedra
  std::vector<uint32_t> faces_;
  std::vector<uint32_t> nodes_;  ///< of the cell that is read
  uint64_t first_point_ = 0, bytes_ = 0;
  AddedCells added_;
};

}  // namespace

Result<AddedCells> add_vtk_cells(MeshBuilder& builder, const VtkXmlFile& file,
                                 const VtkXmlPiece& piece, uint64_t memory_bytes) {
  return CellReader(builder, file, piece, memory_bytes).read();
}

tl::unexpected<Error> vtk_mesh_too_large(const std::filesystem::path& path, uint64_t memory_bytes) {
  return fail(Status::out_of_memory,
              fmt::format("{}: expected a mesh that fits into the memory, of which {} MiB are left "
                          "for it here, found a larger one: raise --memory",
                          path.string(), memory_bytes >> 20));
}

}  // namespace isosplat::import
