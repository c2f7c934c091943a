#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "native/import/array_source.h"
#include "native/import/formats.h"
#include "native/import/header_text.h"
#include "native/import/slice_files.h"

// TIFF stacks: a file with a page per slice, or a folder with a file per slice. Read by libtiff
// itself, as ITK's reader can only take a file whole.
namespace isosplat {
namespace {

using TiffHandle = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

TiffHandle open_tiff(const std::filesystem::path& path) {
  TIFFSetWarningHandler(nullptr);
  TIFFSetErrorHandler(nullptr);
  return {TIFFOpen(path.c_str(), "rm"), &TIFFClose};  // m: no memory mapping; a file may shrink
}

struct Page {
  int64_t width = 0;
  int64_t height = 0;
  StoredType type = StoredType::u8;
  int samples = 1;
  bool white_is_zero = false;
  bool palette = false;
  std::string unknown;  ///< why the type is none of StoredType; empty: it is one

  bool same_kind(const Page& other) const {
    return width == other.width && height == other.height && type == other.type &&
           samples == other.samples && white_is_zero == other.white_is_zero;
  }
};

Page describe(TIFF* tiff) {
  Page page;
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
  const bool is_float = format == SAMPLEFORMAT_IEEEFP, is_signed = format == SAMPLEFORMAT_INT;
  if (bits == 8 && !is_float) {
    page.type = is_signed ? StoredType::i8 : StoredType::u8;
  } else if (bits == 16 && !is_float) {
    page.type = is_signed ? StoredType::i16 : StoredType::u16;
  } else if (bits == 32) {
    page.type = is_float ? StoredType::f32 : is_signed ? StoredType::i32 : StoredType::u32;
  } else if (bits == 64) {
    page.type = is_float ? StoredType::f64 : is_signed ? StoredType::i64 : StoredType::u64;
  } else {
    page.unknown = fmt::format("{} bits per voxel{}", bits, is_float ? ", float" : "");
  }
  return page;
}

tl::unexpected<Error> damaged(const std::string& where) {
  return fail(Status::malformed_volume,
              fmt::format("{}: its voxels cannot be decoded: the TIFF file is damaged or "
                          "incomplete; copy or download it again",
                          where));
}

/// Reads the current page, which is of the given kind, into `out`: rows from the top. libtiff has
/// brought the bytes into this machine's order.
bool read_page(TIFF* tiff, const Page& page, std::span<std::byte> out) {
  const size_t row = static_cast<size_t>(page.width) * stored_bytes(page.type);
  std::vector<std::byte> buffer;
  if (TIFFIsTiled(tiff)) {
    uint32_t tile_width = 0, tile_height = 0;
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
    const uint64_t bytes = TIFFTileSize64(tiff);
    const size_t tile_row = tile_width * stored_bytes(page.type);
    // A tile is at most one tile larger than the page in each direction, in a sane file.
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
                          static_cast<size_t>(x) * stored_bytes(page.type),
                      buffer.data() + r * tile_row, columns * stored_bytes(page.type));
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

/// Unsigned voxels stored with 0 as white are shown as they look: inverted.
void invert(std::span<std::byte> bytes) {
  for (std::byte& b : bytes) b = ~b;
}

/// Slices that are pages of one file, or the first pages of several.
class TiffSource : public VolumeSource {
 public:
  TiffSource(VolumeHeader header, Page page, std::vector<std::filesystem::path> files,
             std::vector<uint64_t> page_offsets)
      : header_(std::move(header)),
        page_(std::move(page)),
        files_(std::move(files)),
        page_offsets_(std::move(page_offsets)) {}

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const size_t pixels = static_cast<size_t>(page_.width) * static_cast<size_t>(page_.height);
    const size_t slice = pixels * voxel_bytes(header_.type);
    if (first < 0 || count < 1 || int64_t{first} + count > header_.grid.voxels.z ||
        out.size() != slice * static_cast<size_t>(count)) {
      return fail(Status::invalid_argument, "slices outside the volume were asked for");
    }
    for (int32_t i = 0; i < count; ++i) {
      auto to = out.subspan(static_cast<size_t>(i) * slice, slice);
      if (auto read = read_slice(static_cast<size_t>(first + i), to); !read) return read;
      if (page_.white_is_zero) invert(to);
    }
    return {};
  }

  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return files_; }

 private:
  Result<void> read_slice(size_t index, std::span<std::byte> out) {
    const bool pages = !page_offsets_.empty();
    const std::filesystem::path& path = pages ? files_[0] : files_[index];
    if (!pages || !open_) open_ = open_tiff(path);
    const std::string where =
        pages ? fmt::format("{}, page {}", path.string(), index + 1) : path.string();
    if (!open_) return damaged(where);
    if (pages && !TIFFSetSubDirectory(open_.get(), page_offsets_[index])) return damaged(where);
    const Page page = describe(open_.get());
    if (!page.same_kind(page_)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected a slice of {} × {} voxels like the first, found {} × "
                              "{} or another type: a stack's slices must be alike; take the odd "
                              "one out",
                              where, page_.width, page_.height, page.width, page.height));
    }
    if (!read_page(open_.get(), page, out)) return damaged(where);
    return {};
  }

  VolumeHeader header_;
  Page page_;
  std::vector<std::filesystem::path> files_;
  std::vector<uint64_t> page_offsets_;  ///< of one file's pages; empty: a file per slice
  TiffHandle open_{nullptr, &TIFFClose};
};

/// ImageJ writes the distance between slices into the description of the first page.
std::optional<double> imagej_spacing(TIFF* tiff) {
  const char* text = nullptr;
  if (!TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) || !text) return std::nullopt;
  const std::string_view description(text);
  const size_t at = description.find("\nspacing=");
  if (!description.starts_with("ImageJ=") || at == description.npos) return std::nullopt;
  const std::string_view number = description.substr(at + 9);
  double spacing = 0;
  const auto parsed = std::from_chars(number.data(), number.data() + number.size(), spacing);
  if (parsed.ec != std::errc{} || !(spacing > 0) || !std::isfinite(spacing)) return std::nullopt;
  return spacing;
}

/// A page's size along an axis in the unit of its resolution (ImageJ counts in that unit as well).
double pixel_size(TIFF* tiff, uint32_t tag) {
  float resolution = 0;
  if (!TIFFGetField(tiff, tag, &resolution) || !(resolution > 0)) return 1;
  return 1 / static_cast<double>(resolution);
}

Result<OpenVolume> open_stack(const std::filesystem::path& path, TIFF* first,
                              std::vector<std::filesystem::path> files,
                              std::vector<uint64_t> page_offsets, const ImportOptions& options) {
  OpenVolume volume;
  const Page page = describe(first);
  if (page.palette) {
    return fail(Status::unsupported_type,
                fmt::format("{}: expected grey values, found a colour palette: convert the stack "
                            "to grey",
                            files[0].string()));
  }
  if (page.samples != 1) return not_scalar(files[0], page.samples);
  if (!page.unknown.empty()) return unknown_type(files[0], page.unknown);
  if (options.time_step.value_or(0) != 0) {
    return fail(
        Status::invalid_argument,
        fmt::format("{}: TIFF stacks have no time steps: leave --time-step away", path.string()));
  }

  HeaderGeometry geometry;
  if (options.spacing) {
    geometry.spacing = *options.spacing;
  } else if (const auto between_slices = imagej_spacing(first)) {
    geometry.spacing = {pixel_size(first, TIFFTAG_XRESOLUTION),
                        pixel_size(first, TIFFTAG_YRESOLUTION), *between_slices};
  } else {
    volume.notes.push_back(
        "TIFF does not say how far apart the slices are: spacing 1,1,1 is taken; --spacing sets "
        "another");
  }
  const auto slices = page_offsets.empty() ? files.size() : page_offsets.size();
  auto orientation = orient({page.width, page.height, static_cast<int64_t>(slices)}, geometry);
  if (!orientation) {
    return fail(orientation.error().status, path.string() + ": " + orientation.error().message);
  }
  VolumeHeader header{orientation->grid, page.type, "TIFF", volume_name(path)};
  volume.source = std::make_unique<TiffSource>(std::move(header), page, std::move(files),
                                               std::move(page_offsets));
  return volume;
}

}  // namespace

Result<OpenVolume> open_tiff_file(const std::filesystem::path& path, const ImportOptions& options) {
  const auto size = size_of_file(path);
  if (!size) return tl::unexpected(size.error());
  auto tiff = open_tiff(path);
  if (!tiff) return damaged(path.string());
  // Pages are a chain; a chain of directories in a file of this size cannot be longer than:
  const uint64_t most = *size / 8 + 1;
  std::vector<uint64_t> offsets;
  do {
    offsets.push_back(TIFFCurrentDirOffset(tiff.get()));
  } while (offsets.size() < most && TIFFReadDirectory(tiff.get()));
  tiff = open_tiff(path);
  if (!tiff) return damaged(path.string());
  return open_stack(path, tiff.get(), {path}, std::move(offsets), options);
}

Result<OpenVolume> open_tiff_folder(const std::filesystem::path& path,
                                    const ImportOptions& options) {
  auto files = files_of_folder(path, {".tif", ".tiff"});
  if (files.empty()) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected TIFF slices, found none", path.string()));
  }
  if (files.size() == 1) return open_tiff_file(files[0], options);
  const auto size = size_of_file(files[0]);
  if (!size) return tl::unexpected(size.error());
  const auto tiff = open_tiff(files[0]);
  if (!tiff) return damaged(files[0].string());
  return open_stack(path, tiff.get(), std::move(files), {}, options);
}

}  // namespace isosplat
