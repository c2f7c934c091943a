#include "native/labels/looks_like_labels.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>
#include <vector>

#include "shared/core/preprocess/voxel_scan.h"

namespace isosplat {
namespace {

/// From the second quarter of the volume: compressed files need not be read to their end.
constexpr int32_t kSlices = 6;
constexpr size_t kMaxValues = 1024;
constexpr uint64_t kMinVoxels = 100;  // that do not have the most frequent value
constexpr double kMinEqual = 0.8;

struct Value {
  uint64_t voxels = 0;
  uint64_t like_left = 0;  ///< of these, equal to the previous voxel of the row
};

}  // namespace

Result<bool> looks_like_labels(VolumeSource& source) {
  const VolumeHeader& header = source.header();
  if (!is_integer(header.type)) return false;
  const Index3 n = header.grid.voxels;
  const int32_t max_rows = rows_per_read(source, 8 << 20);
  std::vector<std::byte> rows;
  std::unordered_map<uint64_t, Value> values;
  for (int32_t i = 0; i < kSlices; ++i) {
    const auto z = static_cast<int32_t>(n.z / 4 + int64_t{n.z / 4} * i / kSlices);
    for (int32_t first = 0; first < n.y; first += max_rows) {
      const SliceRows part{z, 1, first, std::min(max_rows, n.y - first)};
      rows.resize(part.voxels(n.x) * voxel_bytes(header.type));
      if (auto read = source.read_rows(part, rows); !read) return tl::unexpected(read.error());
      const bool are_few = with_voxel_type(header.type, [&]<class T>(T) {
        const std::byte* from = rows.data();
        for (int32_t y = 0; y < part.rows; ++y) {
          T left{};
          Value* at = nullptr;
          for (int32_t x = 0; x < n.x; ++x, from += sizeof(T)) {
            T voxel;
            std::memcpy(&voxel, from, sizeof voxel);
            if (at && voxel == left) {
              ++at->like_left;
            } else {
              at = &values[static_cast<uint64_t>(static_cast<int64_t>(voxel))];
              if (values.size() > kMaxValues) return false;
            }
            ++at->voxels;
            left = voxel;
          }
        }
        return true;
      });
      if (!are_few) return false;
    }
  }
  uint64_t voxels = 0, like_left = 0, most = 0, most_like_left = 0;
  for (const auto& [ignored, value] : values) {
    voxels += value.voxels;
    like_left += value.like_left;
    if (value.voxels <= most) continue;
    most = value.voxels;
    most_like_left = value.like_left;
  }
  const uint64_t others = voxels - most;
  return others >= kMinVoxels &&
         static_cast<double>(like_left - most_like_left) >= kMinEqual * static_cast<double>(others);
}

}  // namespace isosplat
