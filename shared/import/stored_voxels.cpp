#include "shared/import/stored_voxels.h"

#include <bit>
#include <cstdint>
#include <cstring>

namespace isosplat {
namespace {

uint16_t swapped(uint16_t value) {
  return __builtin_bswap16(value);
}
uint32_t swapped(uint32_t value) {
  return __builtin_bswap32(value);
}
uint64_t swapped(uint64_t value) {
  return __builtin_bswap64(value);
}

template <class Word>
void swap_each(std::span<std::byte> bytes) {
  for (size_t i = 0; i + sizeof(Word) <= bytes.size(); i += sizeof(Word)) {
    Word word;
    std::memcpy(&word, bytes.data() + i, sizeof(Word));
    word = swapped(word);
    std::memcpy(bytes.data() + i, &word, sizeof(Word));
  }
}

}  // namespace

void to_native_order(const StoredVoxels& voxels, std::span<std::byte> bytes) {
  if (voxels.big_endian == (std::endian::native == std::endian::big)) return;
  const size_t voxel = voxel_bytes(voxels.type);
  if (voxel == 2) swap_each<uint16_t>(bytes);
  if (voxel == 4) swap_each<uint32_t>(bytes);
  if (voxel == 8) swap_each<uint64_t>(bytes);
}

}  // namespace isosplat
