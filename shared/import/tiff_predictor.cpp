#include "shared/import/tiff_predictor.h"

#include <bit>
#include <cstring>
#include <vector>

namespace isosplat {
namespace {

template <class Word>
void add_left(std::span<std::byte> row) {
  Word sum = 0;
  for (size_t i = 0; i + sizeof(Word) <= row.size(); i += sizeof(Word)) {
    Word word;
    std::memcpy(&word, row.data() + i, sizeof word);
    sum = static_cast<Word>(sum + word);
    std::memcpy(row.data() + i, &sum, sizeof sum);
  }
}

void add_left(size_t voxel, std::span<std::byte> row) {
  if (voxel == 1) return add_left<uint8_t>(row);
  if (voxel == 2) return add_left<uint16_t>(row);
  if (voxel == 4) return add_left<uint32_t>(row);
  return add_left<uint64_t>(row);
}

/// A row has the highest bytes of all voxels, then the next lower ones, and so on, in files of both
/// byte orders.
void join_bytes(size_t voxel, std::span<std::byte> row, std::vector<std::byte>& copy) {
  copy.assign(row.begin(), row.end());
  const size_t count = row.size() / voxel;
  for (size_t byte = 0; byte < voxel; ++byte) {
    const size_t to = std::endian::native == std::endian::little ? voxel - 1 - byte : byte;
    for (size_t i = 0; i < count; ++i) row[i * voxel + to] = copy[byte * count + i];
  }
}

}  // namespace

bool knows_predictor(uint64_t predictor, VoxelType type) {
  return predictor == 1 || predictor == 2 ||
         (predictor == 3 && (type == VoxelType::f32 || type == VoxelType::f64));
}

void undo_predictor(uint64_t predictor, const StoredVoxels& voxels, size_t row_bytes,
                    std::span<std::byte> rows) {
  const size_t voxel = voxel_bytes(voxels.type);
  if (predictor != 3) to_native_order(voxels, rows);
  if (predictor == 1) return;
  std::vector<std::byte> copy;
  for (size_t at = 0; at + row_bytes <= rows.size(); at += row_bytes) {
    const auto row = rows.subspan(at, row_bytes);
    add_left(predictor == 2 ? voxel : 1, row);
    if (predictor == 3) join_bytes(voxel, row, copy);
  }
}

}  // namespace isosplat
