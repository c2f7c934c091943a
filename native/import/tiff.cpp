#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "native/import/array_source.h"
#include "native/import/conventions.h"
#include "native/import/formats.h"
#include "native/import/header_text.h"
#include "native/import/slice_files.h"
#include "native/import/slice_order.h"
#include "native/import/tiff_pages.h"

// TIFF stacks: a file with a page per slice, or a folder with a file per slice. libtiff decodes the
// pages; which of them are slices is found here.
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
  VoxelType type = VoxelType::u8;
  int samples = 1;
  bool white_is_zero = false;
  bool palette = false;
  uint16_t orientation = ORIENTATION_TOPLEFT;
  std::string unknown;  ///< why the type is none of VoxelType; empty: it is one

  bool same_kind(const Page& other) const {
    return width == other.width && height == other.height && type == other.type &&
           samples == other.samples && white_is_zero == other.white_is_zero &&
           orientation == other.orientation && unknown == other.unknown;
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

tl::unexpected<Error> damaged(const std::string& where) {
  return fail(Status::malformed_volume,
              fmt::format("{}: its voxels cannot be decoded: the TIFF file is damaged or "
                          "incomplete; copy or download it again",
                          where));
}

/// Reads the current page, which is of the given kind, into `out`: rows from the top. libtiff has
/// brought the bytes into this machine's order.
bool read_page(TIFF* tiff, const Page& page, std::span<std::byte> out) {
  const size_t row = static_cast<size_t>(page.width) * voxel_bytes(page.type);
  std::vector<std::byte> buffer;
  if (TIFFIsTiled(tiff)) {
    uint32_t tile_width = 0, tile_height = 0;
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
    const uint64_t bytes = TIFFTileSize64(tiff);
    const size_t tile_row = tile_width * voxel_bytes(page.type);
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

/// Whether all strips or tiles of the current page lie inside of the file.
bool is_whole(TIFF* tiff, uint64_t file_bytes) {
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

/// Unsigned voxels stored with 0 as white are shown as they look: inverted.
void invert(std::span<std::byte> bytes) {
  for (std::byte& b : bytes) b = ~b;
}

bool is_unsigned(VoxelType type) {
  return type == VoxelType::u8 || type == VoxelType::u16 || type == VoxelType::u32 ||
         type == VoxelType::u64;
}

void reverse_columns(std::span<std::byte> row, size_t voxel) {
  for (size_t a = 0, b = row.size() - voxel; a < b; a += voxel, b -= voxel) {
    std::swap_ranges(row.data() + a, row.data() + a + voxel, row.data() + b);
  }
}

/// Brings rows and columns into the order of a page whose first pixel is at the top left.
void turn(uint16_t orientation, size_t row_bytes, size_t voxel, std::span<std::byte> slice) {
  if (orientation == ORIENTATION_BOTLEFT || orientation == ORIENTATION_BOTRIGHT) {
    reverse_rows(slice, row_bytes);
  }
  if (orientation == ORIENTATION_TOPRIGHT || orientation == ORIENTATION_BOTRIGHT) {
    for (size_t at = 0; at < slice.size(); at += row_bytes) {
      reverse_columns(slice.subspan(at, row_bytes), voxel);
    }
  }
}

/// Where a slice is. An empty path: nowhere, it is filled.
struct Slice {
  std::filesystem::path path;
  uint64_t page = 0;  ///< offset of the page's directory
};

class TiffSource : public VolumeSource {
 public:
  TiffSource(VolumeHeader header, Page page, std::vector<Slice> slices)
      : header_(std::move(header)), page_(std::move(page)), slices_(std::move(slices)) {}

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const size_t pixels = static_cast<size_t>(page_.width) * static_cast<size_t>(page_.height);
    const size_t slice = pixels * voxel_bytes(header_.type);
    if (first < 0 || count < 1 || int64_t{first} + count > header_.grid.voxels.z ||
        out.size() != slice * static_cast<size_t>(count)) {
      return fail(Status::invalid_argument, "slices outside the volume were asked for");
    }
    const size_t voxel = voxel_bytes(page_.type);
    for (int32_t i = 0; i < count; ++i) {
      auto to = out.subspan(static_cast<size_t>(i) * slice, slice);
      const Slice& from = slices_[static_cast<size_t>(first + i)];
      if (from.path.empty()) {
        fill(to);
        continue;
      }
      if (auto read = read_slice(from, to); !read) return read;
      if (page_.white_is_zero && is_unsigned(page_.type)) invert(to);
      turn(page_.orientation, static_cast<size_t>(page_.width) * voxel, voxel, to);
    }
    return {};
  }

  uint64_t resident_bytes() const override { return 0; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    for (const Slice& slice : slices_) {
      if (!slice.path.empty() && (files.empty() || files.back() != slice.path)) {
        files.push_back(slice.path);
      }
    }
    return files;
  }

 private:
  void fill(std::span<std::byte> out) const {
    const auto each = [&]<class T>(T value) {
      for (size_t at = 0; at < out.size(); at += sizeof(T)) {
        std::memcpy(out.data() + at, &value, sizeof(T));
      }
    };
    if (header_.type == VoxelType::f32) return each(std::numeric_limits<float>::quiet_NaN());
    if (header_.type == VoxelType::f64) return each(std::numeric_limits<double>::quiet_NaN());
    std::ranges::fill(out, std::byte{0});
  }

  Result<void> read_slice(const Slice& slice, std::span<std::byte> out) {
    if (!open_ || open_path_ != slice.path) {
      open_ = open_tiff(slice.path);
      open_path_ = slice.path;
    }
    const std::string where = fmt::format("{}, page at byte {}", slice.path.string(), slice.page);
    if (!open_ || !TIFFSetSubDirectory(open_.get(), slice.page)) return damaged(where);
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
  std::vector<Slice> slices_;
  TiffHandle open_{nullptr, &TIFFClose};
  std::filesystem::path open_path_;
};

/// A page's size along an axis in the unit of its resolution (ImageJ counts in that unit as well).
double pixel_size(TIFF* tiff, uint32_t tag) {
  float resolution = 0;
  if (!TIFFGetField(tiff, tag, &resolution) || !(resolution > 0)) return 1;
  return 1 / static_cast<double>(resolution);
}

std::string description_of(TIFF* tiff) {
  const char* text = nullptr;
  if (!TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) || !text) return {};
  return text;
}

HeaderGeometry geometry_of(TIFF* first, const TiffDescription& description,
                           const ImportOptions& options, std::vector<std::string>& notes) {
  HeaderGeometry geometry;
  if (options.spacing) {
    geometry.spacing = *options.spacing;
  } else if (description.voxel || description.between_slices) {
    geometry.spacing = description.voxel ? *description.voxel
                                         : Vec3d{pixel_size(first, TIFFTAG_XRESOLUTION),
                                                 pixel_size(first, TIFFTAG_YRESOLUTION),
                                                 *description.between_slices};
    if (!lower_case(description.unit).starts_with("pixel")) {
      to_millimetres(description.unit, geometry, notes);
    }
  } else {
    notes.push_back(
        "TIFF does not say how far apart the slices are: spacing 1,1,1 is taken; --spacing sets "
        "another");
  }
  return geometry;
}

Result<void> check_page(const std::filesystem::path& path, const Page& page,
                        std::vector<std::string>& notes) {
  if (page.palette) {
    return fail(Status::unsupported_type,
                fmt::format("{}: expected grey values, found a colour palette: convert the stack "
                            "to grey",
                            path.string()));
  }
  if (page.samples != 1) return not_scalar(path, page.samples);
  if (!page.unknown.empty()) return unknown_type(path, page.unknown);
  if (page.orientation < ORIENTATION_TOPLEFT || page.orientation > ORIENTATION_BOTLEFT) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected rows along x (TIFF orientation 1 to 4), found {}: rotate "
                            "the stack",
                            path.string(), page.orientation));
  }
  if (page.white_is_zero) {
    notes.push_back(
        is_unsigned(page.type)
            ? "the file stores 0 as white: its values are inverted"
            : "the file stores 0 as white, which has no meaning for voxels with a sign: "
              "its values are taken as they are");
  }
  return {};
}

Result<OpenVolume> make_stack(const std::filesystem::path& path, const Page& page,
                              const HeaderGeometry& geometry, std::vector<Slice> slices,
                              std::vector<std::string> notes) {
  auto orientation =
      orient({page.width, page.height, static_cast<int64_t>(slices.size())}, geometry);
  if (!orientation) {
    return fail(orientation.error().status, path.string() + ": " + orientation.error().message);
  }
  for (std::string& note : orientation->notes) notes.push_back(std::move(note));
  VolumeHeader header{orientation->grid, page.type, "TIFF", volume_name(path)};
  return OpenVolume{std::make_unique<TiffSource>(std::move(header), page, std::move(slices)),
                    std::move(notes)};
}

/// The pages of a file and its first one, open.
struct OpenFile {
  TiffPages pages;
  TiffHandle tiff{nullptr, &TIFFClose};
};

Result<OpenFile> open_pages(const std::filesystem::path& path, Allowances allowed,
                            std::vector<std::string>& notes) {
  auto pages = find_tiff_pages(path);
  if (!pages) return tl::unexpected(pages.error());
  if (pages->ends_early) {
    if (!allowed.has(Allowance::truncated)) {
      return fail(
          Status::truncated,
          fmt::format("{}: after {} pages the file ends where another is announced: it is "
                      "incomplete; copy or download it again, or read what is there with {}",
                      path.string(), pages->offsets.size(), flag_of(Allowance::truncated)));
    }
    notes.push_back(fmt::format("{} ends after {} pages where another is announced",
                                path.filename().string(), pages->offsets.size()));
  }
  if (pages->left_out > 0) {
    notes.push_back(fmt::format("{} pages are smaller copies or masks of others: they are left out",
                                pages->left_out));
  }
  OpenFile file;
  file.tiff = open_tiff(path);
  if (!file.tiff || !TIFFSetSubDirectory(file.tiff.get(), pages->offsets[0])) {
    return damaged(path.string());
  }
  file.pages = std::move(*pages);
  return file;
}

/// ImageJ writes stacks of more than 4 GB as one page that the others follow, as bare voxels.
Result<OpenVolume> open_bare_stack(const std::filesystem::path& path, const OpenFile& file,
                                   const Page& page, const TiffDescription& description,
                                   uint64_t step, const HeaderGeometry& geometry,
                                   const ImportOptions& options, std::vector<std::string> notes) {
  uint64_t* offsets = nullptr;
  uint16_t compression = COMPRESSION_NONE;
  TIFFGetFieldDefaulted(file.tiff.get(), TIFFTAG_COMPRESSION, &compression);
  if (compression != COMPRESSION_NONE || TIFFIsTiled(file.tiff.get()) || page.white_is_zero ||
      page.orientation != ORIENTATION_TOPLEFT ||
      !TIFFGetField(file.tiff.get(), TIFFTAG_STRIPOFFSETS, &offsets)) {
    return fail(Status::truncated,
                fmt::format("{}: expected {} pages, found one: the file is incomplete, or its "
                            "description is wrong",
                            path.string(), *description.images));
  }
  ArrayVolume array =
      make_array("TIFF", path, {page.width, page.height, static_cast<int64_t>(description.slices)},
                 geometry, options);
  array.stored.type = page.type;
  array.stored.big_endian = file.pages.big_endian;
  array.offset = offsets[0];
  array.steps = description.frames;
  array.step = step;
  array.step_axis = description.frames_before_slices ? 2 : 3;
  array.ends_with_file = false;
  auto bytes = open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace

Result<OpenVolume> open_tiff_file(const std::filesystem::path& path, const ImportOptions& options) {
  std::vector<std::string> notes;
  auto file = open_pages(path, options.allowed, notes);
  if (!file) return tl::unexpected(file.error());
  TIFF* tiff = file->tiff.get();
  const auto file_bytes = size_of_file(path);
  if (!file_bytes) return tl::unexpected(file_bytes.error());
  // Values of the first page's directory, sizes among them, may lie where its voxels do.
  if (!is_whole(tiff, *file_bytes)) return damaged(path.string());
  const Page page = describe(tiff);
  if (auto fine = check_page(path, page, notes); !fine) return tl::unexpected(fine.error());
  auto parsed = parse_tiff_description(path, description_of(tiff));
  if (!parsed) return tl::unexpected(parsed.error());
  TiffDescription& description = *parsed;
  const uint64_t found = file->pages.offsets.size();
  if (!description.images) {
    description.slices = found;
    description.channels = description.frames = 1;
    description.images = found;
  }
  if (description.channels > 1) {
    return not_scalar(path, static_cast<int>(std::min<uint64_t>(description.channels, 1000)));
  }
  const auto step = choose_step(path, static_cast<int64_t>(description.frames), options);
  if (!step) return tl::unexpected(step.error());
  if (description.slices < 2 && description.frames > 1) {
    return fail(Status::no_cells,
                fmt::format("{}: expected slices, found one slice at {} times: if the times are "
                            "slices, say so in ImageJ (Image > Properties)",
                            path.string(), description.frames));
  }
  const HeaderGeometry geometry = geometry_of(tiff, description, options, notes);
  if (found == 1 && *description.images > 1 && description.is_imagej && !file->pages.ends_early) {
    return open_bare_stack(path, *file, page, description, *step, geometry, options,
                           std::move(notes));
  }
  if (found != *description.images) {
    const bool fewer = found < *description.images;
    const Allowance needed = fewer ? Allowance::truncated : Allowance::surplus;
    const auto text = fmt::format("{}: expected {} pages by its description, found {}",
                                  path.string(), *description.images, found);
    if (!options.allowed.has(needed)) {
      return fail(fewer ? Status::truncated : Status::malformed_volume,
                  fmt::format("{}: the file is incomplete, or its description is wrong; read it as "
                              "it is with {}",
                              text, flag_of(needed)));
    }
    notes.push_back(text + (fewer ? ": the others are filled" : ": the surplus is left out"));
  }
  std::vector<Slice> slices(description.slices);
  size_t missing = 0;
  for (uint64_t z = 0; z < description.slices; ++z) {
    const uint64_t index = description.frames_before_slices ? z * description.frames + *step
                                                            : *step * description.slices + z;
    if (index >= found) continue;
    if (options.allowed.has(Allowance::truncated) &&
        (!TIFFSetSubDirectory(tiff, file->pages.offsets[index]) || !is_whole(tiff, *file_bytes))) {
      ++missing;
      continue;
    }
    slices[z] = {path, file->pages.offsets[index]};
  }
  if (missing > 0) {
    notes.push_back(fmt::format("{} pages are not whole: they are filled", missing));
  }
  auto volume = make_stack(path, page, geometry, std::move(slices), std::move(notes));
  if (volume) volume->fill_value = file->pages.no_data;
  return volume;
}

Result<OpenVolume> open_tiff_folder(const std::filesystem::path& path,
                                    const ImportOptions& options) {
  auto files = files_of_folder(path, {".tif", ".tiff"});
  if (files.empty()) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected TIFF slices, found none", path.string()));
  }
  if (files.size() == 1) return open_tiff_file(files[0], options);
  if (options.time_step.value_or(0) != 0) {
    return fail(Status::invalid_argument,
                fmt::format("{}: a folder of TIFF slices has no time steps: leave --time-step away",
                            path.string()));
  }
  auto order = order_slices(path, std::move(files), options.allowed);
  if (!order) return tl::unexpected(order.error());
  std::vector<std::string> notes = std::move(order->notes);
  std::vector<Slice> slices;
  std::optional<double> no_data;
  const std::filesystem::path* first = nullptr;
  for (const std::filesystem::path& file : order->slices) {
    slices.push_back({file, 0});
    if (file.empty()) continue;
    auto pages = find_tiff_pages(file);
    if (!pages) return tl::unexpected(pages.error());
    if (pages->offsets.size() > 1 || pages->ends_early) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected one page in each file of a folder, found {}: give the "
                              "file itself, or leave files of one page alone in the folder",
                              file.string(), pages->offsets.size()));
    }
    slices.back().page = pages->offsets[0];
    if (!first) first = &file, no_data = pages->no_data;
  }
  const auto tiff = open_tiff(*first);
  if (!tiff || !TIFFSetSubDirectory(tiff.get(), slices[0].page)) return damaged(first->string());
  const Page page = describe(tiff.get());
  if (auto fine = check_page(*first, page, notes); !fine) return tl::unexpected(fine.error());
  auto description = parse_tiff_description(*first, description_of(tiff.get()));
  if (!description) return tl::unexpected(description.error());
  const HeaderGeometry geometry = geometry_of(tiff.get(), *description, options, notes);
  auto volume = make_stack(path, page, geometry, std::move(slices), std::move(notes));
  if (volume) volume->fill_value = no_data;
  return volume;
}

}  // namespace isosplat
