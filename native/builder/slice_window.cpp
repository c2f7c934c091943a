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

Result<void> SliceWindow::move_to(Slices slices) {
  if (slices.first >= held_.first && slices.end <= held_.end) return {};
  const size_t slice = slice_voxels();
  const Slices kept{std::max(slices.first, held_.first), std::min(slices.end, held_.end)};
  std::vector<double> values(slice * static_cast<size_t>(slices.count()));
  const auto place = [&](int32_t z) {
    return values.data() + slice * static_cast<size_t>(z - slices.first);
  };
  if (kept.count() <= 0) {
    if (auto done = read(slices, values.data()); !done) return done;
  } else {
    std::copy_n(values_.data() + slice * static_cast<size_t>(kept.first - held_.first),
                slice * static_cast<size_t>(kept.count()), place(kept.first));
    if (auto done = read({slices.first, kept.first}, values.data()); !done) return done;
    if (auto done = read({kept.end, slices.end}, place(kept.end)); !done) return done;
  }
  values_ = std::move(values);
  held_ = slices;
  return {};
}

Result<void> SliceWindow::read(Slices slices, double* values) {
  const VolumeHeader& header = volume_.header();
  voxels_.resize(slice_voxels() * voxel_bytes(header.type));
  for (int32_t z = slices.first; z < slices.end; ++z, values += slice_voxels()) {
    if (auto done = volume_.read_slices(z, 1, voxels_); !done) return done;
    with_voxel_type(header.type, [&]<class T>(T) {
      const auto* voxels = reinterpret_cast<const T*>(voxels_.data());
      std::transform(voxels, voxels + slice_voxels(), values, [&](T voxel) {
        if constexpr (std::is_floating_point_v<T>) {
          if (!has_value(voxel)) return std::numeric_limits<double>::quiet_NaN();
        }
        return header.value(static_cast<double>(voxel));
      });
    });
  }
  return {};
}

}  // namespace isosplat
