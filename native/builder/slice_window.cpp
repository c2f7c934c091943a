#include "native/builder/slice_window.h"

#include <algorithm>
#include <limits>
#include <type_traits>

#include "shared/core/preprocess/voxel_scan.h"

namespace isosplat {

size_t SliceWindow::slice_voxels() const {
  const Index3 n = volume_.header().grid.voxels;
  return static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
}

uint64_t SliceWindow::slice_bytes() const {
  return slice_voxels() * sizeof(float);
}

Result<void> SliceWindow::move_to(int32_t first, int32_t end) {
  if (first >= first_ && end <= end_) return {};
  const size_t slice = slice_voxels();
  const int32_t kept_first = std::max(first, first_), kept_end = std::min(end, end_);
  std::vector<float> values(slice * static_cast<size_t>(end - first));
  const auto place = [&](int32_t z) {
    return values.data() + slice * static_cast<size_t>(z - first);
  };
  if (kept_first >= kept_end) {
    if (auto done = read(first, end, values.data()); !done) return done;
  } else {
    std::copy_n(values_.data() + slice * static_cast<size_t>(kept_first - first_),
                slice * static_cast<size_t>(kept_end - kept_first), place(kept_first));
    if (auto done = read(first, kept_first, values.data()); !done) return done;
    if (auto done = read(kept_end, end, place(kept_end)); !done) return done;
  }
  values_ = std::move(values);
  first_ = first;
  end_ = end;
  return {};
}

Result<void> SliceWindow::read(int32_t first, int32_t end, float* values) {
  const VolumeHeader& header = volume_.header();
  voxels_.resize(slice_voxels() * voxel_bytes(header.type));
  for (int32_t z = first; z < end; ++z, values += slice_voxels()) {
    if (auto done = volume_.read_slices(z, 1, voxels_); !done) return done;
    with_voxel_type(header.type, [&]<class T>(T) {
      const auto* voxels = reinterpret_cast<const T*>(voxels_.data());
      std::transform(voxels, voxels + slice_voxels(), values, [&](T voxel) {
        if constexpr (std::is_floating_point_v<T>) {
          if (!has_value(voxel)) return std::numeric_limits<float>::quiet_NaN();
        }
        return static_cast<float>(header.value(static_cast<double>(voxel)));
      });
    });
  }
  return {};
}

}  // namespace isosplat
