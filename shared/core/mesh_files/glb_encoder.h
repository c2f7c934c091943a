#pragma once

#include <span>
#include <string>

#include "shared/core/mesh_files/mesh_encoder.h"

namespace isosplat {

/// The fields of a GLB file, and the sRGB colours from low to high values: borrowed, at least 2.
struct GlbFields {
  std::span<const FieldColumn> columns = {};
  std::span<const std::array<uint8_t, 3>> colour_map = {};
};

/// A binary glTF 2.0 file: interleaved positions and normals in single precision, and triangles.
///
/// glTF uses metres, y up and z towards the viewer. The volume is assumed to use millimetres, in
/// LPS orientation (z up, y to the back). A node of the file converts them. Each object is a node
/// below it, with its name, and a material of its colour. Positions are relative to the middle of
/// the object's volume if single precision would otherwise not do (needs_doubles); its node holds
/// the offset. Objects without triangles are left out.
///
/// Fields are attributes of single precision: _PRESSURE for "pressure". The vertices of an object
/// also have colours (COLOR_0) for the values of the first field: from the 1st to the 99th
/// percentile of the file's values, grey where the value is missing. glTF has no NaN: a missing
/// value is the lowest number of single precision. The property "extras" of a mesh lists its
/// fields. Objects without any value of a field have no such attribute. Values are in memory until
/// finish(), 4 bytes for each vertex and field.
class GlbEncoder : public MeshEncoder {
 public:
  /// A file of one surface, without a name. `comment`: for asset.generator.
  GlbEncoder(const VolumeGrid& grid, std::string_view comment, const GlbFields& fields = {});
  /// A file of these objects, in order: at least one.
  GlbEncoder(std::span<const MeshObject> objects, std::string_view comment,
             const GlbFields& fields = {});

  /// Errors: invalid_argument (the file would exceed 4 GiB, the most that GLB holds).
  Result<void> append(const MeshPart& part, EncodedPart& out) override;
  void next_object() override { ++open_; }
  void finish(std::vector<std::byte>& out) override;
  size_t header_bytes() const override;
  std::vector<std::byte> header() const override;

 private:
  struct Object {
    std::string name;
    std::array<float, 4> colour{};  ///< linear, with the opacity
    Vec3d offset;                   ///< of the positions in the file
    uint64_t vertices = 0, triangles = 0;
    Vec3f low, high;     ///< the box around the positions in the file
    FieldValues values;  ///< of each field; empty after finish() if the object has none
  };

  std::string scene() const;
  void reserve_text(const GlbFields& fields);
  uint64_t value_bytes() const;
  uint64_t colour_bytes() const;

  std::vector<Object> objects_;
  size_t open_ = 0;  ///< index of the object whose parts are appended
  std::string comment_;
  std::vector<FieldColumn> fields_;
  std::vector<std::string> attributes_;  ///< names of the fields' attributes
  std::span<const std::array<uint8_t, 3>> colour_map_;
  std::array<float, 2> coloured_{};  ///< values of the first and the last colour
  size_t json_bytes_ = 0;
  uint64_t vertices_ = 0, triangles_ = 0;  ///< of all objects
};

}  // namespace isosplat
