#include "shared/core/unstructured/near_faces.h"

#include "shared/core/unstructured/box_triangle.h"
#include "shared/core/unstructured/opposite_planes.h"

namespace isosplat {
namespace {

/// As a share of a box: boxes that are farther apart do not overlap, whatever the rounding.
constexpr double kRounding = 1e-6;

}  // namespace

Box gap_box(const Box& box) {
  const Vec3d around = (box.high - box.low) * kGapMargin;
  return {box.low - around, box.high + around};
}

void NearFaces::assign(const std::vector<BoundaryFace>& faces, std::span<const uint32_t> chosen) {
  faces_.resize(chosen.size());
  for (size_t i = 0; i < chosen.size(); ++i) {
    const BoundaryFace& face = faces[chosen[i]];
    faces_[i] = {face, corners_of(mesh_, face), box_of(mesh_, face)};
  }
}

bool NearFaces::crosses(uint32_t number, const Box& box) const {
  const Face& face = faces_[number];
  const Vec3d margin = (box.high - box.low) * kRounding;
  if (!face.box.overlaps({box.low - margin, box.high + margin})) return false;
  const auto& p = face.corners.at;
  if (overlap(box, {p[0], p[1], p[2]})) return true;
  return face.corners.count == 4 &&
         (overlap(box, {p[0], p[2], p[3]}) || overlap(box, {p[0], p[1], p[3]}) ||
          overlap(box, {p[1], p[2], p[3]}));
}

bool NearFaces::have_gap(std::span<const uint32_t> numbers, const Box& box) const {
  const Box wide = gap_box(box);
  const Vec3d centre = (wide.low + wide.high) * 0.5;
  std::vector<FacePlane> planes;
  for (const uint32_t number : numbers) {
    if (!crosses(number, wide)) continue;
    const Vec3d normal = outward_normal(mesh_, faces_[number].face);
    planes.push_back({normal, dot(centre - faces_[number].corners.at[0], normal)});
  }
  return are_some_opposite(planes);
}

}  // namespace isosplat
