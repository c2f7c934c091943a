#include "tests/conformance/compare.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace isosplat::conformance {

Result<std::vector<double>> read_values(VolumeSource& source) {
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const size_t count =
      static_cast<size_t>(n.x) * static_cast<size_t>(n.y) * static_cast<size_t>(n.z);
  const size_t bytes = voxel_bytes(header.type), slice = count / static_cast<size_t>(n.z) * bytes;
  std::vector<std::byte> voxels(count * bytes);
  for (int32_t z = 0; z < n.z; ++z) {
    auto read = source.read_slices(z, 1, std::span(voxels).subspan(z * slice, slice));
    if (!read) return tl::unexpected(read.error());
  }
  std::vector<double> values;
  with_voxel_type(header.type, [&]<class T>(T) {
    for (size_t i = 0; i < count; ++i) {
      T voxel;
      std::memcpy(&voxel, voxels.data() + i * sizeof(T), sizeof(T));
      values.push_back(header.value(static_cast<double>(voxel)));
    }
  });
  return values;
}

std::string difference(const VolumeGrid& grid, const std::vector<double>& values,
                       const Truth& truth, bool may_be_incomplete) {
  // If voxels may be missing, whole slices at the end may be missing too.
  if (may_be_incomplete ? values.size() > truth.values.size()
                        : values.size() != truth.values.size()) {
    return "expected " + std::to_string(truth.values.size()) + " voxels, found " +
           std::to_string(values.size());
  }
  const auto& s = truth.steps;
  const double volume = dot(s[0], cross(s[1], s[2]));
  const Vec3d rows[] = {cross(s[1], s[2]) * (1 / volume), cross(s[2], s[0]) * (1 / volume),
                        cross(s[0], s[1]) * (1 / volume)};
  // Interpolated values are rounded with their neighbours, which may be larger.
  double scale = 1;
  for (const double value : truth.values) {
    if (may_be_incomplete) scale = std::max(scale, std::abs(value));
  }
  std::vector<bool> seen(truth.values.size());
  size_t n = 0;
  for (int z = 0; z < grid.voxels.z; ++z) {
    for (int y = 0; y < grid.voxels.y; ++y) {
      for (int x = 0; x < grid.voxels.x; ++x, ++n) {
        const Vec3d place = grid.world({double(x), double(y), double(z)}) - truth.origin;
        int index[3];
        for (int axis = 0; axis < 3; ++axis) {
          const double i = dot(rows[axis], place);
          index[axis] = static_cast<int>(std::lround(i));
          if (std::abs(i - index[axis]) > 1e-3 || index[axis] < 0 ||
              index[axis] >= truth.sizes[axis]) {
            return "voxel " + std::to_string(n) + " lies at " + std::to_string(i) + " of axis " +
                   std::to_string(axis);
          }
        }
        const auto at =
            static_cast<size_t>((index[2] * truth.sizes[1] + index[1]) * truth.sizes[0] + index[0]);
        if (seen[at]) return "two voxels have the same position";
        seen[at] = true;
        const double expected = truth.values[at];
        if (std::abs(values[n] - expected) <= 1e-6 * std::max(scale, std::abs(expected))) continue;
        if (std::isnan(values[n]) && (may_be_incomplete || std::isnan(expected))) continue;
        return "voxel " + std::to_string(n) + " has the value " + std::to_string(values[n]) +
               ", expected " + std::to_string(expected);
      }
    }
  }
  return {};
}

}  // namespace isosplat::conformance
