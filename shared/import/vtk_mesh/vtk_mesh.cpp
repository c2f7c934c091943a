#include "shared/import/vtk_mesh/vtk_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "shared/import/vtk_mesh/cells.h"
#include "shared/import/vtk_xml/choose.h"
#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {
namespace {

using Path = std::filesystem::path;

class Reader {
 public:
  Reader(const Path& path, const ImportOptions& options, uint64_t memory_bytes)
      : path_(path), options_(options), memory_bytes_(memory_bytes) {}

  Result<OpenMesh> read() {
    if (options_.spacing) {
      return fail(Status::invalid_argument,
                  path_.string() +
                      ": --spacing: expected none for an unstructured grid, whose points "
                      "have positions");
    }
    auto main = read_vtk_xml(path_);
    if (!main) return tl::unexpected(main.error());
    open_.name = path_.stem().string();
    open_.files.push_back(path_);
    if (!main->is_parallel) {
      if (auto added = add_file(*main); !added) return tl::unexpected(added.error());
    }
    for (const VtkXmlPiece& piece : main->is_parallel ? main->pieces : std::vector<VtkXmlPiece>()) {
      const Path source = path_.parent_path() / piece.source;
      const auto file = read_vtk_xml(source);
      if (!file) return tl::unexpected(file.error());
      if (file->is_parallel || file->grid != VtkXmlGrid::unstructured) {
        return malformed_vtk_xml(source, "expected a piece of an unstructured grid");
      }
      open_.files.push_back(source);
      if (auto added = add_file(*file); !added) return tl::unexpected(added.error());
    }
    if (!chosen_) return malformed_vtk_xml(path_, "expected points and cells, found none");
    finish();
    return std::move(open_);
  }

 private:
  uint64_t left() const {
    const uint64_t used = open_.mesh.memory_bytes() + cell_values_.size() * sizeof(double);
    return memory_bytes_ - std::min(memory_bytes_, used);
  }

  Result<void> add_file(const VtkXmlFile& file) {
    for (const VtkXmlPiece& piece : file.pieces) {
      if (!chosen_) {
        const auto chosen = choose_vtk_xml_array(file, piece.arrays, options_, open_.notes);
        if (!chosen) return tl::unexpected(chosen.error());
        chosen_ = piece.arrays[chosen->array];
        component_ = chosen->component;
      }
      if (auto added = add(file, piece); !added) return added;
    }
    return {};
  }

  Result<void> add(const VtkXmlFile& file, const VtkXmlPiece& piece) {
    if (piece.points * (sizeof(Vec3d) + sizeof(double)) > left() ||
        open_.mesh.points.size() + piece.points > std::numeric_limits<uint32_t>::max()) {
      return vtk_mesh_too_large(path_, memory_bytes_);
    }
    if (auto read = add_points(file, piece); !read) return read;
    const auto cells = add_vtk_cells(open_.mesh, file, piece, left());
    if (!cells) return tl::unexpected(cells.error());
    flat_ += cells->flat;
    ghosts_ += cells->ghosts;
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
    return add_values(file, piece, *array, cells->numbers);
  }

  Result<void> add_points(const VtkXmlFile& file, const VtkXmlPiece& piece) {
    if (piece.positions.size() != 1 || piece.positions.front().components != 3) {
      return malformed_vtk_xml(file.path, "expected an array of 3 components in <Points>");
    }
    std::vector<Vec3d>& points = open_.mesh.points;
    Vec3d point{0, 0, 0};
    int axis = 0;
    bool is_finite = true;
    auto read = visit_vtk_xml_numbers(
        file, piece.positions.front(), 3 * piece.points, [&](double position) {
          // The size in the file has been checked.
          if (axis == 0 && points.capacity() == points.size()) {
            points.reserve(points.size() + static_cast<size_t>(piece.points));
          }
          is_finite = std::isfinite(position) && std::abs(position) < 1e100;
          (axis == 0 ? point.x : axis == 1 ? point.y : point.z) = position;
          axis = (axis + 1) % 3;
          if (axis == 0) points.push_back(point);
          return is_finite;
        });
    if (!read) return read;
    if (is_finite) return {};
    return malformed_vtk_xml(file.path, fmt::format("expected finite positions of points, found "
                                                    "others at point {}",
                                                    points.size()));
  }

  double value(double number) const {
    const bool is_missing = options_.missing_value && number == *options_.missing_value;
    return is_missing ? std::numeric_limits<double>::quiet_NaN() : number;
  }

  /// `cells`: the numbers of the piece's cells that are in the mesh.
  Result<void> add_values(const VtkXmlFile& file, const VtkXmlPiece& piece,
                          const VtkXmlArray& array, const std::vector<uint32_t>& cells) {
    const auto components = static_cast<uint64_t>(array.components);
    const uint64_t count = array.of_cells ? piece.cells : piece.points;
    uint64_t at = 0;
    auto next = cells.begin();
    return visit_vtk_xml_numbers(file, array, count * components, [&](double number) {
      const uint64_t index = at / components, component = at % components;
      ++at;
      if (component != component_) return true;
      if (!array.of_cells) {
        open_.mesh.values.push_back(value(number));
      } else if (next != cells.end() && *next == index) {
        cell_values_.push_back(value(number));
        ++next;
      }
      return true;
    });
  }

  /// Removes the cells without a value from the mesh.
  void leave_out_missing() {
    UnstructuredMesh& mesh = open_.mesh;
    size_t kept = 0;
    for (size_t cell = 0; cell < mesh.cells(); ++cell) {
      if (!std::isfinite(cell_values_[cell])) continue;
      mesh.shapes[kept] = mesh.shapes[cell];
      mesh.begins[kept] = mesh.begins[cell];
      cell_values_[kept++] = cell_values_[cell];
    }
    if (kept == mesh.cells()) return;
    open_.notes.push_back(
        fmt::format("{} cells have no value: they are left out", mesh.cells() - kept));
    mesh.shapes.resize(kept);
    mesh.begins.resize(kept);
    cell_values_.resize(kept);
  }

  void finish() {
    if (chosen_->of_cells) {
      leave_out_missing();
      open_.mesh.values = values_at_points(open_.mesh, cell_values_);
      open_.notes.push_back(fmt::format(
          "the values of '{}' belong to cells: each point has the average of the cells around it, "
          "weighted by their volumes",
          chosen_->name));
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
  std::optional<VtkXmlArray> chosen_;
  uint64_t component_ = 0;
  std::vector<double> cell_values_;  ///< of the cells in the mesh
  uint64_t flat_ = 0, ghosts_ = 0;
};

}  // namespace

bool is_vtk_mesh(std::string_view beginning) {
  const std::string type = vtk_xml_type(beginning);
  return type == "UnstructuredGrid" || type == "PUnstructuredGrid";
}

Result<OpenMesh> open_vtk_mesh(const Path& path, const ImportOptions& options,
                               uint64_t memory_bytes) {
  return Reader(path, options, memory_bytes).read();
}

}  // namespace isosplat::import
