#pragma once

#include "shared/core/mesh_files/mesh_encoder.h"

namespace isosplat {

/// Points as one structured NumPy array (.npy) of shape (points,), with the fields
///   position  3 × f4, or 3 × f8 where single precision is too coarse (position_precision.h): world
///   normal    3 × f4: of unit length, towards smaller values
///   value     f8: the isovalue of the surface that the point is on
/// and f4 with the name of each field; missing values are NaN.
/// Triangles are ignored.
class NpyEncoder : public MeshEncoder {
 public:
  NpyEncoder(const VolumeGrid& grid, double isovalue, std::span<const FieldColumn> fields = {});

  /// Never fails.
  Result<void> append(const MeshPart& part, EncodedPart& out) override;
  size_t header_bytes() const override;
  std::vector<std::byte> header() const override;

 private:
  bool has_doubles_;
  double isovalue_;
  std::vector<std::string> fields_;  ///< names of their columns
  uint64_t points_ = 0;
};

}  // namespace isosplat
