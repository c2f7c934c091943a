#include "shared/core/builder/layer_reader.h"

#include <algorithm>

#include "shared/core/builder/slice_store.h"

namespace isosplat {

LevelBox band_voxels(const LevelGrid& grid, int32_t z, BlockRows band) {
  const auto along = [](int32_t block, int32_t end_block, int32_t cells, int32_t& first,
                        int32_t& size) {
    first = std::max(block * kBlockCells - kVoxelsBefore, 0);
    size = std::min(end_block * kBlockCells, cells) + 1 - first;
  };
  LevelBox box{{0, 0, 0}, {grid.cells.x + 1, 0, 0}};
  along(band.first, band.end, grid.cells.y, box.first.y, box.size.y);
  along(z, z + 1, grid.cells.z, box.first.z, box.size.z);
  return box;
}

LayerReader::LayerReader(VolumeSource& source, const Quantization& quantization, Executor& executor)
    : grid_(level_grid(source.header().grid.voxels, 0)),
      mapping_(quantization.mapping()),
      reader_(source, quantization, executor),
      values_(executor.threads()) {}

Result<const std::byte*> LayerReader::read(int32_t z, BlockRows band, BlockRows counted) {
  const LevelBox box = band_voxels(grid_, z, band);
  const size_t slice = reader_.row_bytes() * static_cast<size_t>(box.size.y);
  const auto slices =
      static_cast<size_t>(std::min(kBlockCells + 1 + kVoxelsBefore, grid_.cells.z + 1));
  make_room(buffer_, slice * slices);
  // Layers overlap: the last three slices of the layer before are the first of this one. Their
  // values count for that layer.
  const int32_t own = z == 0 ? 0 : z * kBlockCells + 1;
  const bool is_whole = band.count() == grid_.blocks.y;
  int32_t first = box.first.z;
  if (is_whole && z > 0 && buffered_z_ == z - 1) {
    const int32_t before = std::max(first - kBlockCells, 0);
    std::copy_n(buffer_.data() + slice * static_cast<size_t>(first - before),
                slice * static_cast<size_t>(own - first), buffer_.data());
    first = own;
  }
  // The same along y: a row of blocks counts the voxels that the row before it does not have.
  const int32_t counted_first = counted.first == 0 ? 0 : counted.first * kBlockCells + 1;
  const int32_t counted_end =
      counted.count() > 0 ? std::min(counted.end * kBlockCells, grid_.cells.y) + 1 : 0;
  const auto count = [&](unsigned thread, const SliceRows& part, const std::byte* values) {
    const int32_t from = std::max(part.first_row, counted_first);
    const int32_t end = std::min(part.first_row + part.rows, counted_end);
    if (part.first_slice < own || from >= end) return;
    const size_t skipped = static_cast<size_t>(from - part.first_row);
    values_[thread].add_values(values + reader_.row_bytes() * skipped,
                               SliceRows{0, 1, from, end - from}.voxels(grid_.cells.x + 1),
                               mapping_.bits, mapping_.has_missing);
  };
  buffered_z_ = -1;
  const SliceRows part{first, box.end().z - first, box.first.y, box.size.y};
  std::byte* const to = buffer_.data() + slice * static_cast<size_t>(first - box.first.z);
  if (auto read = reader_.read(part, to, count); !read) return tl::unexpected(read.error());
  if (is_whole) buffered_z_ = z;
  return buffer_.data();
}

void LayerReader::take_values(VolumeStatistics& statistics) {
  for (VolumeStatistics& values : values_) {
    statistics.add(values);
    values = VolumeStatistics();
  }
}

void LayerReader::release() {
  std::vector<std::byte>().swap(buffer_);  // an assignment of {} would keep the memory
  buffered_z_ = -1;
}

}  // namespace isosplat
