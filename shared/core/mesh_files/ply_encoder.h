#pragma once

#include <string>

#include "shared/core/mesh_files/mesh_encoder.h"

namespace isosplat {

/// A binary little-endian PLY file of points with normals, and optionally of triangles. MeshLab,
/// CloudCompare, Open3D and VTK read such files.
///
/// Positions have single precision if its error is at most 1/2000 of a voxel in the whole volume,
/// otherwise double precision: at UTM coordinates the error of single precision is half a metre.
/// Normals always have single precision, and so have the values of fields, which are properties of
/// the fields' names; missing values are NaN.
class PlyEncoder : public MeshEncoder {
 public:
  enum class Content { points, triangles };

  /// `grid`: of the volume that contains the points. `comment`: one line for the header.
  PlyEncoder(const VolumeGrid& grid, std::string_view comment, Content content,
             std::span<const FieldColumn> fields = {});

  /// Never fails. With Content::points, triangles are ignored.
  Result<void> append(const MeshPart& part, EncodedPart& out) override;
  size_t header_bytes() const override { return header().size(); }
  std::vector<std::byte> header() const override;

 private:
  bool has_doubles_;
  Content content_;
  std::string comments_;             ///< lines of the header
  std::vector<std::string> fields_;  ///< names of their properties
  uint64_t points_ = 0, triangles_ = 0;
};

}  // namespace isosplat
