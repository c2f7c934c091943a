#include "shared/core/builder/layer_reader.h"

#include <algorithm>

namespace isosplat {

LevelBox layer_voxels(const LevelGrid& grid, int32_t z) {
  const int32_t first_cell = z * kBlockCells;
  const int32_t end_cell = std::min(first_cell + kBlockCells, grid.cells.z);
  const int32_t first = std::max(first_cell - kVoxelsBefore, 0);
  return voxel_slices(grid, first, end_cell + 1 - first);
}

LayerReader::LayerReader(VolumeSource& source, const Quantization& quantization, Executor& executor)
    : grid_(level_grid(source.header().grid.voxels, 0)),
      mapping_(quantization.mapping()),
      reader_(source, quantization, executor),
      values_(executor.threads()) {}

Result<const std::byte*> LayerReader::read(int32_t z, bool counts_values) {
  const size_t slice = reader_.slice_bytes();
  const LevelBox box = layer_voxels(grid_, z);
  const int32_t first = box.first.z, end = box.end().z;
  if (buffer_.empty()) {
    buffer_.resize(
        slice * static_cast<size_t>(std::min(kBlockCells + 1 + kVoxelsBefore, grid_.cells.z + 1)));
  }
  // Layers overlap: the last three slices of the layer before are the first of this one. Their
  // values count for that layer.
  const int32_t counted = z == 0 ? 0 : z * kBlockCells + 1;
  if (z > 0 && buffered_z_ == z - 1) {
    const int32_t before = std::max(first - kBlockCells, 0);
    std::copy_n(buffer_.data() + slice * static_cast<size_t>(first - before),
                slice * static_cast<size_t>(counted - first), buffer_.data());
  } else if (z > 0) {
    if (auto read = read_slices(first, first, counted, false); !read) {
      return tl::unexpected(read.error());
    }
  }
  if (auto read = read_slices(first, counted, end, counts_values); !read) {
    return tl::unexpected(read.error());
  }
  buffered_z_ = z;
  return buffer_.data();
}

Result<void> LayerReader::read_slices(int32_t buffer_first, int32_t first, int32_t end,
                                      bool counts_values) {
  const auto count_values = [&](unsigned thread, const std::byte* quantized_values, size_t voxels) {
    if (!counts_values) return;
    values_[thread].add_values(quantized_values, voxels, mapping_.bits, mapping_.has_missing);
  };
  const auto at = static_cast<size_t>(first - buffer_first);
  return reader_.read(first, end - first, buffer_.data() + reader_.slice_bytes() * at,
                      count_values);
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
