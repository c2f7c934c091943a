#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "shared/import/byte_reader.h"
#include "shared/import/tiff_file.h"

namespace isosplat {
namespace {

class LibtiffFile : public TiffFile {
 public:
  LibtiffFile(TIFF* tiff, uint64_t file_bytes) : tiff_(tiff, &TIFFClose), file_bytes_(file_bytes) {}

  std::optional<TiffPage> go_to(uint64_t directory) override {
    if (!TIFFSetSubDirectory(tiff_.get(), directory)) return std::nullopt;
    page_ = describe();
    return page_;
  }

  bool is_whole() override {
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

  bool read(std::span<std::byte> out) override {
    const size_t row = static_cast<size_t>(page_.width) * voxel_bytes(page_.type);
    return TIFFIsTiled(tiff_.get()) ? read_tiles(row, out) : read_strips(row, out);
  }

 private:
  TiffPage describe() {
    TIFF* tiff = tiff_.get();
    TiffPage page;
    uint32_t width = 0, height = 0;
    uint16_t bits = 1, samples = 1, format = SAMPLEFORMAT_UINT,
             photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    page.width = width;
    page.height = height;
    page.samples = samples;
    page.palette = photometric == PHOTOMETRIC_PALETTE;
    page.white_is_zero = photometric == PHOTOMETRIC_MINISWHITE;
    TIFFGetField(tiff, TIFFTAG_ORIENTATION, &page.orientation);
    set_voxel_type(bits, format, page);
    const char* text = nullptr;
    if (TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) && text) page.description = text;
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

  bool read_tiles(size_t row, std::span<std::byte> out) {
    TIFF* tiff = tiff_.get();
    uint32_t tile_width = 0, tile_height = 0;
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
    const uint64_t bytes = TIFFTileSize64(tiff);
    const size_t voxel = voxel_bytes(page_.type), tile_row = tile_width * voxel;
    // In a valid file, a tile exceeds the page by less than one tile in each direction.
    if (tile_width == 0 || tile_height == 0 || bytes != tile_row * uint64_t{tile_height} ||
        bytes > 4 * (out.size() + (1u << 20))) {
      return false;
    }
    std::vector<std::byte> tile(static_cast<size_t>(bytes));
    for (int64_t y = 0; y < page_.height; y += tile_height) {
      for (int64_t x = 0; x < page_.width; x += tile_width) {
        if (TIFFReadTile(tiff, tile.data(), static_cast<uint32_t>(x), static_cast<uint32_t>(y), 0,
                         0) < 0) {
          return false;
        }
        const auto rows = static_cast<size_t>(std::min<int64_t>(tile_height, page_.height - y));
        const auto columns = static_cast<size_t>(std::min<int64_t>(tile_width, page_.width - x));
        for (size_t r = 0; r < rows; ++r) {
          std::memcpy(
              out.data() + (static_cast<size_t>(y) + r) * row + static_cast<size_t>(x) * voxel,
              tile.data() + r * tile_row, columns * voxel);
        }
      }
    }
    return true;
  }

  bool read_strips(size_t row, std::span<std::byte> out) {
    TIFF* tiff = tiff_.get();
    if (static_cast<uint64_t>(TIFFScanlineSize64(tiff)) != row) return false;
    uint32_t rows_per_strip = 0;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows_per_strip);
    if (rows_per_strip == 0) return false;
    const uint32_t strips = TIFFNumberOfStrips(tiff);
    size_t done = 0;
    for (uint32_t strip = 0; strip < strips && done < out.size(); ++strip) {
      const size_t wanted = static_cast<size_t>(
          std::min<uint64_t>(out.size() - done, uint64_t{rows_per_strip} * row));
      const tmsize_t got =
          TIFFReadEncodedStrip(tiff, strip, out.data() + done, static_cast<tmsize_t>(wanted));
      if (got < 0 || static_cast<size_t>(got) != wanted) return false;
      done += wanted;
    }
    return done == out.size();
  }

  std::unique_ptr<TIFF, decltype(&TIFFClose)> tiff_;
  uint64_t file_bytes_;
  TiffPage page_;
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

}  // namespace isosplat
