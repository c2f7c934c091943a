#pragma once

#include <span>
#include <string>

#include "shared/core/mesh_files/mesh_encoder.h"

namespace isosplat {

/// A binary glTF 2.0 file: interleaved positions and normals in single precision, and triangles.
///
/// glTF uses metres, y up and z towards the viewer. The volume is assumed to use millimetres, in
/// LPS orientation (z up, y to the back). A node of the file converts them. Each object is a node
/// below it, with its name, and a material of its colour. Positions are relative to the middle of
/// the object's volume if single precision would otherwise not do (needs_doubles); its node holds
/// the offset. Objects without triangles are left out.
class GlbEncoder : public MeshEncoder {
 public:
  /// A file of one surface, without a name. `comment`: for asset.generator.
  GlbEncoder(const VolumeGrid& grid, std::string_view comment);
  /// A file of these objects, in order: at least one.
  GlbEncoder(std::span<const MeshObject> objects, std::string_view comment);

  /// Errors: invalid_argument (the file would exceed 4 GiB, the most that GLB holds).
  Result<void> append(const MeshPart& part, EncodedPart& out) override;
  void next_object() override { ++open_; }
  size_t header_bytes() const override;
  std::vector<std::byte> header() const override;

 private:
  struct Object {
    std::string name;
    std::array<float, 4> colour{};  ///< linear, with the opacity
    Vec3d offset;                   ///< of the positions in the file
    uint64_t vertices = 0, triangles = 0;
    Vec3f low, high;  ///< the box around the positions in the file
  };

  std::string scene() const;

  std::vector<Object> objects_;
  size_t open_ = 0;  ///< index of the object whose parts are appended
  std::string comment_;
  size_t json_bytes_ = 0;
  uint64_t vertices_ = 0, triangles_ = 0;  ///< of all objects
};

}  // namespace isosplat
