#include "shared/core/builder/quantized_reader.h"

#include <algorithm>

#include "shared/core/builder/executor.h"

namespace isosplat {
namespace {

constexpr uint64_t kStagingBytes = 8 << 20;

}  // namespace

uint64_t staging_bytes(const VolumeHeader& header, uint8_t bits, bool reads_rows) {
  if (voxel_bytes(header.type) * 8 == bits) return 0;
  const uint64_t row =
      uint64_t{static_cast<uint32_t>(header.grid.voxels.x)} * voxel_bytes(header.type);
  const uint64_t slice = row * static_cast<uint32_t>(header.grid.voxels.y);
  // At most half of the slices of a layer: if voxels of 16 bits become quantized values of 8 bits,
  // the buffer takes no more memory than the smaller layer saves. So the memory plan stays valid,
  // although it is made before the number of bits is known.
  const auto max_slices =
      static_cast<uint64_t>(std::clamp(header.grid.voxels.z / 2, 1, kBlockCells / 2));
  if (slice > kStagingBytes && reads_rows) return std::max(row, kStagingBytes / row * row);
  return slice * std::clamp<uint64_t>(kStagingBytes / slice, 1, max_slices);
}

QuantizedReader::QuantizedReader(VolumeSource& source, const Quantization& quantization,
                                 Executor& executor)
    : source_(source),
      quantization_(quantization),
      executor_(executor),
      n_(source.header().grid.voxels),
      staging_(static_cast<size_t>(
          staging_bytes(source.header(), quantization.mapping().bits, source.reads_rows()))) {}

Result<void> QuantizedReader::read(const SliceRows& part, std::byte* to, const Visit& visit) {
  if (staging_.empty()) return read_piece(part, to, visit);
  const size_t row = static_cast<size_t>(n_.x) * voxel_bytes(source_.header().type);
  const auto max_rows = static_cast<int32_t>(staging_.size() / row);
  const int32_t max_slices = std::max(1, max_rows / part.rows);
  for (int32_t z = 0; z < part.slices; z += max_slices) {
    const int32_t slices = std::min(max_slices, part.slices - z);
    for (int32_t y = 0; y < part.rows; y += max_rows) {
      const SliceRows piece{part.first_slice + z, slices, part.first_row + y,
                            std::min(max_rows, part.rows - y)};
      const size_t rows_before =
          static_cast<size_t>(z) * static_cast<size_t>(part.rows) + static_cast<size_t>(y);
      if (auto read = read_piece(piece, to + row_bytes() * rows_before, visit); !read) return read;
    }
  }
  return {};
}

Result<void> QuantizedReader::read_piece(const SliceRows& part, std::byte* to, const Visit& visit) {
  const size_t voxels = SliceRows{0, 1, 0, part.rows}.voxels(n_.x);
  const size_t raw_bytes = voxels * voxel_bytes(source_.header().type);
  const size_t bytes = row_bytes() * static_cast<size_t>(part.rows);
  const std::span<std::byte> raw{staging_.empty() ? to : staging_.data(),
                                 raw_bytes * static_cast<size_t>(part.slices)};
  if (auto read = source_.read_rows(part, raw); !read) return read;
  executor_.run(static_cast<size_t>(part.slices), [&](unsigned thread, size_t i) {
    std::byte* const out = to + bytes * i;
    quantization_.encode(raw.subspan(raw_bytes * i, raw_bytes), out);
    visit(thread, {part.first_slice + static_cast<int32_t>(i), 1, part.first_row, part.rows}, out);
  });
  return {};
}

}  // namespace isosplat
