#include "native/extract/npy_encoder.h"

#include <fmt/format.h>

#include <array>
#include <span>

#include "native/extract/array_bytes.h"
#include "native/extract/npy_header.h"
#include "shared/core/points/position_precision.h"

namespace isosplat {

namespace {

constexpr std::array<std::string_view, 3> kColumns{"position", "normal", "value"};

/// More than the type of a field needs: a name of 64 characters or a little more.
constexpr size_t kFieldHeaderBytes = 128;

}  // namespace

NpyEncoder::NpyEncoder(const VolumeGrid& grid, double isovalue, std::span<const FieldColumn> fields)
    : has_doubles_(needs_doubles(grid)),
      isovalue_(isovalue),
      fields_(column_names(fields, kColumns)) {}

size_t NpyEncoder::header_bytes() const {
  return kNpyHeaderBytes + kFieldHeaderBytes * fields_.size();
}

std::vector<std::byte> NpyEncoder::header() const {
  std::string type =
      fmt::format("[('position', '{}', (3,)), ('normal', '<f4', (3,)), ('value', '<f8')",
                  has_doubles_ ? "<f8" : "<f4");
  for (const std::string& name : fields_) type += fmt::format(", ('{}', '<f4')", name);
  const std::string text = npy_header(type + "]", fmt::format("({},)", points_), header_bytes());
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Result<void> NpyEncoder::append(const MeshPart& part, EncodedPart& out) {
  const PointsWithFields& points = part.vertices;
  for (size_t i = 0; i < points.positions.size(); ++i) {
    append_position(points.positions[i], has_doubles_, out.body);
    append_bytes(points.normals[i], out.body);
    append_bytes(isovalue_, out.body);
    for (const auto& values : points.fields) append_bytes(values[i], out.body);
  }
  points_ += points.positions.size();
  return {};
}

}  // namespace isosplat
