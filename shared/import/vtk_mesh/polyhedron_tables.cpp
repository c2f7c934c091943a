#include "shared/import/vtk_mesh/polyhedron_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "shared/import/vtk_mesh/cells.h"
#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {
namespace {

constexpr uint64_t kMaxCount = 4294967295;
constexpr const char* kToFaces = "polyhedron_to_faces";

const VtkXmlArray* find(const VtkXmlPiece& piece, std::string_view name) {
  const auto found = std::find_if(piece.topology.begin(), piece.topology.end(),
                                  [&](const VtkXmlArray& each) { return each.name == name; });
  return found == piece.topology.end() ? nullptr : &*found;
}

class TableReader {
 public:
  TableReader(const VtkXmlFile& file, const VtkXmlPiece& piece, uint64_t memory_bytes)
      : file_(file), piece_(piece), memory_bytes_(memory_bytes), left_(memory_bytes) {}

  Result<PolyhedronFaces> read() {
    const auto cell_ends = numbers("polyhedron_offsets", piece_.cells, Order::ends);
    if (!cell_ends) return tl::unexpected(cell_ends.error());
    const uint64_t references = cell_ends->empty() ? 0 : cell_ends->back();
    const auto faces = numbers(kToFaces, references, Order::any);
    if (!faces) return tl::unexpected(faces.error());
    uint64_t count = 0;
    for (const uint32_t face : *faces) count = std::max<uint64_t>(count, uint64_t{face} + 1);
    const auto face_ends = numbers("face_offsets", count, Order::ends);
    if (!face_ends) return tl::unexpected(face_ends.error());
    const auto points =
        numbers("face_connectivity", face_ends->empty() ? 0 : face_ends->back(), Order::any);
    if (!points) return tl::unexpected(points.error());
    return joined(*cell_ends, *faces, *face_ends, *points);
  }

 private:
  enum class Order { any, ends };
  using Numbers = std::vector<uint32_t>;

  /// Counts memory before it is allocated.
  Result<void> take(uint64_t count) {
    if (count > left_ / sizeof(uint32_t)) return vtk_mesh_too_large(file_.path, memory_bytes_);
    left_ -= count * sizeof(uint32_t);
    return {};
  }

  Result<Numbers> numbers(const char* name, uint64_t count, Order order) {
    const VtkXmlArray* const array = find(piece_, name);
    if (!array) {
      return malformed_vtk_xml(file_.path, fmt::format("expected the array '{}' in <Cells>", name));
    }
    if (auto fits = take(count); !fits) return tl::unexpected(fits.error());
    Numbers all;
    double before = 0;
    std::optional<double> wrong;
    auto read = visit_vtk_xml_numbers(file_, *array, count, [&](double number) {
      if (all.empty()) all.reserve(static_cast<size_t>(count));
      if (!(number >= before) || number >= static_cast<double>(kMaxCount)) {
        wrong = number;
        return false;
      }
      if (order == Order::ends) before = number;
      all.push_back(static_cast<uint32_t>(number));
      return true;
    });
    if (!read) return tl::unexpected(read.error());
    if (!wrong) return all;
    return malformed_vtk_xml(
        file_.path,
        fmt::format("expected {} in the array '{}', found {}",
                    order == Order::ends ? "numbers that increase, from 0 on" : "numbers from 0 on",
                    name, *wrong));
  }

  Result<PolyhedronFaces> joined(const Numbers& cell_ends, const Numbers& faces,
                                 const Numbers& face_ends, const Numbers& points) {
    const auto begin_of = [&](uint32_t face) { return face == 0 ? 0 : face_ends[face - 1]; };
    uint64_t total = cell_ends.size();  // a face may be in many cells
    for (const uint32_t face : faces) total += uint64_t{1} + face_ends[face] - begin_of(face);
    if (auto fits = take(total + cell_ends.size()); !fits) return tl::unexpected(fits.error());
    if (total > kMaxCount) return vtk_mesh_too_large(file_.path, memory_bytes_);
    PolyhedronFaces all;
    all.stream.reserve(static_cast<size_t>(total));
    all.ends.reserve(cell_ends.size());
    size_t at = 0;
    for (const uint32_t end : cell_ends) {
      if (end > at) all.stream.push_back(end - static_cast<uint32_t>(at));
      for (; at < end; ++at) {
        const uint32_t first = begin_of(faces[at]), last = face_ends[faces[at]];
        all.stream.push_back(last - first);
        all.stream.insert(all.stream.end(), points.begin() + first, points.begin() + last);
      }
      all.ends.push_back(static_cast<uint32_t>(all.stream.size()));
    }
    return all;
  }

  const VtkXmlFile& file_;
  const VtkXmlPiece& piece_;
  uint64_t memory_bytes_, left_;
};

}  // namespace

bool has_polyhedron_tables(const VtkXmlPiece& piece) {
  return find(piece, kToFaces) != nullptr;
}

Result<PolyhedronFaces> read_polyhedron_tables(const VtkXmlFile& file, const VtkXmlPiece& piece,
                                               uint64_t memory_bytes) {
  return TableReader(file, piece, memory_bytes).read();
}

}  // namespace isosplat::import
