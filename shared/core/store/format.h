#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "shared/core/base/status.h"
#include "shared/core/grid/grid.h"

/// Constants of the store format for reader and writer. FORMAT.md is the specification.
namespace isosplat {

inline constexpr std::array<uint8_t, 8> kStoreMagic = {0x89, 'I', 'S', 'O', 'S', '\r', '\n', 0x1a};
inline constexpr uint16_t kStoreMajor = 1;
inline constexpr uint16_t kStoreMinor = 0;        ///< of stores without fields
inline constexpr uint16_t kStoreFieldsMinor = 1;  ///< of stores with fields, and of fields

inline constexpr size_t kFixedHeaderBytes = 48;
inline constexpr size_t kContentIdOffset = 32;
inline constexpr size_t kHeaderChecksumBytes = 8;  ///< the header's last bytes
inline constexpr size_t kSectionHeaderBytes = 8;
inline constexpr size_t kVolumeSectionBytes = 176;
inline constexpr size_t kLevelSectionHeaderBytes = 8;
inline constexpr size_t kLevelRecordBytes = 32;
inline constexpr size_t kPageRecordBytes = 12;
inline constexpr size_t kPageHeaderBytes = 8;
inline constexpr size_t kFieldListHeaderBytes = 8;
inline constexpr size_t kFieldRecordBytes = 40;  ///< without the name
inline constexpr size_t kBlockRecordBytes = 12;
inline constexpr size_t kChunkRecordBytes = 12;

constexpr uint32_t section_tag(char a, char b, char c, char d) {
  return static_cast<uint32_t>(static_cast<uint8_t>(a)) |
         static_cast<uint32_t>(static_cast<uint8_t>(b)) << 8 |
         static_cast<uint32_t>(static_cast<uint8_t>(c)) << 16 |
         static_cast<uint32_t>(static_cast<uint8_t>(d)) << 24;
}
inline constexpr uint32_t kVolumeTag = section_tag('V', 'O', 'L', 'U');
inline constexpr uint32_t kLevelsTag = section_tag('L', 'E', 'V', 'L');
inline constexpr uint32_t kPagesTag = section_tag('P', 'A', 'G', 'E');
inline constexpr uint32_t kMetadataTag = section_tag('M', 'E', 'T', 'A');
inline constexpr uint32_t kFieldListTag = section_tag('f', 'l', 'd', 's');
inline constexpr uint32_t kOwnFieldTag = section_tag('F', 'I', 'E', 'L');

/// Readers may skip a section that they do not support if its tag begins with a lower-case letter.
constexpr bool is_optional_section(uint32_t tag) {
  return (tag & 0x20) != 0;
}

constexpr size_t padded_to_8(size_t bytes) {
  return (bytes + 7) / 8 * 8;
}

inline constexpr uint32_t kMaxPages = 3500;
inline constexpr size_t kMaxMetadataBytes = 16 * 1024;
inline constexpr uint32_t kMaxFields = 16;
inline constexpr size_t kMaxFieldNameBytes = 64;
inline constexpr uint32_t kMinPageLog2 = 2, kMaxPageLog2 = 5;
inline constexpr uint32_t kMaxChunkBytes = (1u << 24) - 1;
inline constexpr uint64_t kMaxFileBytes = uint64_t{1} << 48;

/// The number of pages of a level along each axis. A page is a box of 2^log2 blocks along each
/// axis.
constexpr Index3 pages_of_level(Index3 blocks, uint32_t log2) {
  const int32_t round = (1 << log2) - 1;
  return {(blocks.x + round) >> log2, (blocks.y + round) >> log2, (blocks.z + round) >> log2};
}

/// The binary logarithm of a page's blocks along each axis: the smallest for which the header can
/// list all pages. Errors: no_cells, volume_too_large.
Result<uint32_t> choose_page_log2(Index3 voxels);

/// The number of pages of a store, over all levels.
uint64_t total_pages(Index3 voxels, uint32_t page_log2);

/// Whether every axis has 2 to kMaxVoxelsPerAxis voxels. Errors: no_cells, volume_too_large.
Result<void> check_dimensions(Index3 voxels);

}  // namespace isosplat
