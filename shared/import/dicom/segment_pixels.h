#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "shared/core/grid/voxel_type.h"
#include "shared/import/dicom/frames.h"

// The pixels of the segments of a segmentation, slice by slice.
namespace isosplat::import::dicom {

/// A frame of a segment.
struct SegmentFrame {
  uint32_t image = 0, index = 0;  ///< image: in SegmentPixels::images
  uint16_t segment = 0;           ///< index of the segment
};

/// The frames of a segmentation, of one segment each, by slice.
struct SegmentPixels {
  std::vector<Image> images;
  std::vector<std::vector<SegmentFrame>> slices;
  VoxelType type = VoxelType::u8;  ///< can hold all stored values
  double threshold = 0.5;          ///< stored values from it on are inside the segment
  bool fill_missing = false;       ///< pixels that a truncated file lacks are outside
  uint64_t memory_bytes = 0;       ///< limit of the child process that decompresses

  /// Receives a slice, the index of a segment, and a byte for each of its pixels: 1 inside, else 0.
  using Use = std::function<Result<void>(size_t slice, uint16_t segment, std::span<const uint8_t>)>;

  /// Reads the frames of some slices in order, a few at a time. `wanted`: whether to read those of
  /// a segment. Errors: those of read_frames and of `use`.
  Result<void> read(size_t first, size_t count, const std::function<bool(uint16_t)>& wanted,
                    const Use& use) const;
};

/// Assigns segments to groups so that no two segments of a group have a pixel in common: each to
/// the first possible group, in order. `count`: of segments. Reads all pixels. Errors: those of
/// SegmentPixels::read; unsupported_format if too many segments overlap at one pixel.
Result<std::vector<uint16_t>> groups_without_overlap(const SegmentPixels& pixels, size_t count,
                                                     const std::filesystem::path& path,
                                                     uint64_t memory_bytes);

}  // namespace isosplat::import::dicom
