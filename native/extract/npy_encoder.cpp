#include "native/extract/npy_encoder.h"

#include <fmt/format.h>

#include <span>

#include "native/extract/array_bytes.h"
#include "native/extract/npy_header.h"
#include "shared/core/points/position_precision.h"

namespace isosplat {

NpyEncoder::NpyEncoder(const VolumeGrid& grid, double isovalue)
    : has_doubles_(needs_doubles(grid)), isovalue_(isovalue) {}

size_t NpyEncoder::header_bytes() const {
  return kNpyHeaderBytes;
}

std::vector<std::byte> NpyEncoder::header() const {
  const std::string text =
      npy_header(fmt::format("[('position', '{}', (3,)), ('normal', '<f4', (3,)), "
                             "('value', '<f8')]",
                             has_doubles_ ? "<f8" : "<f4"),
                 fmt::format("({},)", points_));
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Result<void> NpyEncoder::append(const MeshPart& part, EncodedPart& out) {
  const PointArrays& points = part.vertices;
  for (size_t i = 0; i < points.positions.size(); ++i) {
    append_position(points.positions[i], has_doubles_, out.body);
    append_bytes(points.normals[i], out.body);
    append_bytes(isovalue_, out.body);
  }
  points_ += points.positions.size();
  return {};
}

}  // namespace isosplat
