#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/preprocess/label_field.h"

namespace isosplat::test {

/// The field, computed in slabs of `slab` slices.
inline std::vector<std::uint8_t> field_of(const std::vector<std::uint16_t>& labels, Index3 size,
                                          std::uint16_t label, const LabelBox& box,
                                          std::int32_t slab = 5) {
  LabelField field({labels, size}, label, box);
  const auto slice = static_cast<std::size_t>(box.size.x) * static_cast<std::size_t>(box.size.y);
  std::vector<std::uint8_t> values(slice * static_cast<std::size_t>(box.size.z));
  for (std::int32_t z = 0; z < box.size.z; z += slab) {
    const std::int32_t count = std::min(slab, box.size.z - z);
    field.compute(z, count,
                  std::span(values).subspan(slice * static_cast<std::size_t>(z),
                                            slice * static_cast<std::size_t>(count)));
  }
  return values;
}

/// A volume of labels in a margin of background, so that a box over all of it holds every label.
struct TestLabels {
  std::uint32_t size;
  std::vector<std::uint16_t> labels;

  explicit TestLabels(std::uint32_t edge) : size(edge), labels(std::size_t{edge} * edge * edge) {}

  std::size_t at(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (std::size_t{z} * size + y) * size + x;
  }

  std::vector<std::uint8_t> field(std::uint16_t label) const {
    const auto edge = static_cast<std::int32_t>(size);
    return field_of(labels, {edge, edge, edge}, label, {{0, 0, 0}, {edge, edge, edge}});
  }

  /// Voxels for which is_inside(x, y, z) is true.
  template <class F>
  void add(std::uint16_t label, const F& is_inside) {
    for (std::uint32_t z = 0; z < size; ++z)
      for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x)
          if (is_inside(double{1} * x, double{1} * y, double{1} * z)) labels[at(x, y, z)] = label;
  }

  void add_ellipsoid(std::uint16_t label, Vec3<double> centre, Vec3<double> radii) {
    add(label, [&](double x, double y, double z) {
      const double u = (x - centre.x) / radii.x;
      const double v = (y - centre.y) / radii.y;
      const double w = (z - centre.z) / radii.z;
      return u * u + v * v + w * w <= 1;
    });
  }

  double count(std::uint16_t label) const {
    double voxels = 0;
    for (const std::uint16_t here : labels) voxels += here == label ? 1 : 0;
    return voxels;
  }
};

/// The crossing of the surface on a lattice edge, in voxels from its first end.
inline double crossing(int first, int second) {
  return static_cast<double>(first - kLabelFieldIsovalue) / (first - second);
}

}  // namespace isosplat::test
