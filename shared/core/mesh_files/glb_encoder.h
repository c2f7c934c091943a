#pragma once

#include <string>

#include "shared/core/mesh_files/mesh_encoder.h"

namespace isosplat {

/// A binary glTF 2.0 file: interleaved positions and normals in single precision, and triangles.
///
/// glTF uses metres, y up and z towards the viewer. The volume is assumed to use millimetres, in
/// LPS orientation (z up, y to the back). A node of the file converts them. Positions are relative
/// to the middle of the volume if single precision would otherwise not do (needs_doubles); a second
/// node holds the offset.
class GlbEncoder : public MeshEncoder {
 public:
  /// `comment`: for asset.generator.
  GlbEncoder(const VolumeGrid& grid, std::string_view comment);

  /// Errors: invalid_argument (the file would exceed 4 GiB, the most that GLB holds).
  Result<void> append(const MeshPart& part, EncodedPart& out) override;
  size_t header_bytes() const override;
  std::vector<std::byte> header() const override;

 private:
  std::string scene() const;

  Vec3d offset_;  ///< of the positions in the file
  std::string comment_;
  uint64_t vertices_ = 0, triangles_ = 0;
  Vec3f low_{}, high_{};  ///< the box around the positions in the file
};

}  // namespace isosplat
