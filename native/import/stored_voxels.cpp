#include "native/import/stored_voxels.h"

#include <algorithm>
#include <bit>
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

bool must_swap(const StoredVoxels& voxels) {
  return stored_bytes(voxels.type) > 1 &&
         voxels.big_endian != (std::endian::native == std::endian::big);
}

template <class From, class To>
void convert(const StoredVoxels& voxels, std::span<const std::byte> stored,
             std::span<std::byte> out) {
  const bool swap = must_swap(voxels);
  for (size_t i = 0; i < stored.size() / sizeof(From); ++i) {
    std::byte bytes[sizeof(From)];
    std::memcpy(bytes, stored.data() + i * sizeof(From), sizeof(From));
    if (swap) std::reverse(bytes, bytes + sizeof(From));
    From from;
    std::memcpy(&from, bytes, sizeof(From));
    const auto to = static_cast<To>(voxels.intercept + voxels.slope * static_cast<double>(from));
    std::memcpy(out.data() + i * sizeof(To), &to, sizeof(To));
  }
}

template <class From>
void convert_from(const StoredVoxels& voxels, std::span<const std::byte> stored, VoxelType to,
                  std::span<std::byte> out) {
  switch (to) {
    case VoxelType::u8:
      return convert<From, uint8_t>(voxels, stored, out);
    case VoxelType::i8:
      return convert<From, int8_t>(voxels, stored, out);
    case VoxelType::u16:
      return convert<From, uint16_t>(voxels, stored, out);
    case VoxelType::i16:
      return convert<From, int16_t>(voxels, stored, out);
    case VoxelType::u32:
      return convert<From, uint32_t>(voxels, stored, out);
    case VoxelType::i32:
      return convert<From, int32_t>(voxels, stored, out);
    case VoxelType::f32:
      return convert<From, float>(voxels, stored, out);
    case VoxelType::f64:
      return convert<From, double>(voxels, stored, out);
  }
}

}  // namespace

size_t stored_bytes(StoredType type) {
  constexpr size_t kBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kBytes[static_cast<size_t>(type)];
}

VoxelType read_type(const StoredVoxels& voxels) {
  switch (voxels.type) {
    case StoredType::u8:
      return voxels.is_rescaled() ? VoxelType::f32 : VoxelType::u8;
    case StoredType::i8:
      return voxels.is_rescaled() ? VoxelType::f32 : VoxelType::i8;
    case StoredType::u16:
      return voxels.is_rescaled() ? VoxelType::f32 : VoxelType::u16;
    case StoredType::i16:
      return voxels.is_rescaled() ? VoxelType::f32 : VoxelType::i16;
    case StoredType::u32:
      return voxels.is_rescaled() ? VoxelType::f64 : VoxelType::u32;
    case StoredType::i32:
      return voxels.is_rescaled() ? VoxelType::f64 : VoxelType::i32;
    case StoredType::f32:
      return VoxelType::f32;
    case StoredType::u64:
    case StoredType::i64:
    case StoredType::f64:
      return VoxelType::f64;
  }
  return VoxelType::f64;
}

bool decodes_in_place(const StoredVoxels& voxels) {
  return !voxels.is_rescaled() && voxels.type != StoredType::u64 && voxels.type != StoredType::i64;
}

void decode_in_place(const StoredVoxels& voxels, std::span<std::byte> bytes) {
  if (!must_swap(voxels)) return;
  const size_t voxel = stored_bytes(voxels.type);
  if (voxel == 2) swap_each<uint16_t>(bytes);
  if (voxel == 4) swap_each<uint32_t>(bytes);
  if (voxel == 8) swap_each<uint64_t>(bytes);
}

void decode(const StoredVoxels& voxels, std::span<const std::byte> stored, VoxelType to,
            std::span<std::byte> out) {
  switch (voxels.type) {
    case StoredType::u8:
      return convert_from<uint8_t>(voxels, stored, to, out);
    case StoredType::i8:
      return convert_from<int8_t>(voxels, stored, to, out);
    case StoredType::u16:
      return convert_from<uint16_t>(voxels, stored, to, out);
    case StoredType::i16:
      return convert_from<int16_t>(voxels, stored, to, out);
    case StoredType::u32:
      return convert_from<uint32_t>(voxels, stored, to, out);
    case StoredType::i32:
      return convert_from<int32_t>(voxels, stored, to, out);
    case StoredType::u64:
      return convert_from<uint64_t>(voxels, stored, to, out);
    case StoredType::i64:
      return convert_from<int64_t>(voxels, stored, to, out);
    case StoredType::f32:
      return convert_from<float>(voxels, stored, to, out);
    case StoredType::f64:
      return convert_from<double>(voxels, stored, to, out);
  }
}

}  // namespace isosplat
