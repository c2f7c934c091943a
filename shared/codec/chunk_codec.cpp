#include "shared/codec/chunk_codec.h"

#include <algorithm>

namespace isosplat {
namespace {

size_t cell_total(Index3 c) {
  return size_t(c.x) * size_t(c.y) * size_t(c.z);
}
size_t voxel_total(Index3 c) {
  return cell_total({c.x + 1, c.y + 1, c.z + 1});
}

/// Calls f(cell place, index of corner 0 in the voxel lattice) for every set bit.
template <class F>
void for_each_cell(Index3 c, const std::vector<uint8_t>& mask, F f) {
  size_t i = 0;
  for (int32_t z = 0; z < c.z; ++z) {
    for (int32_t y = 0; y < c.y; ++y) {
      for (int32_t x = 0; x < c.x; ++x, ++i) {
        if (mask[i]) {
          f(uint32_t(x | y << 6 | z << 12), (size_t(z) * (c.y + 1) + y) * (c.x + 1) + x, i);
        }
      }
    }
  }
}

size_t corner_index(Index3 c, size_t base, int corner) {
  return base + (corner & 1) + (corner >> 1 & 1) * size_t(c.x + 1) +
         (corner >> 2 & 1) * size_t(c.x + 1) * size_t(c.y + 1);
}

}  // namespace

struct ChunkEncoder::Scratch {
  std::vector<uint8_t> mask, needed;
};
struct ChunkDecoder::Scratch {
  std::vector<uint8_t> mask, needed;
  std::vector<Code> voxels;
  DecodedCells cells;
};

ChunkEncoder::ChunkEncoder() : scratch_(std::make_unique<Scratch>()) {}
ChunkEncoder::ChunkEncoder(ChunkEncoder&&) noexcept = default;
ChunkEncoder& ChunkEncoder::operator=(ChunkEncoder&&) noexcept = default;
ChunkEncoder::~ChunkEncoder() = default;
ChunkDecoder::ChunkDecoder() : scratch_(std::make_unique<Scratch>()) {}
ChunkDecoder::ChunkDecoder(ChunkDecoder&&) noexcept = default;
ChunkDecoder& ChunkDecoder::operator=(ChunkDecoder&&) noexcept = default;
ChunkDecoder::~ChunkDecoder() = default;

uint32_t ChunkEncoder::encode(const BlockView& block, uint32_t slab_begin, uint32_t slab_end,
                              std::vector<std::byte>& out) {
  const Index3 c = block.cells;
  auto& mask = scratch_->mask;
  auto& needed = scratch_->needed;
  mask.assign(cell_total(c), 0);
  needed.assign(voxel_total(c), 0);
  uint32_t count = 0;
  for (size_t i = 0; i < mask.size(); ++i) {
    const CellInterval interval = block.intervals[i];
    mask[i] =
        std::max<uint32_t>(interval.min, slab_begin) < std::min<uint32_t>(interval.max, slab_end);
    count += mask[i];
  }
  if (!count) return 0;
  for_each_cell(c, mask, [&](uint32_t, size_t base, size_t) {
    for (int k = 0; k < 8; ++k) needed[corner_index(c, base, k)] = 1;
  });
  const auto put = [&](uint32_t value) { out.push_back(std::byte(value)); };
  for (size_t i = 0; i < mask.size(); i += 8) {
    uint32_t byte = 0;
    for (size_t k = 0; k < 8 && i + k < mask.size(); ++k) byte |= uint32_t(mask[i + k]) << k;
    put(byte);
  }
  const auto put_code = [&](Code value) { put(value & 255), put(value >> 8); };
  for (size_t i = 0; i < needed.size(); ++i) {
    if (needed[i]) put_code(block.voxels[i]);
  }
  if (block.has_intervals) {
    for_each_cell(c, mask, [&](uint32_t, size_t, size_t i) {
      put_code(block.intervals[i].min), put_code(block.intervals[i].max);
    });
  }
  return count;
}

Result<void> ChunkDecoder::decode(std::span<const std::byte> bytes, const ChunkShape& shape,
                                  DecodedCells& out) {
  const Index3 c = shape.block_cells;
  if (std::min({c.x, c.y, c.z}) < 1 || std::max({c.x, c.y, c.z}) > kBlockCells ||
      shape.cell_count < 1 || shape.cell_count > cell_total(c)) {
    return fail(Status::invalid_argument, "chunk: impossible block size or cell count");
  }
  const auto truncated = [] { return fail(Status::truncated, "chunk: the bytes end too early"); };
  auto& mask = scratch_->mask;
  auto& needed = scratch_->needed;
  auto& voxels = scratch_->voxels;
  mask.assign(cell_total(c), 0);
  needed.assign(voxel_total(c), 0);
  voxels.assign(voxel_total(c), 0);
  size_t at = 0;
  if (bytes.size() < (mask.size() + 7) / 8) return truncated();
  uint32_t count = 0;
  for (size_t i = 0; i < mask.size(); ++i) {
    mask[i] = uint8_t(uint32_t(bytes[i / 8]) >> (i & 7) & 1);
    count += mask[i];
  }
  at = (mask.size() + 7) / 8;
  if (count != shape.cell_count) {
    return fail(Status::malformed_chunk, "chunk: holds another number of cells than stated");
  }
  for_each_cell(c, mask, [&](uint32_t, size_t base, size_t) {
    for (int k = 0; k < 8; ++k) needed[corner_index(c, base, k)] = 1;
  });
  const auto code = [&] {
    const auto value = Code(uint32_t(bytes[at]) | uint32_t(bytes[at + 1]) << 8);
    at += 2;
    return value;
  };
  for (size_t i = 0; i < needed.size(); ++i) {
    if (!needed[i]) continue;
    if (bytes.size() - at < 2) return truncated();
    voxels[i] = code();
  }
  if (shape.has_intervals && bytes.size() - at < size_t(count) * 4) return truncated();
  out.cell.clear(), out.corners.clear(), out.interval.clear();
  for_each_cell(c, mask, [&](uint32_t place, size_t base, size_t) {
    CellCorners corners;
    for (int k = 0; k < 8; ++k) corners[k] = voxels[corner_index(c, base, k)];
    CellInterval interval = corner_interval(corners);
    if (shape.has_intervals) {
      interval.min = code();
      interval.max = code();
    }
    out.cell.push_back(place), out.corners.push_back(corners), out.interval.push_back(interval);
  });
  if (at != bytes.size()) return fail(Status::malformed_chunk, "chunk: bytes are left over");
  return {};
}

Result<void> ChunkDecoder::decode_packed(std::span<const std::byte> bytes, const ChunkShape& shape,
                                         std::vector<PackedSample>& out) {
  DecodedCells& cells = scratch_->cells;
  if (auto done = decode(bytes, shape, cells); !done) return done;
  out.clear();
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    const uint32_t p = cells.cell[i];
    out.push_back(pack_sample({int32_t(p & 63), int32_t(p >> 6 & 63), int32_t(p >> 12)},
                              cells.interval[i], cells.corners[i]));
  }
  return {};
}

}  // namespace isosplat
