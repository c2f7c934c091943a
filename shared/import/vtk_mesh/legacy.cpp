#include "shared/import/vtk_mesh/legacy.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "shared/import/vtk/sections.h"
#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {
namespace {

constexpr int64_t kMaxIndex = int64_t{1} << 31;
constexpr uint64_t kMaxCount = 4294967295;

VtkXmlArray array_of(const VtkFile& file, const VtkArray& from) {
  VtkXmlArray array;
  array.name = from.name;
  array.type = from.type;
  array.type_name = from.type_name;
  array.components = from.components;
  array.of_cells = from.of_cells;
  array.format = file.is_binary ? VtkXmlArray::Format::plain : VtkXmlArray::Format::ascii;
  array.begin = from.offset;
  array.end = from.end;
  array.words = from.values * static_cast<uint64_t>(from.components);
  return array;
}

class Converter {
 public:
  Converter(const std::filesystem::path& path, VtkFile file) : from_(std::move(file)) {
    file_.path = path;
    file_.big_endian = from_.is_binary;
  }

  Result<VtkXmlPieces> convert() {
    const bool lacks_points =
        from_.has_point_data && std::all_of(from_.arrays.begin(), from_.arrays.end(),
                                            [](const VtkArray& each) { return each.of_cells; });
    if (from_.ends_early || lacks_points) {
      return fail(Status::truncated,
                  fmt::format("{}: expected more values, found the end of the file: it is "
                              "incomplete; copy or download it again",
                              file_.path.string()));
    }
    if (from_.has_surplus) {
      return malformed_vtk_xml(file_.path, "expected a section or the end of the file");
    }
    // The same preference as for regular grids: SCALARS before FIELDs.
    for (const bool is_field : {false, true}) {
      for (const VtkArray& array : from_.arrays) {
        if (array.is_field == is_field) piece_.arrays.push_back(array_of(from_, array));
      }
    }
    auto done = from_.dataset == "unstructured_grid" ? take_cells() : take_lattice();
    if (!done) return tl::unexpected(done.error());
    file_.pieces.push_back(std::move(piece_));
    VtkXmlPieces grid;
    grid.placed.push_back({0, 0, file_.whole});
    grid.files.push_back(std::move(file_));
    return grid;
  }

 private:
  const VtkArray* geometry(std::string_view name) const {
    for (const VtkArray& each : from_.geometry) {
      if (each.name == name) return &each;
    }
    return nullptr;
  }

  Result<void> take_lattice() {
    file_.grid =
        from_.dataset == "structured_grid" ? VtkXmlGrid::structured : VtkXmlGrid::rectilinear;
    const int64_t sizes[] = {from_.dimensions.x, from_.dimensions.y, from_.dimensions.z};
    for (size_t axis = 0; axis < 3; ++axis) {
      if (sizes[axis] > kMaxIndex) {
        return malformed_vtk_xml(file_.path, "expected DIMENSIONS below 2147483648");
      }
      file_.whole.high[axis] = sizes[axis] - 1;
      const auto* const along = geometry(fmt::format("{}_coordinates", "xyz"[axis]));
      if (along) piece_.coordinates.push_back(array_of(from_, *along));
    }
    piece_.extent = file_.whole;
    if (const auto* const points = geometry("points")) {
      piece_.positions.push_back(array_of(from_, *points));
    }
    return {};
  }

  Result<void> take_cells() {
    const VtkArray *points = geometry("points"), *types = geometry("cell_types"),
                   *cells = geometry("cells"), *offsets = geometry("offsets"),
                   *connectivity = geometry("connectivity");
    const uint64_t count = types ? types->values : 0;
    if (!points || !types || (!cells && !(offsets && connectivity))) {
      return malformed_vtk_xml(file_.path, "expected POINTS, CELLS and CELL_TYPES");
    }
    if (points->values > kMaxCount || count > kMaxCount) {
      return malformed_vtk_xml(file_.path, "expected less than 4294967296 points and cells");
    }
    file_.grid = VtkXmlGrid::unstructured;
    piece_.points = points->values;
    piece_.cells = count;
    piece_.positions.push_back(array_of(from_, *points));
    piece_.topology.push_back(array_of(from_, *types));
    piece_.topology.back().name = "types";
    if (cells) {
      piece_.layout = VtkCellLayout::counts;
      piece_.topology.push_back(array_of(from_, *cells));
      return {};
    }
    piece_.topology.push_back(array_of(from_, *connectivity));
    return take_offsets(array_of(from_, *offsets));
  }

  /// The offset of the first cell, 0, is left out: the XML format has none.
  Result<void> take_offsets(VtkXmlArray offsets) {
    if (offsets.words != piece_.cells + 1) {
      return malformed_vtk_xml(file_.path,
                               fmt::format("expected {} OFFSETS for {} CELL_TYPES, found {}",
                                           piece_.cells + 1, piece_.cells, offsets.words));
    }
    double first = -1;
    auto read = visit_vtk_xml_numbers(file_, offsets, offsets.words, [&](double number) {
      first = number;
      return false;
    });
    if (!read) return read;
    if (first != 0) {
      return malformed_vtk_xml(file_.path,
                               fmt::format("expected OFFSETS from 0 on, found {}", first));
    }
    piece_.layout = VtkCellLayout::offsets;
    piece_.topology.push_back(std::move(offsets));
    return {};
  }

  VtkFile from_;
  VtkXmlFile file_;
  VtkXmlPiece piece_;
};

}  // namespace

Result<VtkXmlPieces> read_vtk_legacy_mesh(const std::filesystem::path& path) {
  auto file = read_vtk_sections(path, {"unstructured_grid", "structured_grid", "rectilinear_grid"});
  if (!file) return tl::unexpected(file.error());
  return Converter(path, std::move(*file)).convert();
}

}  // namespace isosplat::import
