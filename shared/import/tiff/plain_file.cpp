#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "shared/import/tiff/directory.h"
#include "shared/import/tiff/file.h"
#include "shared/import/tiff/predictor.h"
#include "shared/import/tiff/rows.h"

// A page's rows are in strips, each with some rows, or in tiles. Tiles at the right and lower edge
// are padded to their full size, while the last strip may have fewer rows. If the samples of a
// pixel are stored separately (PlanarConfiguration 2), the strips or tiles of the first sample
// precede those of the second. In a page with a depth (tag 32997), those of a slice precede those
// of the next one. Tiles may have a depth as well (32998), and then contain slices one after the
// other.
namespace isosplat::import {
namespace {

enum Tag : uint16_t {
  kWidth = 256,
  kHeight = 257,
  kBits = 258,
  kCompression = 259,
  kPhotometric = 262,
  kFillOrder = 266,
  kDescription = 270,
  kStripOffsets = 273,
  kOrientation = 274,
  kSamples = 277,
  kRowsPerStrip = 278,
  kStripBytes = 279,
  kResolutionX = 282,
  kResolutionY = 283,
  kPlanes = 284,
  kResolutionUnit = 296,
  kPredictor = 317,
  kTileWidth = 322,
  kTileHeight = 323,
  kTileOffsets = 324,
  kTileBytes = 325,
  kSampleFormat = 339,
  kDepth = 32997,
  kTileDepth = 32998,
};

constexpr uint64_t kMaxDescription = uint64_t{64} << 20;
constexpr uint64_t kMaxBytes = std::numeric_limits<uint64_t>::max() / 8;

uint64_t rounded_up(uint64_t count, uint64_t each) {
  return (count + each - 1) / each;
}

/// The layout of a page's rows.
struct Layout {
  uint64_t compression = 1, predictor = 1;
  bool reversed_bits = false;  ///< the first pixel is in the lowest bits
  bool tiled = false;
  uint64_t width = 0, height = 0, depth = 1;  ///< of the page
  /// Of a strip or tile.
  uint64_t part_width = 0, part_height = 0, part_depth = 1;
  TiffSamples stored;
  std::optional<TiffEntry> offsets, sizes;  ///< of strips or tiles

  uint64_t across() const { return rounded_up(width, part_width); }
  /// The number of parts of one slice and one sample.
  uint64_t parts() const { return across() * rounded_up(height, part_height); }
  uint64_t layers() const { return rounded_up(depth, part_depth); }
  uint64_t part_row() const { return stored.row_bytes(part_width); }
  /// Rows of a part of a slice, by its number in the slice.
  uint64_t rows_of(uint64_t part) const {
    return tiled ? part_height : std::min(part_height, height - part * part_height);
  }

  /// The size of an expanded strip or tile. Nothing if it exceeds any memory.
  std::optional<uint64_t> bytes_of(uint64_t part) const {
    const uint64_t row = part_row(), rows = rows_of(part);
    if (row > kMaxBytes / rows || row * rows > kMaxBytes / part_depth) return std::nullopt;
    return row * rows * part_depth;
  }
};

/// The location of a strip or tile in the file.
struct Range {
  uint64_t at = 0, bytes = 0;
  bool is_left_out = false;  ///< it was not written: sparse files of GDAL
};

class PlainTiffFile : public TiffFile {
 public:
  explicit PlainTiffFile(TiffDirectoryReader reader) : reader_(std::move(reader)) {}

  std::optional<TiffPage> go_to(uint64_t offset) override {
    auto directory = reader_.read(offset);
    if (!directory) return std::nullopt;
    directory_ = std::move(*directory);
    const auto width = number(kWidth), height = number(kHeight);
    if (!width || !height || *width == 0 || *height == 0) return std::nullopt;
    if (std::max(*width, *height) > std::numeric_limits<uint32_t>::max()) return std::nullopt;
    page_ = {};
    page_.width = static_cast<int64_t>(*width);
    page_.height = static_cast<int64_t>(*height);
    const uint64_t bits = number(kBits).value_or(1), format = number(kSampleFormat).value_or(1),
                   samples = number(kSamples).value_or(1);
    if (bits < 1 || bits > 0xffff || samples < 1) return std::nullopt;
    const uint64_t depth = number(kDepth).value_or(1);
    if (depth > std::numeric_limits<uint32_t>::max()) return std::nullopt;
    page_.depth = static_cast<int64_t>(std::max<uint64_t>(depth, 1));
    page_.samples = static_cast<int>(std::min<uint64_t>(samples, 0xffff));
    page_.separate_planes = number(kPlanes) == 2 && page_.samples > 1;
    set_voxel_type(static_cast<uint16_t>(bits), static_cast<uint16_t>(format <= 6 ? format : 1),
                   page_);
    page_.photometric =
        static_cast<uint16_t>(std::min<uint64_t>(number(kPhotometric).value_or(1), 0xffff));
    page_.resolution_unit =
        static_cast<uint16_t>(std::min<uint64_t>(number(kResolutionUnit).value_or(2), 0xffff));
    const uint64_t orientation = number(kOrientation).value_or(1);
    if (orientation >= 1 && orientation <= 8) {
      page_.orientation = static_cast<uint16_t>(orientation);
    }
    if (const TiffEntry* entry = directory_.find(kDescription)) {
      page_.description = reader_.text(*entry, kMaxDescription);
    }
    page_.pixels_per_unit_x = real(kResolutionX);
    page_.pixels_per_unit_y = real(kResolutionY);
    if (!find_layout()) return std::nullopt;
    if (TiffRows::max_expansion(layout_.compression) == 0) {
      page_.undecodable = TiffRows::describe(layout_.compression);
    } else if (layout_.compression == 1 && !layout_.tiled) {
      page_.uncompressed_at = reader_.number(*layout_.offsets);
    }
    return page_;
  }

  bool is_whole(uint64_t plane) override {
    const uint64_t parts = layout_.parts();
    const uint64_t samples = page_.separate_planes ? static_cast<uint64_t>(page_.samples) : 1;
    if (parts > layout_.offsets->count) return false;
    for (uint64_t sample = 0; sample < samples; ++sample) {
      for (uint64_t part = 0; part < parts; ++part) {
        if (!range_of(plane, sample, part)) return false;
      }
    }
    return true;
  }

  bool read(std::span<std::byte> out, TiffPart from) override {
    if (!knows_predictor(layout_.predictor, layout_.stored)) return false;
    if (from.sample < 0 || from.sample >= page_.samples) return false;
    const uint64_t parts = layout_.parts();
    const size_t voxel = voxel_bytes(page_.type);
    if (out.size() % layout_.height != 0 || out.size() / layout_.height != layout_.width * voxel) {
      return false;
    }
    const size_t row = static_cast<size_t>(layout_.width) * voxel;
    const auto part_row = static_cast<size_t>(layout_.part_row());
    const bool are_voxels = layout_.stored.are_voxels();
    // In a valid file, a tile exceeds the page by less than one tile in each direction.
    const auto most = layout_.bytes_of(0);
    const uint64_t per_voxel = uint64_t{layout_.stored.per_pixel} * layout_.part_depth;
    if (!most || *most > 4 * per_voxel * (out.size() + (uint64_t{1} << 20))) return false;
    for (uint64_t part = 0; part < parts; ++part) {
      const uint64_t x = part % layout_.across() * layout_.part_width,
                     y = part / layout_.across() * layout_.part_height;
      const auto rows = static_cast<size_t>(std::min(layout_.part_height, layout_.height - y));
      const auto columns = static_cast<size_t>(std::min(layout_.part_width, layout_.width - x));
      auto to = out.subspan(static_cast<size_t>(y) * row);
      if (!layout_.tiled && are_voxels && layout_.part_depth == 1) {
        if (!read_part(from, part, to.first(rows * row))) return false;
        continue;
      }
      part_.resize(static_cast<size_t>(*layout_.bytes_of(part)));
      if (!read_part(from, part, part_)) return false;
      const auto slice =
          static_cast<size_t>(layout_.depth > 1 ? from.plane % layout_.part_depth : 0) *
          static_cast<size_t>(layout_.rows_of(part));
      for (size_t r = 0; r < rows; ++r) {
        const auto stored = std::span(part_).subspan((slice + r) * part_row, part_row);
        const auto voxels = to.subspan(r * row + static_cast<size_t>(x) * voxel, columns * voxel);
        if (are_voxels) {
          std::memcpy(voxels.data(), stored.data(), voxels.size());
        } else {
          unpack_row(layout_.stored, page_.separate_planes ? 0 : static_cast<unsigned>(from.sample),
                     stored, page_.type, voxels);
        }
      }
    }
    return true;
  }

 private:
  std::optional<uint64_t> number(uint16_t tag) {
    const TiffEntry* entry = directory_.find(tag);
    return entry ? reader_.number(*entry) : std::nullopt;
  }

  std::optional<double> real(uint16_t tag) {
    const TiffEntry* entry = directory_.find(tag);
    const auto value = entry ? reader_.real(*entry) : std::nullopt;
    // libtiff keeps it as a 32-bit float; both implementations then give the same spacing.
    return value ? std::optional<double>(static_cast<float>(*value)) : std::nullopt;
  }

  /// False if the page has neither strips nor tiles.
  bool find_layout() {
    const auto entry = [&](uint16_t tag) {
      const TiffEntry* found = directory_.find(tag);
      return found ? std::optional(*found) : std::nullopt;
    };
    Layout layout;
    layout.compression = number(kCompression).value_or(1);
    // Other compressions have no predictor: libtiff ignores the tag.
    const bool predicts = layout.compression != 1 && layout.compression != 32773;
    layout.predictor = predicts ? number(kPredictor).value_or(1) : 1;
    layout.reversed_bits = number(kFillOrder) == 2;
    layout.width = static_cast<uint64_t>(page_.width);
    layout.height = static_cast<uint64_t>(page_.height);
    layout.depth = static_cast<uint64_t>(page_.depth);
    layout.stored = page_.stored;
    layout.tiled = directory_.find(kTileWidth) != nullptr;
    layout.offsets = entry(layout.tiled ? kTileOffsets : kStripOffsets);
    layout.sizes = entry(layout.tiled ? kTileBytes : kStripBytes);
    if (layout.tiled) {
      layout.part_width = number(kTileWidth).value_or(0);
      layout.part_height = number(kTileHeight).value_or(0);
      layout.part_depth = std::clamp<uint64_t>(number(kTileDepth).value_or(1), 1, layout.depth);
    } else {
      layout.part_width = layout.width;
      layout.part_height = std::min(number(kRowsPerStrip).value_or(layout.height), layout.height);
    }
    layout_ = layout;
    constexpr uint64_t kMostPixels = std::numeric_limits<uint32_t>::max();
    return layout.offsets && layout.part_width >= 1 && layout.part_height >= 1 &&
           layout.part_width <= kMostPixels && layout.part_height <= kMostPixels;
  }

  /// The index of a strip or tile in the lists of offsets and sizes, and the distance in bytes from
  /// there to the part of `plane`. If the lists have only the first plane, the other planes follow
  /// it.
  struct Place {
    uint64_t index = 0, shift = 0;
  };
  std::optional<Place> place_of(uint64_t plane, uint64_t sample, uint64_t part) {
    const uint64_t parts = layout_.parts(),
                   samples = page_.separate_planes ? static_cast<uint64_t>(page_.samples) : 1,
                   layers = layout_.depth > 1 ? layout_.layers() : plane + 1,
                   layer = layout_.depth > 1 ? plane / layout_.part_depth : plane;
    const uint64_t listed = layout_.offsets->count;
    if (parts > listed || layers > listed / parts || samples > listed / parts / layers) {
      if (plane == 0) return Place{sample * parts + part, 0};
      if (layout_.compression != 1 || layout_.part_depth > 1) return std::nullopt;
      const auto first = reader_.number(*layout_.offsets, 0),
                 last = reader_.number(*layout_.offsets, samples * parts - 1);
      const auto bytes = layout_.bytes_of(parts - 1);
      if (!first || !last || !bytes || *last < *first) return std::nullopt;
      const uint64_t step = *last - *first + *bytes;
      if (step > reader_.file_bytes() || plane > reader_.file_bytes() / step) return std::nullopt;
      return Place{sample * parts + part, plane * step};
    }
    return layout_.depth > 1 ? Place{(sample * layers + layer) * parts + part, 0}
                             : Place{(layer * samples + sample) * parts + part, 0};
  }

  /// Nothing if a strip or tile is not inside the file, or is too short for its rows.
  std::optional<Range> range_of(uint64_t plane, uint64_t sample, uint64_t part) {
    const auto place = place_of(plane, sample, part);
    const auto needed = layout_.bytes_of(part);
    if (!place || !needed) return std::nullopt;
    const auto listed = reader_.number(*layout_.offsets, place->index);
    constexpr uint64_t kNone = std::numeric_limits<uint64_t>::max();
    const uint64_t size =
        layout_.sizes ? reader_.number(*layout_.sizes, place->index).value_or(kNone) : kNone;
    if (listed == 0 && size == 0) return Range{0, 0, true};
    if (!listed || *listed == 0 || *listed > reader_.file_bytes()) return std::nullopt;
    const uint64_t at = *listed + place->shift;
    if (at > reader_.file_bytes()) return std::nullopt;
    const uint64_t rest = reader_.file_bytes() - at;
    if (layout_.compression == 1) {
      // libtiff ignores the sizes of uncompressed strips as well: they are often wrong.
      return *needed <= rest ? std::optional(Range{at, *needed}) : std::nullopt;
    }
    uint64_t bytes = size == kNone ? 0 : size;
    if (bytes == 0 && layout_.parts() == 1) bytes = rest;
    if (bytes > rest) return std::nullopt;
    const uint64_t expansion = TiffRows::max_expansion(layout_.compression);
    if (expansion > 0 && *needed / expansion > bytes) return std::nullopt;
    return Range{at, bytes};
  }

  /// Reads a strip or tile.
  bool read_part(TiffPart from, uint64_t part, std::span<std::byte> out) {
    const auto range =
        range_of(from.plane, page_.separate_planes ? static_cast<uint64_t>(from.sample) : 0, part);
    if (!range) return false;
    if (range->is_left_out) {
      fill_left_out(page_, out);
      return true;
    }
    if (layout_.compression == 1) {
      if (!reader_.file().read(range->at, out)) return false;
      if (layout_.reversed_bits) reverse_bits(out);
    } else {
      // Compressed rows are hardly longer than the rows, but the stored sizes can be wrong.
      raw_.resize(static_cast<size_t>(std::min<uint64_t>(range->bytes, out.size() * 10 + 4096)));
      const auto raw = std::as_writable_bytes(std::span(raw_));
      if (!reader_.file().read(range->at, raw)) return false;
      if (layout_.reversed_bits) reverse_bits(raw);
      const std::span rows(reinterpret_cast<uint8_t*>(out.data()), out.size());
      if (!rows_.expand(layout_.compression, raw_, rows)) return false;
    }
    undo_predictor(layout_.predictor, layout_.stored, reader_.big_endian(),
                   static_cast<size_t>(layout_.part_row()), out);
    return true;
  }

  static void reverse_bits(std::span<std::byte> bytes) {
    for (std::byte& b : bytes) {
      unsigned in = std::to_integer<unsigned>(b), out = 0;
      for (int i = 0; i < 8; ++i, in >>= 1) out = out << 1 | (in & 1);
      b = static_cast<std::byte>(out);
    }
  }

  TiffDirectoryReader reader_;
  TiffDirectory directory_;
  TiffPage page_;
  Layout layout_;
  TiffRows rows_;
  std::vector<uint8_t> raw_;
  std::vector<std::byte> part_;  ///< a strip or tile as stored
};

}  // namespace

std::unique_ptr<TiffFile> open_plain_tiff(const std::filesystem::path& path) {
  auto reader = TiffDirectoryReader::open(path);
  if (!reader || (reader->version() != 42 && reader->version() != 43)) return nullptr;
  return std::make_unique<PlainTiffFile>(std::move(*reader));
}

}  // namespace isosplat::import
