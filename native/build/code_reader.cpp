#include "native/build/code_reader.h"

#include <algorithm>

#include "native/build/parallel.h"

namespace isosplat {
namespace {

size_t voxels_per_slice(const VolumeHeader& header) {
  return static_cast<size_t>(header.grid.voxels.x) * static_cast<size_t>(header.grid.voxels.y);
}

}  // namespace

size_t staging_bytes(const VolumeHeader& header) {
  if (voxel_bytes(header.type) <= 2) return 0;
  const size_t slice = voxels_per_slice(header) * voxel_bytes(header.type);
  return slice * std::clamp<size_t>((8 << 20) / slice, 1, kBlockCells);
}

Result<ValueRange> find_range(VolumeSource& source, unsigned threads,
                              const std::function<void(uint64_t voxels)>& progress) {
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const size_t slice = voxels_per_slice(header) * voxel_bytes(header.type);
  const auto at_once =
      static_cast<int32_t>(std::clamp<size_t>((8 << 20) / slice, 1, static_cast<size_t>(n.z)));
  std::vector<std::byte> voxels(slice * static_cast<size_t>(at_once));
  std::vector<ValueRange> ranges(threads);
  for (int32_t z = 0; z < n.z; z += at_once) {
    const int32_t count = std::min(at_once, n.z - z);
    const auto bytes = std::span(voxels).first(slice * static_cast<size_t>(count));
    if (auto read = source.read_slices(z, count, bytes); !read) {
      return tl::unexpected(read.error());
    }
    // Rows, not slices: a slice may be all that fits at a time.
    const size_t rows = static_cast<size_t>(n.y) * static_cast<size_t>(count);
    const size_t row = slice / static_cast<size_t>(n.y);
    const size_t part = (rows + 4 * threads - 1) / (4 * threads);
    parallel_for(threads, (rows + part - 1) / part, [&](unsigned thread, size_t i) {
      const size_t first = i * part, last = std::min(rows, first + part);
      ranges[thread].include(
          range_of(header.type, bytes.subspan(first * row, (last - first) * row)));
    });
    progress(static_cast<uint64_t>(count) * voxels_per_slice(header));
  }
  ValueRange range;
  for (const ValueRange& part : ranges) range.include(part);
  return range;
}

CodeReader::CodeReader(VolumeSource& source, const ValueMapping& mapping, unsigned threads)
    : source_(source),
      mapping_(mapping),
      threads_(threads),
      voxels_per_slice_(voxels_per_slice(source.header())),
      staging_(staging_bytes(source.header())) {}

Result<void> CodeReader::read(int32_t first, int32_t count, std::byte* to, const Visit& visit) {
  const VoxelType type = source_.header().type;
  const size_t slice = voxels_per_slice_ * voxel_bytes(type);
  const bool in_place = staging_.empty();
  const int32_t at_once = in_place ? count : static_cast<int32_t>(staging_.size() / slice);
  for (int32_t z = 0; z < count; z += at_once) {
    const int32_t batch = std::min(at_once, count - z);
    std::byte* codes = to + slice_bytes() * static_cast<size_t>(z);
    const std::span<std::byte> raw{in_place ? codes : staging_.data(),
                                   slice * static_cast<size_t>(batch)};
    if (auto read = source_.read_slices(first + z, batch, raw); !read) return read;
    parallel_for(threads_, static_cast<size_t>(batch), [&](unsigned thread, size_t i) {
      std::byte* out = codes + slice_bytes() * i;
      encode_values(type, mapping_, raw.subspan(slice * i, slice), out);
      visit(thread, out, voxels_per_slice_);
    });
  }
  return {};
}

}  // namespace isosplat
