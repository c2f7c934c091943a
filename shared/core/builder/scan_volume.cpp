#include "shared/core/builder/scan_volume.h"

#include <algorithm>

#include "shared/core/builder/executor.h"

namespace isosplat {

Result<VoxelScan> scan_volume(VolumeSource& source, Executor& executor, bool scan_all,
                              const std::function<void(uint64_t voxels)>& progress) {
  return scan_slices(source, executor, 0, source.header().grid.voxels.z, scan_all, progress);
}

Result<VoxelScan> scan_slices(VolumeSource& source, Executor& executor, int32_t first, int32_t end,
                              bool scan_all, const std::function<void(uint64_t voxels)>& progress) {
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const size_t row = static_cast<size_t>(n.x) * voxel_bytes(header.type);
  const size_t slice = row * static_cast<size_t>(n.y);
  constexpr size_t kBatchBytes = 8 << 20;
  const auto max_batch =
      static_cast<int32_t>(std::clamp<size_t>(kBatchBytes / slice, 1, static_cast<size_t>(n.z)));
  const int32_t max_rows = rows_per_read(source, kBatchBytes);
  std::vector<std::byte> voxels;
  const unsigned threads = executor.threads();
  std::vector<VoxelScan> scans(threads, VoxelScan(header.type));
  const auto is_settled = [&] {
    return !scan_all && std::any_of(scans.begin(), scans.end(),
                                    [](const VoxelScan& scan) { return scan.is_settled(); });
  };
  const auto scan_part = [&](const SliceRows& part) -> Result<void> {
    voxels.resize(part.voxels(n.x) * voxel_bytes(header.type));
    if (auto read = source.read_rows(part, voxels); !read) return read;
    // Threads share rows, not slices: a batch may be a single slice.
    const size_t rows = voxels.size() / row;
    const size_t share = (rows + 4 * threads - 1) / (4 * threads);
    executor.run((rows + share - 1) / share, [&](unsigned thread, size_t i) {
      const size_t begin = i * share, last = std::min(rows, begin + share);
      scans[thread].add(std::span(voxels).subspan(begin * row, (last - begin) * row));
    });
    progress(part.voxels(n.x));
    return {};
  };
  // Integers of up to 16 bits are nearly always settled after one or two slices.
  int32_t batch_slices = voxel_bytes(header.type) <= 2 ? 1 : max_batch;
  for (int32_t z = first; z < end && !is_settled();
       batch_slices = std::min(2 * batch_slices, max_batch)) {
    const int32_t count = std::min(batch_slices, end - z);
    // A batch of several slices is not divided.
    const int32_t rows = count > 1 ? n.y : max_rows;
    for (int32_t y = 0; y < n.y && !is_settled(); y += rows) {
      auto scanned = scan_part({z, count, y, std::min(rows, n.y - y)});
      if (!scanned) return tl::unexpected(scanned.error());
    }
    z += count;
  }
  for (size_t t = 1; t < scans.size(); ++t) scans[0].add(scans[t]);
  return std::move(scans[0]);
}

}  // namespace isosplat
