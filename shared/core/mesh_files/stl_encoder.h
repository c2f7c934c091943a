#pragma once

#include <string>

#include "shared/core/mesh_files/mesh_encoder.h"

namespace isosplat {

/// A binary STL file: triangles without shared vertices, in single precision. Keeps the positions
/// of all vertices in memory, 12 bytes each, since later parts of a mesh refer to them.
class StlEncoder : public MeshEncoder {
 public:
  /// `comment`: at most 80 bytes are kept.
  explicit StlEncoder(std::string_view comment) : comment_(comment) {}

  /// Errors: invalid_argument (more than 2³² − 1 triangles).
  Result<void> append(const MeshPart& part, EncodedPart& out) override;
  size_t header_bytes() const override;
  std::vector<std::byte> header() const override;

 private:
  std::string comment_;
  std::vector<Vec3f> positions_;
  uint64_t triangles_ = 0;
};

}  // namespace isosplat
