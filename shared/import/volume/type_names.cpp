#include "shared/import/volume/type_names.h"

#include <string>

#include "shared/import/text/header_text.h"

namespace isosplat::import {

std::optional<VoxelType> voxel_type_of(std::string_view name) {
  struct Name {
    std::string_view text;
    VoxelType type;
  };
  static constexpr Name kNames[] = {
      {"u8", VoxelType::u8},      {"uint8", VoxelType::u8},   {"uchar", VoxelType::u8},
      {"i8", VoxelType::i8},      {"int8", VoxelType::i8},    {"char", VoxelType::i8},
      {"u16", VoxelType::u16},    {"uint16", VoxelType::u16}, {"ushort", VoxelType::u16},
      {"i16", VoxelType::i16},    {"int16", VoxelType::i16},  {"short", VoxelType::i16},
      {"u32", VoxelType::u32},    {"uint32", VoxelType::u32}, {"uint", VoxelType::u32},
      {"i32", VoxelType::i32},    {"int32", VoxelType::i32},  {"int", VoxelType::i32},
      {"u64", VoxelType::u64},    {"uint64", VoxelType::u64}, {"i64", VoxelType::i64},
      {"int64", VoxelType::i64},  {"f32", VoxelType::f32},    {"float32", VoxelType::f32},
      {"float", VoxelType::f32},  {"f64", VoxelType::f64},    {"float64", VoxelType::f64},
      {"double", VoxelType::f64},
  };
  const std::string lower = lower_case(name);
  for (const Name& known : kNames) {
    if (known.text == lower) return known.type;
  }
  return std::nullopt;
}

}  // namespace isosplat::import
