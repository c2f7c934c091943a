#include "shared/import/tiff_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "shared/import/absent_voxels.h"
#include "shared/import/array_source.h"

namespace isosplat {
namespace {

/// Reads the current page, which is of the given kind, into `out`, rows from the top. libtiff has
/// already converted the byte order.
bool read_page(TIFF* tiff, const TiffPage& page, std::span<std::byte> out) {
  const size_t row = static_cast<size_t>(page.width) * voxel_bytes(page.type);
  std::vector<std::byte> buffer;
  if (TIFFIsTiled(tiff)) {
    uint32_t tile_width = 0, tile_height = 0;
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
    const uint64_t bytes = TIFFTileSize64(tiff);
    const size_t tile_row = tile_width * voxel_bytes(page.type);
    // In a valid file, a tile exceeds the page by less than one tile in each direction.
    if (tile_width == 0 || tile_height == 0 || bytes != tile_row * uint64_t{tile_height} ||
        bytes > 4 * (out.size() + (1u << 20))) {
      return false;
    }
    buffer.resize(static_cast<size_t>(bytes));
    for (int64_t y = 0; y < page.height; y += tile_height) {
      for (int64_t x = 0; x < page.width; x += tile_width) {
        if (TIFFReadTile(tiff, buffer.data(), static_cast<uint32_t>(x), static_cast<uint32_t>(y), 0,
                         0) < 0) {
          return false;
        }
        const auto rows = static_cast<size_t>(std::min<int64_t>(tile_height, page.height - y));
        const auto columns = static_cast<size_t>(std::min<int64_t>(tile_width, page.width - x));
        for (size_t r = 0; r < rows; ++r) {
          std::memcpy(out.data() + (static_cast<size_t>(y) + r) * row +
                          static_cast<size_t>(x) * voxel_bytes(page.type),
                      buffer.data() + r * tile_row, columns * voxel_bytes(page.type));
        }
      }
    }
    return true;
  }
  if (static_cast<uint64_t>(TIFFScanlineSize64(tiff)) != row) return false;
  uint32_t rows_per_strip = 0;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows_per_strip);
  if (rows_per_strip == 0) return false;
  const uint32_t strips = TIFFNumberOfStrips(tiff);
  size_t done = 0;
  for (uint32_t strip = 0; strip < strips && done < out.size(); ++strip) {
    const size_t wanted =
        static_cast<size_t>(std::min<uint64_t>(out.size() - done, uint64_t{rows_per_strip} * row));
    const tmsize_t got =
        TIFFReadEncodedStrip(tiff, strip, out.data() + done, static_cast<tmsize_t>(wanted));
    if (got < 0 || static_cast<size_t>(got) != wanted) return false;
    done += wanted;
  }
  return done == out.size();
}

/// Inverts unsigned voxels that are stored with 0 as white.
void invert(std::span<std::byte> bytes) {
  for (std::byte& b : bytes) b = ~b;
}

void reverse_columns(std::span<std::byte> row, size_t voxel) {
  for (size_t a = 0, b = row.size() - voxel; a < b; a += voxel, b -= voxel) {
    std::swap_ranges(row.data() + a, row.data() + a + voxel, row.data() + b);
  }
}

/// Reorders rows and columns so that the first pixel is at the top left.
void apply_orientation(uint16_t orientation, size_t row_bytes, size_t voxel,
                       std::span<std::byte> slice) {
  if (orientation == ORIENTATION_BOTLEFT || orientation == ORIENTATION_BOTRIGHT) {
    reverse_rows(slice, row_bytes);
  }
  if (orientation == ORIENTATION_TOPRIGHT || orientation == ORIENTATION_BOTRIGHT) {
    for (size_t at = 0; at < slice.size(); at += row_bytes) {
      reverse_columns(slice.subspan(at, row_bytes), voxel);
    }
  }
}

class TiffSource : public VolumeSource {
 public:
  TiffSource(VolumeHeader header, TiffPage page, std::vector<TiffSlice> slices)
      : header_(std::move(header)), page_(std::move(page)), slices_(std::move(slices)) {
    const bool lacks_some = std::any_of(slices_.begin(), slices_.end(),
                                        [](const TiffSlice& slice) { return slice.path.empty(); });
    if (lacks_some) header_.type = type_with_absent(header_.type);
  }

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const size_t pixels = static_cast<size_t>(page_.width) * static_cast<size_t>(page_.height);
    const size_t slice = pixels * voxel_bytes(header_.type);
    if (first < 0 || count < 1 || int64_t{first} + count > header_.grid.voxels.z ||
        out.size() != slice * static_cast<size_t>(count)) {
      return fail(Status::invalid_argument, "expected a range of slices inside the volume");
    }
    const size_t voxel = voxel_bytes(page_.type);
    for (int32_t i = 0; i < count; ++i) {
      auto to = out.subspan(static_cast<size_t>(i) * slice, slice);
      const TiffSlice& from = slices_[static_cast<size_t>(first + i)];
      if (from.path.empty()) {
        make_absent(header_.type, to);
        continue;
      }
      std::span<std::byte> stored = to;
      if (header_.type != page_.type) {
        stored_.resize(pixels * voxel);
        stored = stored_;
      }
      if (auto read = read_slice(from, stored); !read) return read;
      if (page_.white_is_zero && is_unsigned(page_.type)) invert(stored);
      apply_orientation(page_.orientation, static_cast<size_t>(page_.width) * voxel, voxel, stored);
      if (header_.type != page_.type) convert_voxels(page_.type, stored, header_.type, to);
    }
    return {};
  }

  uint64_t resident_bytes() const override { return 0; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    for (const TiffSlice& slice : slices_) {
      if (!slice.path.empty() && (files.empty() || files.back() != slice.path)) {
        files.push_back(slice.path);
      }
    }
    return files;
  }

 private:
  Result<void> read_slice(const TiffSlice& slice, std::span<std::byte> out) {
    if (!open_ || open_path_ != slice.path) {
      open_ = open_tiff(slice.path);
      open_path_ = slice.path;
    }
    const std::string where = fmt::format("{}, page at byte {}", slice.path.string(), slice.page);
    if (!open_ || !TIFFSetSubDirectory(open_.get(), slice.page)) return damaged_tiff(where);
    const TiffPage page = describe_page(open_.get());
    if (!page.same_kind(page_)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected a slice of {} × {} voxels like the first, found {} × "
                              "{} or another type: all slices of a stack must have the same size "
                              "and type; remove the different one",
                              where, page_.width, page_.height, page.width, page.height));
    }
    if (!read_page(open_.get(), page, out)) return damaged_tiff(where);
    return {};
  }

  VolumeHeader header_;
  TiffPage page_;
  std::vector<TiffSlice> slices_;
  TiffHandle open_{nullptr, &TIFFClose};
  std::filesystem::path open_path_;
  std::vector<std::byte> stored_;  ///< a slice as stored, if other slices are absent
};

}  // namespace

TiffHandle open_tiff(const std::filesystem::path& path) {
  TIFFSetWarningHandler(nullptr);
  TIFFSetErrorHandler(nullptr);
  // "m" disables memory mapping, since a file may shrink.
  return {TIFFOpen(path.c_str(), "rm"), &TIFFClose};
}

TiffPage describe_page(TIFF* tiff) {
  TiffPage page;
  uint32_t width = 0, height = 0;
  uint16_t bits = 1, samples = 1, format = SAMPLEFORMAT_UINT, photometric = PHOTOMETRIC_MINISBLACK;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  page.width = width;
  page.height = height;
  page.samples = samples;
  page.palette = photometric == PHOTOMETRIC_PALETTE;
  page.white_is_zero = photometric == PHOTOMETRIC_MINISWHITE;
  TIFFGetField(tiff, TIFFTAG_ORIENTATION, &page.orientation);
  const bool is_float = format == SAMPLEFORMAT_IEEEFP, is_signed = format == SAMPLEFORMAT_INT;
  if (format == SAMPLEFORMAT_COMPLEXINT || format == SAMPLEFORMAT_COMPLEXIEEEFP) {
    page.unknown = "complex numbers";
  } else if (bits == 8 && !is_float) {
    page.type = is_signed ? VoxelType::i8 : VoxelType::u8;
  } else if (bits == 16 && !is_float) {
    page.type = is_signed ? VoxelType::i16 : VoxelType::u16;
  } else if (bits == 32) {
    page.type = is_float ? VoxelType::f32 : is_signed ? VoxelType::i32 : VoxelType::u32;
  } else if (bits == 64) {
    page.type = is_float ? VoxelType::f64 : is_signed ? VoxelType::i64 : VoxelType::u64;
  } else {
    page.unknown = fmt::format("{} bits per voxel{}", bits, is_float ? ", float" : "");
  }
  return page;
}

tl::unexpected<Error> damaged_tiff(const std::string& where) {
  return fail(Status::malformed_volume,
              fmt::format("{}: its voxels cannot be decoded: the TIFF file is damaged or "
                          "incomplete; copy or download it again",
                          where));
}

bool is_whole_page(TIFF* tiff, uint64_t file_bytes) {
  const bool tiled = TIFFIsTiled(tiff) != 0;
  const uint32_t parts = tiled ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
  uint64_t *offsets = nullptr, *counts = nullptr;
  if (!TIFFGetField(tiff, tiled ? TIFFTAG_TILEOFFSETS : TIFFTAG_STRIPOFFSETS, &offsets) ||
      !TIFFGetField(tiff, tiled ? TIFFTAG_TILEBYTECOUNTS : TIFFTAG_STRIPBYTECOUNTS, &counts)) {
    return false;
  }
  for (uint32_t i = 0; i < parts; ++i) {
    if (offsets[i] > file_bytes || counts[i] > file_bytes - offsets[i]) return false;
  }
  return true;
}

bool is_unsigned(VoxelType type) {
  return type == VoxelType::u8 || type == VoxelType::u16 || type == VoxelType::u32 ||
         type == VoxelType::u64;
}

std::unique_ptr<VolumeSource> make_tiff_source(VolumeHeader header, TiffPage page,
                                               std::vector<TiffSlice> slices) {
  return std::make_unique<TiffSource>(std::move(header), std::move(page), std::move(slices));
}

}  // namespace isosplat
