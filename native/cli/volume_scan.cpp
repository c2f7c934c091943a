#include "native/cli/volume_scan.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace isosplat::cli {
namespace {

/// Calls visit(value) for each voxel.
template <class T, class Visit>
Result<void> for_each_voxel(VolumeSource& source, const Visit& visit) {
  const Index3 n = source.header().grid.voxels;
  const size_t slice = static_cast<size_t>(n.x) * static_cast<size_t>(n.y) * sizeof(T);
  const auto at_a_time =
      static_cast<int32_t>(std::clamp<size_t>((size_t{8} << 20) / slice, 1, 256));
  std::vector<std::byte> bytes;
  for (int32_t z = 0; z < n.z; z += at_a_time) {
    const int32_t count = std::min(at_a_time, n.z - z);
    bytes.resize(slice * static_cast<size_t>(count));
    if (auto read = source.read_slices(z, count, bytes); !read) return read;
    for (size_t i = 0; i < bytes.size(); i += sizeof(T)) {
      T value;
      std::memcpy(&value, bytes.data() + i, sizeof(T));
      visit(static_cast<double>(value));
    }
  }
  return {};
}

template <class T>
Result<VolumeScan> scan(VolumeSource& source) {
  VolumeScan result;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  auto read = for_each_voxel<T>(source, [&](double value) {
    if (!std::isfinite(value)) {
      ++result.non_finite;
      return;
    }
    low = std::min(low, value);
    high = std::max(high, value);
  });
  if (!read) return tl::unexpected(read.error());
  if (low > high) return result;  // not one finite value
  result.low = low;
  result.high = high;
  result.histogram.assign(256, 0);
  const double scale = high > low ? 256 / (high - low) : 0;
  read = for_each_voxel<T>(source, [&](double value) {
    if (!std::isfinite(value)) return;
    ++result.histogram[std::min<size_t>(255, static_cast<size_t>((value - low) * scale))];
  });
  if (!read) return tl::unexpected(read.error());
  return result;
}

}  // namespace

Result<VolumeScan> scan_volume(VolumeSource& source) {
  switch (source.header().type) {
    case VoxelType::u8:
      return scan<uint8_t>(source);
    case VoxelType::i8:
      return scan<int8_t>(source);
    case VoxelType::u16:
      return scan<uint16_t>(source);
    case VoxelType::i16:
      return scan<int16_t>(source);
    case VoxelType::u32:
      return scan<uint32_t>(source);
    case VoxelType::i32:
      return scan<int32_t>(source);
    case VoxelType::f32:
      return scan<float>(source);
    case VoxelType::f64:
      return scan<double>(source);
  }
  return fail(Status::unsupported_type, "unknown voxel type");
}

}  // namespace isosplat::cli
