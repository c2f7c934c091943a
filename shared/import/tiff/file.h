#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "shared/core/grid/voxel_type.h"
#include "shared/import/tiff/samples.h"

// The pages of TIFF files and their pixels. tiff.cpp determines which pages are slices, and the
// meaning of their values.
namespace isosplat::import {

/// The contents of a page's directory.
struct TiffPage {
  int64_t width = 0;
  int64_t height = 0;
  int64_t depth = 1;  ///< tag 32997: slices of the page
  VoxelType type = VoxelType::u8;
  TiffSamples stored;
  int samples = 1;               ///< of a pixel
  bool separate_planes = false;  ///< each sample has separate strips or tiles
  uint16_t photometric = 1;      ///< tag 262
  uint16_t orientation = 1;      ///< TIFF's tag 274: 1 to 8
  std::string unknown;           ///< the type, if VoxelType does not support it; else empty
  std::string undecodable;       ///< the name of the compression if it cannot be decoded here
  std::string description;       ///< tag 270: by the program that wrote the file
  std::optional<double> pixels_per_unit_x, pixels_per_unit_y;
  uint16_t resolution_unit = 2;  ///< tag 296: 1 none, 2 inch, 3 centimetre
  /// Offset of the first strip, if the rows are uncompressed.
  std::optional<uint64_t> uncompressed_at;

  bool white_is_zero() const { return photometric == 0; }
  bool palette() const { return photometric == 3; }

  bool same_kind(const TiffPage& other) const {
    return width == other.width && height == other.height && depth == other.depth &&
           type == other.type && stored == other.stored && samples == other.samples &&
           white_is_zero() == other.white_is_zero() && orientation == other.orientation &&
           unknown == other.unknown;
  }
};

/// Sets type, stored and unknown. `format`: tag 339 (1: unsigned, 2: signed, 3: floating-point, 5
/// and 6: complex). The type can represent all numbers of the stored bits. Reads page.samples and
/// page.separate_planes.
void set_voxel_type(uint16_t bits, uint16_t format, TiffPage& page);

/// A part of a page.
struct TiffPart {
  /// A slice of a page with a depth. Otherwise, one of several planes that follow each other in the
  /// file, of which only the first has a directory.
  uint64_t plane = 0;
  int sample = 0;  ///< of each pixel
};

/// An open file and its current page. Not thread-safe.
class TiffFile {
 public:
  virtual ~TiffFile() = default;

  /// Makes the page whose directory is at this offset the current one. Nothing if the directory is
  /// damaged.
  virtual std::optional<TiffPage> go_to(uint64_t directory) = 0;

  /// Whether all strips or tiles of the plane lie inside the file, or were not written
  /// (TiffPages::left_out_parts).
  virtual bool is_whole(uint64_t plane = 0) = 0;

  /// Decodes a part of the current page into `out`, which has exactly its size: rows as stored,
  /// native-endian. The page must have a known type. Strips and tiles that were not written have
  /// one value. Returns false if the part is damaged.
  virtual bool read(std::span<std::byte> out, TiffPart part = {}) = 0;

  /// Sets the value of strips and tiles that were not written.
  void set_left_out_value(double value) { left_out_ = value; }

 protected:
  /// Fills voxels, or samples as stored, of a strip or tile that was not written.
  void fill_left_out(const TiffPage& page, std::span<std::byte> out) const;

 private:
  double left_out_ = 0;
};

/// With libtiff, which reads only the first plane of a page. Null if it cannot open the file.
std::unique_ptr<TiffFile> open_libtiff(const std::filesystem::path& path);

/// Without a library, for WebAssembly, since distributions have no libtiff for it. Decodes rows
/// that are uncompressed, or compressed with Deflate, LZW or PackBits. Null if it cannot open the
/// file.
std::unique_ptr<TiffFile> open_plain_tiff(const std::filesystem::path& path);

/// Opens a file with one of these. `has_planes`: planes after the first plane of a page will be
/// read.
std::unique_ptr<TiffFile> open_tiff(const std::filesystem::path& path, bool has_planes);

}  // namespace isosplat::import
