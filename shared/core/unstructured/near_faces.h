#pragma once

#include <vector>

#include "shared/core/unstructured/boundary_faces.h"

namespace isosplat {

/// How far around a grid cell gaps of the mesh are searched, in edges.
inline constexpr double kGapMargin = 0.6;

/// A grid cell's box with kGapMargin around it.
Box gap_box(const Box& box);

/// The boundary faces near a grid cell, prepared for many searches.
class NearFaces {
 public:
  explicit NearFaces(const UnstructuredMesh& mesh) : mesh_(mesh) {}

  void assign(const std::vector<BoundaryFace>& faces, std::span<const uint32_t> chosen);

  size_t size() const { return faces_.size(); }

  /// Whether a face crosses a box. A face of four corners need not be plane: it lies between the
  /// triangles of both diagonals.
  bool crosses(uint32_t number, const Box& box) const;

  /// Whether two of some faces in or near a grid cell look at each other over a gap. Its
  /// surroundings are searched too: the border of two grid cells may lie in a gap.
  bool have_gap(std::span<const uint32_t> numbers, const Box& box) const;

  /// The memory that the faces need, in bytes.
  static uint64_t bytes(size_t faces) { return faces * sizeof(Face); }

 private:
  struct Face {
    BoundaryFace face;
    FaceCorners corners;
    Box box;
  };

  const UnstructuredMesh& mesh_;
  std::vector<Face> faces_;
};

}  // namespace isosplat
