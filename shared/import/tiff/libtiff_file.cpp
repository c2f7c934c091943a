#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/tiff/file.h"

namespace isosplat::import {
namespace {

class LibtiffFile : public TiffFile {
 public:
  LibtiffFile(TIFF* tiff, uint64_t file_bytes) : tiff_(tiff, &TIFFClose), file_bytes_(file_bytes) {}

  std::optional<TiffPage> go_to(uint64_t directory) override {
    if (!TIFFSetSubDirectory(tiff_.get(), directory)) return std::nullopt;
    page_ = describe();
    return page_;
  }

  bool is_whole(uint64_t plane) override {
    if (plane > 0) return false;
    TIFF* tiff = tiff_.get();
    const bool tiled = TIFFIsTiled(tiff) != 0;
    const uint32_t parts = tiled ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
    uint64_t *offsets = nullptr, *counts = nullptr;
    if (!TIFFGetField(tiff, tiled ? TIFFTAG_TILEOFFSETS : TIFFTAG_STRIPOFFSETS, &offsets) ||
        !TIFFGetField(tiff, tiled ? TIFFTAG_TILEBYTECOUNTS : TIFFTAG_STRIPBYTECOUNTS, &counts)) {
      return false;
    }
    for (uint32_t i = 0; i < parts; ++i) {
      if (offsets[i] > file_bytes_ || counts[i] > file_bytes_ - offsets[i]) return false;
    }
    return true;
  }

  bool read(std::span<std::byte> out, TiffPart part) override {
    if (part.plane > 0 || part.sample < 0 || part.sample >= page_.samples) return false;
    return TIFFIsTiled(tiff_.get()) ? read_tiles(part.sample, out) : read_strips(part.sample, out);
  }

 private:
  TiffPage describe() {
    TIFF* tiff = tiff_.get();
    TiffPage page;
    uint32_t width = 0, height = 0, depth = 1;
    uint16_t bits = 1, samples = 1, format = SAMPLEFORMAT_UINT, planes = PLANARCONFIG_CONTIG,
             compression = COMPRESSION_NONE;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_IMAGEDEPTH, &depth);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planes);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &page.photometric);
    page.width = width;
    page.height = height;
    page.depth = std::max<uint32_t>(depth, 1);
    page.samples = samples;
    page.separate_planes = planes == PLANARCONFIG_SEPARATE && samples > 1;
    TIFFGetField(tiff, TIFFTAG_ORIENTATION, &page.orientation);
    set_voxel_type(bits, format, page);
    const char* text = nullptr;
    if (TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) && text) page.description = text;
    TIFFGetField(tiff, TIFFTAG_RESOLUTIONUNIT, &page.resolution_unit);
    page.pixels_per_unit_x = real(TIFFTAG_XRESOLUTION);
    page.pixels_per_unit_y = real(TIFFTAG_YRESOLUTION);
    uint64_t* offsets = nullptr;
    if (compression == COMPRESSION_NONE && !TIFFIsTiled(tiff) &&
        TIFFGetField(tiff, TIFFTAG_STRIPOFFSETS, &offsets)) {
      page.uncompressed_at = offsets[0];
    }
    return page;
  }

  std::optional<double> real(uint32_t tag) {
    float value = 0;
    if (!TIFFGetField(tiff_.get(), tag, &value)) return std::nullopt;
    return static_cast<double>(value);
  }

  /// Whether a strip or tile was not written: sparse files of GDAL have neither its offset nor its
  /// size.
  bool is_left_out(uint32_t part, bool tiled) {
    uint64_t *offsets = nullptr, *counts = nullptr;
    TIFF* tiff = tiff_.get();
    return TIFFGetField(tiff, tiled ? TIFFTAG_TILEOFFSETS : TIFFTAG_STRIPOFFSETS, &offsets) &&
           TIFFGetField(tiff, tiled ? TIFFTAG_TILEBYTECOUNTS : TIFFTAG_STRIPBYTECOUNTS, &counts) &&
           offsets[part] == 0 && counts[part] == 0;
  }

  /// Writes the voxels of a row of samples.
  void put_row(int sample, std::span<const std::byte> row, std::span<std::byte> voxels) const {
    if (page_.stored.are_voxels()) {
      std::memcpy(voxels.data(), row.data(), voxels.size());
    } else {
      unpack_row(page_.stored, page_.separate_planes ? 0 : static_cast<unsigned>(sample), row,
                 page_.type, voxels);
    }
  }

  bool read_tiles(int sample, std::span<std::byte> out) {
    TIFF* tiff = tiff_.get();
    uint32_t tile_width = 0, tile_height = 0;
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
    const uint64_t bytes = TIFFTileSize64(tiff), tile_row = page_.stored.row_bytes(tile_width);
    const size_t voxel = voxel_bytes(page_.type), row = static_cast<size_t>(page_.width) * voxel;
    // In a valid file, a tile exceeds the page by less than one tile in each direction.
    if (tile_width == 0 || tile_height == 0 || bytes != tile_row * uint64_t{tile_height} ||
        bytes > 4 * (out.size() * page_.stored.per_pixel + (1u << 20))) {
      return false;
    }
    std::vector<std::byte> tile(static_cast<size_t>(bytes));
    const auto plane = static_cast<uint16_t>(page_.separate_planes ? sample : 0);
    for (int64_t y = 0; y < page_.height; y += tile_height) {
      for (int64_t x = 0; x < page_.width; x += tile_width) {
        const auto left = static_cast<uint32_t>(x), top = static_cast<uint32_t>(y);
        if (is_left_out(TIFFComputeTile(tiff, left, top, 0, plane), true)) {
          fill_left_out(page_, tile);
        } else if (TIFFReadTile(tiff, tile.data(), left, top, 0, plane) < 0) {
          return false;
        }
        const auto rows = static_cast<size_t>(std::min<int64_t>(tile_height, page_.height - y));
        const auto columns = static_cast<size_t>(std::min<int64_t>(tile_width, page_.width - x));
        for (size_t r = 0; r < rows; ++r) {
          put_row(sample, std::span(tile).subspan(r * tile_row, tile_row),
                  out.subspan((static_cast<size_t>(y) + r) * row + static_cast<size_t>(x) * voxel,
                              columns * voxel));
        }
      }
    }
    return true;
  }

  bool read_strips(int sample, std::span<std::byte> out) {
    TIFF* tiff = tiff_.get();
    const auto width = static_cast<uint64_t>(page_.width),
               height = static_cast<uint64_t>(page_.height);
    const uint64_t stored_row = page_.stored.row_bytes(width);
    const size_t row = static_cast<size_t>(width) * voxel_bytes(page_.type);
    if (TIFFScanlineSize64(tiff) != stored_row || out.size() != row * height) return false;
    uint32_t rows_per_strip = 0;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows_per_strip);
    if (rows_per_strip == 0) return false;
    const bool converts = !page_.stored.are_voxels();
    for (uint64_t y = 0; y < height; y += rows_per_strip) {
      const uint64_t rows = std::min<uint64_t>(rows_per_strip, height - y);
      const uint32_t strip =
          TIFFComputeStrip(tiff, static_cast<uint32_t>(y),
                           static_cast<uint16_t>(page_.separate_planes ? sample : 0));
      auto voxels = out.subspan(static_cast<size_t>(y) * row, static_cast<size_t>(rows) * row);
      std::span<std::byte> stored = voxels;
      if (converts) {
        strip_.resize(static_cast<size_t>(rows * stored_row));
        stored = strip_;
      }
      if (is_left_out(strip, false)) {
        fill_left_out(page_, stored);
      } else {
        const tmsize_t got =
            TIFFReadEncodedStrip(tiff, strip, stored.data(), static_cast<tmsize_t>(stored.size()));
        if (got < 0 || static_cast<size_t>(got) != stored.size()) return false;
      }
      for (uint64_t r = 0; converts && r < rows; ++r) {
        put_row(sample, stored.subspan(static_cast<size_t>(r * stored_row), stored_row),
                voxels.subspan(static_cast<size_t>(r) * row, row));
      }
    }
    return true;
  }

  std::unique_ptr<TIFF, decltype(&TIFFClose)> tiff_;
  uint64_t file_bytes_;
  TiffPage page_;
  std::vector<std::byte> strip_;  ///< as stored, if its rows are converted
};

}  // namespace

std::unique_ptr<TiffFile> open_libtiff(const std::filesystem::path& path) {
  // Its messages are discarded.
  TIFFSetWarningHandler(nullptr);
  TIFFSetErrorHandler(nullptr);
  const auto bytes = size_of_file(path);
  if (!bytes) return nullptr;
  // "m" disables memory mapping, since a file may shrink.
  TIFF* tiff = TIFFOpen(path.c_str(), "rm");
  return tiff ? std::make_unique<LibtiffFile>(tiff, *bytes) : nullptr;
}

}  // namespace isosplat::import
