#include "shared/core/builder/quantized_reader.h"

#include <algorithm>

#include "shared/core/builder/executor.h"

namespace isosplat {
namespace {

size_t voxels_per_slice(const VolumeHeader& header) {
  return static_cast<size_t>(header.grid.voxels.x) * static_cast<size_t>(header.grid.voxels.y);
}

}  // namespace

uint64_t staging_bytes(const VolumeHeader& header, uint8_t bits) {
  if (voxel_bytes(header.type) * 8 == bits) return 0;
  const uint64_t slice = uint64_t{static_cast<uint32_t>(header.grid.voxels.x)} *
                         static_cast<uint32_t>(header.grid.voxels.y) * voxel_bytes(header.type);
  // At most half of the slices of a layer: if voxels of 16 bits become quantized values of 8 bits,
  // the buffer takes no more memory than the smaller layer saves. So the memory plan stays valid,
  // although it is made before the number of bits is known.
  const auto max_slices =
      static_cast<uint64_t>(std::clamp(header.grid.voxels.z / 2, 1, kBlockCells / 2));
  return slice * std::clamp<uint64_t>((8 << 20) / slice, 1, max_slices);
}

QuantizedReader::QuantizedReader(VolumeSource& source, const Quantization& quantization,
                                 Executor& executor)
    : source_(source),
      quantization_(quantization),
      executor_(executor),
      voxels_per_slice_(voxels_per_slice(source.header())),
      staging_(static_cast<size_t>(staging_bytes(source.header(), quantization.mapping().bits))) {}

Result<void> QuantizedReader::read(int32_t first, int32_t count, std::byte* to,
                                   const Visit& visit) {
  const VoxelType type = source_.header().type;
  const size_t slice = voxels_per_slice_ * voxel_bytes(type);
  const bool in_place = staging_.empty();
  const int32_t batch_slices = in_place ? count : static_cast<int32_t>(staging_.size() / slice);
  for (int32_t z = 0; z < count; z += batch_slices) {
    const int32_t batch = std::min(batch_slices, count - z);
    std::byte* quantized_values = to + slice_bytes() * static_cast<size_t>(z);
    const std::span<std::byte> raw{in_place ? quantized_values : staging_.data(),
                                   slice * static_cast<size_t>(batch)};
    if (auto read = source_.read_slices(first + z, batch, raw); !read) return read;
    executor_.run(static_cast<size_t>(batch), [&](unsigned thread, size_t i) {
      std::byte* out = quantized_values + slice_bytes() * i;
      quantization_.encode(raw.subspan(slice * i, slice), out);
      visit(thread, out, voxels_per_slice_);
    });
  }
  return {};
}

}  // namespace isosplat
