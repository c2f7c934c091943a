#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "shared/grid/voxel_type.h"

// The pages of TIFF files and their pixels. Which pages are slices, and what their values mean, is
// decided in tiff.cpp.
namespace isosplat {

/// What a page's directory says.
struct TiffPage {
  int64_t width = 0;
  int64_t height = 0;
  VoxelType type = VoxelType::u8;
  int samples = 1;
  bool white_is_zero = false;
  bool palette = false;
  uint16_t orientation = 1;  ///< TIFF's tag 274: 1 to 8
  std::string unknown;       ///< why VoxelType does not have the type; empty: it does
  std::string undecodable;   ///< the name of the compression if it cannot be decoded here
  std::string description;   ///< tag 270: by the program that wrote the file
  std::optional<double> pixels_per_unit_x, pixels_per_unit_y;
  /// Where the first strip begins, if the rows are uncompressed.
  std::optional<uint64_t> uncompressed_at;

  bool same_kind(const TiffPage& other) const {
    return width == other.width && height == other.height && type == other.type &&
           samples == other.samples && white_is_zero == other.white_is_zero &&
           orientation == other.orientation && unknown == other.unknown;
  }
};

/// Sets type and unknown. `format`: tag 339 (1: unsigned, 2: signed, 3: floating-point, 5 and 6:
/// complex).
void set_voxel_type(uint16_t bits, uint16_t format, TiffPage& page);

/// An open file and its current page. Not thread-safe.
class TiffFile {
 public:
  virtual ~TiffFile() = default;

  /// Makes the page whose directory is at this offset the current one. Nothing if the directory is
  /// damaged.
  virtual std::optional<TiffPage> go_to(uint64_t directory) = 0;

  /// Whether all strips or tiles of the current page lie inside the file.
  virtual bool is_whole() = 0;

  /// Decodes the current page into `out`, which has exactly its size: rows as stored,
  /// native-endian. The page has one sample and a known type. False if it is damaged.
  virtual bool read(std::span<std::byte> out) = 0;
};

/// With libtiff. Null if it cannot open the file.
std::unique_ptr<TiffFile> open_libtiff(const std::filesystem::path& path);

/// Without a library, for WebAssembly: for it, distributions have no libtiff. It decodes rows that
/// are uncompressed, or compressed with Deflate, LZW or PackBits. Null if it cannot open the file.
std::unique_ptr<TiffFile> open_plain_tiff(const std::filesystem::path& path);

/// One of these.
std::unique_ptr<TiffFile> open_tiff(const std::filesystem::path& path);

}  // namespace isosplat
