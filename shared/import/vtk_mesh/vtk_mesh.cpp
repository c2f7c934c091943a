#include "shared/import/vtk_mesh/vtk_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "shared/import/codecs/file_head.h"
#include "shared/import/vtk/axes.h"
#include "shared/import/vtk_mesh/cells.h"
#include "shared/import/vtk_mesh/lattice_cells.h"
#include "shared/import/vtk_mesh/legacy.h"
#include "shared/import/vtk_mesh/points.h"
#include "shared/import/vtk_xml/choose.h"
#include "shared/import/vtk_xml/numbers.h"
#include "shared/import/vtk_xml/rectilinear.h"

namespace isosplat::import {
namespace {

using Path = std::filesystem::path;

class Reader {
 public:
  Reader(const Path& path, const ImportOptions& options, uint64_t memory_bytes)
      : path_(path), options_(options), memory_bytes_(memory_bytes) {}

  Result<OpenMesh> read() {
    if (options_.spacing) {
      return fail(
          Status::invalid_argument,
          path_.string() + ": --spacing: expected none for a mesh, whose points have positions");
    }
    const auto head = read_head(path_);
    if (!head) return tl::unexpected(head.error());
    const bool is_legacy = !vtk_dataset(head->bytes()).empty();
    open_.format = is_legacy ? "VTK" : "VTK XML";
    const auto grid = is_legacy ? read_vtk_legacy_mesh(path_) : read_vtk_xml_pieces(path_);
    if (!grid) return tl::unexpected(grid.error());
    open_.name = path_.stem().string();
    for (const VtkXmlFile& file : grid->files) open_.files.push_back(file.path);
    if (auto checked = check_sizes(*grid); !checked) return tl::unexpected(checked.error());
    for (const VtkXmlPlaced& placed : grid->placed) {
      const VtkXmlFile& file = grid->files[placed.file];
      if (auto added = add(file, grid->piece(placed), placed.used); !added) {
        return tl::unexpected(added.error());
      }
    }
    if (!chosen_) return malformed_vtk_xml(path_, "expected points and cells, found none");
    finish();
    open_.mesh = std::move(builder_.mesh);
    return std::move(open_);
  }

 private:
  uint64_t left() const {
    const uint64_t used = builder_.memory_bytes() + cell_values_.size() * sizeof(double);
    return memory_bytes_ - std::min(memory_bytes_, used);
  }

  /// Before memory is allocated.
  Result<void> check_sizes(const VtkXmlPieces& grid) {
    for (const VtkXmlPlaced& placed : grid.placed) {
      total_points_ += vtk_points_of(grid.files[placed.file], grid.piece(placed));
    }
    if (total_points_ > memory_bytes_ / (sizeof(Vec3d) + sizeof(double)) ||
        total_points_ > std::numeric_limits<uint32_t>::max()) {
      return vtk_mesh_too_large(path_, memory_bytes_);
    }
    if (grid.main().grid == VtkXmlGrid::unstructured) return {};
    const auto points = vtk_xml_points(grid.main());
    if (*std::min_element(points.begin(), points.end()) >= 2) {
      note_gaps(grid, points);
      return {};
    }
    return fail(Status::unsupported_format,
                fmt::format("{}: expected a grid of three dimensions, with at least 2 points along "
                            "each axis, found {}×{}×{} points, which enclose no volume",
                            path_.string(), points[0], points[1], points[2]));
  }

  /// Notes cells of a lattice that no piece has.
  void note_gaps(const VtkXmlPieces& grid, const std::array<int64_t, 3>& points) {
    double found = 0, whole = 1;
    for (const VtkXmlPlaced& placed : grid.placed) {
      double cells = 1;
      for (size_t axis = 0; axis < 3; ++axis) {
        cells *= static_cast<double>(placed.used.high[axis] - placed.used.low[axis]);
      }
      found += cells;
    }
    for (const int64_t each : points) whole *= static_cast<double>(each - 1);
    if (found >= whole) return;
    open_.notes.push_back(fmt::format(
        "the pieces have {:.0f} of the {:.0f} cells of the whole grid: the others are left out",
        found, whole));
  }

  Result<void> choose(const VtkXmlFile& file, const VtkXmlPiece& piece) {
    const auto chosen = choose_vtk_xml_array(file, piece.arrays, options_, open_.notes);
    if (!chosen) return tl::unexpected(chosen.error());
    chosen_ = piece.arrays[chosen->array];
    component_ = chosen->component;
    return {};
  }

  Result<void> add(const VtkXmlFile& file, const VtkXmlPiece& piece, const VtkXmlExtent& used) {
    if (!chosen_) {
      if (auto done = choose(file, piece); !done) return done;
    }
    const size_t first_point = builder_.mesh.points.size();
    if (auto read = add_vtk_points(builder_.mesh, file, piece, total_points_); !read) return read;
    const auto cells = file.grid == VtkXmlGrid::unstructured
                           ? add_vtk_cells(builder_, file, piece, left())
                           : add_vtk_lattice_cells(builder_, file, piece, used, left());
    if (!cells) return tl::unexpected(cells.error());
    flat_ += cells->flat;
    ghosts_ += cells->ghosts;
    divided_ += cells->divided;
    cells_ += cells->cells;
    const auto array =
        std::find_if(piece.arrays.begin(), piece.arrays.end(), [&](const VtkXmlArray& each) {
          return each.name == chosen_->name && each.of_cells == chosen_->of_cells &&
                 each.components == chosen_->components;
        });
    if (array == piece.arrays.end()) {
      return malformed_vtk_xml(
          file.path, fmt::format("expected the array '{}' in each piece, with the same components",
                                 chosen_->name));
    }
    return add_values(file, piece, *array, cells->numbers, first_point);
  }

  double value(double number) const {
    const bool is_missing = options_.missing_value && number == *options_.missing_value;
    return is_missing ? std::numeric_limits<double>::quiet_NaN() : number;
  }

  /// `cells`: the numbers of the piece's cells that are in the mesh, or of which parts are.
  Result<void> add_values(const VtkXmlFile& file, const VtkXmlPiece& piece,
                          const VtkXmlArray& array, const std::vector<uint32_t>& cells,
                          size_t first_point) {
    const auto components = static_cast<uint64_t>(array.components);
    const uint64_t count = array.of_cells ? vtk_cells_of(file, piece) : vtk_points_of(file, piece);
    uint64_t at = 0;
    auto next = cells.begin();
    std::vector<double>& values = builder_.mesh.values;
    if (!array.of_cells && values.empty()) {
      values.reserve(builder_.mesh.points.capacity());
    }
    return visit_vtk_xml_numbers(file, array, count * components, [&](double number) {
      const uint64_t index = at / components, component = at % components;
      ++at;
      if (component != component_) return true;
      if (!array.of_cells) {
        if (values.size() <= first_point) values.resize(builder_.mesh.points.size());
        values[first_point + static_cast<size_t>(index)] = value(number);
        return true;
      }
      for (bool is_first = true; next != cells.end() && *next == index; ++next, is_first = false) {
        cell_values_.push_back(value(number));
        is_first_part_.push_back(is_first);
      }
      return true;
    });
  }

  /// Removes the cells without a value from the mesh.
  void leave_out_missing() {
    UnstructuredMesh& mesh = builder_.mesh;
    size_t kept = 0;
    uint64_t missing = 0;  // of the file
    for (size_t cell = 0; cell < mesh.cells(); ++cell) {
      if (!std::isfinite(cell_values_[cell])) {
        missing += is_first_part_[cell] ? 1 : 0;
        continue;
      }
      mesh.shapes[kept] = mesh.shapes[cell];
      mesh.begins[kept] = mesh.begins[cell];
      cell_values_[kept++] = cell_values_[cell];
    }
    if (kept == mesh.cells()) return;
    open_.notes.push_back(fmt::format("{} cells have no value: they are left out", missing));
    mesh.shapes.resize(kept);
    mesh.begins.resize(kept);
    cell_values_.resize(kept);
  }

  void finish() {
    const size_t parts = builder_.mesh.cells();
    if (chosen_->of_cells) {
      leave_out_missing();
      builder_.mesh.values = values_at_points(builder_.mesh, cell_values_);
      open_.notes.push_back(fmt::format(
          "the values of '{}' belong to cells: each point has the average of the cells around it, "
          "weighted by their volumes",
          chosen_->name));
    } else {
      builder_.set_values();
    }
    if (divided_ > 0) {
      open_.notes.push_back(fmt::format(
          "{} cells, which are quadratic or polyhedra, were divided into {} linear ones", divided_,
          parts - (cells_ - divided_)));
    }
    if (flat_ > 0) {
      open_.notes.push_back(fmt::format(
          "{} cells are points, lines or faces, which have no volume: they are left out", flat_));
    }
    if (ghosts_ > 0) {
      open_.notes.push_back(
          fmt::format("{} cells are marked as repeated or hidden: they are left out", ghosts_));
    }
  }

  const Path& path_;
  const ImportOptions& options_;
  uint64_t memory_bytes_;
  OpenMesh open_;
  MeshBuilder builder_;
  std::optional<VtkXmlArray> chosen_;
  uint64_t component_ = 0, total_points_ = 0;
  std::vector<double> cell_values_;  ///< of the cells in the mesh
  std::vector<bool> is_first_part_;  ///< of these, whether they are the first part of a cell
  uint64_t flat_ = 0, ghosts_ = 0, cells_ = 0, divided_ = 0;
};

}  // namespace

bool is_vtk_mesh(const FileHead& head) {
  if (const std::string dataset = vtk_dataset(head.bytes()); !dataset.empty()) {
    if (dataset == "rectilinear_grid") {
      return head.packing == Packing::none && is_uneven_vtk_legacy(head.path);
    }
    return dataset == "unstructured_grid" || dataset == "structured_grid";
  }
  const std::string type = vtk_xml_type(head.bytes());
  const std::string_view plain = std::string_view(type).substr(type.starts_with('P') ? 1 : 0);
  if (plain == "RectilinearGrid") {
    return head.packing == Packing::none && is_uneven_vtk_xml(head.path);
  }
  return plain == "UnstructuredGrid" || plain == "StructuredGrid";
}

Result<OpenMesh> open_vtk_mesh(const Path& path, const ImportOptions& options,
                               uint64_t memory_bytes) {
  const auto head = read_head(path);
  if (!head) return tl::unexpected(head.error());
  if (head->packing != Packing::none) {
    return fail(Status::unsupported_format,
                path.string() +
                    ": expected a mesh, found one that is compressed as a whole: decompress it "
                    "first (gunzip, unzstd, …), or save it with VTK's own compression");
  }
  return Reader(path, options, memory_bytes).read();
}

}  // namespace isosplat::import
