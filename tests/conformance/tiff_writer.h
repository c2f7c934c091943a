#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "tests/conformance/sample.h"

// Writes TIFF files for the generators, from the TIFF 6.0 specification.
namespace isosplat::conformance {

/// An entry of a directory.
struct Entry {
  uint16_t tag, type;
  uint32_t count;
  std::string value;
};

/// The contents of a page's directory.
struct Page {
  int width = 0, height = 0;
  Number type = Number::u8;
  bool white_is_zero = false;
  int orientation = 1;
  std::string description;
  double resolution = 0;
  std::string voxels;
  int bits = 0;                ///< 0: of the type
  int samples = 1;             ///< of a pixel, each in a separate strip
  int rows_per_strip = 0;      ///< 0: a random number. Ignored for several samples: one strip each
  std::vector<Entry> further;  ///< entries of other tags
  bool is_left_out = false;    ///< its strips are not written
};

inline int bits_of(const Page& page) {
  return page.bits > 0 ? page.bits : 8 * static_cast<int>(bytes_of(page.type));
}

inline int strip_count(const Page& page, int rows) {
  return (page.height + rows - 1) / rows * page.samples;
}

inline uint32_t row_bytes(const Page& page) {
  return static_cast<uint32_t>((page.width * bits_of(page) + 7) / 8);
}

/// The entries of a page's directory, with 0 for the strips' offsets (tag 273). `rows`: of each
/// strip.
inline std::vector<Entry> entries_of(const Page& page, int rows, bool big_endian) {
  std::vector<Entry> entries;
  const auto add_short = [&](uint16_t tag, int value) {
    std::string raw;
    put(raw, static_cast<uint16_t>(value), big_endian);
    entries.push_back({tag, 3, 1, raw + std::string(2, '\0')});
  };
  const auto add_long = [&](uint16_t tag, uint32_t value) {
    std::string raw;
    put(raw, value, big_endian);
    entries.push_back({tag, 4, 1, raw});
  };
  const bool is_float = page.type == Number::f32 || page.type == Number::f64;
  const bool is_signed = page.type == Number::i8 || page.type == Number::i16 ||
                         page.type == Number::i32 || page.type == Number::i64;
  const int strips = strip_count(page, rows);
  add_long(256, static_cast<uint32_t>(page.width));
  add_long(257, static_cast<uint32_t>(page.height));
  std::string bits;
  for (int i = 0; i < page.samples; ++i)
    put(bits, static_cast<uint16_t>(bits_of(page)), big_endian);
  if (bits.size() < 4) bits.resize(4);
  entries.push_back({258, 3, static_cast<uint32_t>(page.samples), bits});
  add_short(259, 1);
  add_short(262, page.white_is_zero ? 0 : 1);
  if (!page.description.empty()) {
    entries.push_back(
        {270, 2, static_cast<uint32_t>(page.description.size() + 1), page.description + '\0'});
  }
  const std::string offsets(4 * static_cast<size_t>(strips), '\0');
  entries.push_back({273, 4, static_cast<uint32_t>(strips), offsets});
  add_short(274, page.orientation);
  add_short(277, page.samples);
  add_long(278, static_cast<uint32_t>(rows));
  std::string counts;
  for (int i = 0; i < strips; ++i) {
    const int begin = i * rows % (page.samples > 1 ? page.height : page.height * 2);
    const auto bytes = static_cast<uint32_t>(std::min(rows, page.height - begin)) * row_bytes(page);
    put(counts, page.is_left_out ? 0 : bytes, big_endian);
  }
  entries.push_back({279, 4, static_cast<uint32_t>(strips), counts});
  if (page.resolution > 0) {
    std::string ratio;
    put(ratio, static_cast<uint32_t>(page.resolution * 1000), big_endian);
    put(ratio, uint32_t{1000}, big_endian);
    entries.push_back({282, 5, 1, ratio});
    entries.push_back({283, 5, 1, ratio});
  }
  if (page.samples > 1) add_short(284, 2);
  add_short(339, is_float ? 3 : is_signed ? 2 : 1);
  entries.insert(entries.end(), page.further.begin(), page.further.end());
  std::ranges::stable_sort(entries, {}, &Entry::tag);
  return entries;
}

/// The offset at which a directory and its values end. Values longer than four bytes follow the
/// directory.
inline size_t end_of_directory(size_t directory, const std::vector<Entry>& entries) {
  size_t end = directory + 2 + 12 * entries.size() + 4;
  for (const Entry& entry : entries) {
    if (entry.value.size() > 4) end += (entry.value.size() + 1) / 2 * 2;
  }
  return end;
}

/// Appends a directory and its values. Returns the offset of the link to the next directory.
inline size_t append_directory(const std::vector<Entry>& entries, bool big_endian,
                               std::string& out) {
  const size_t after_at = out.size() + 2 + 12 * entries.size() + 4;
  put(out, static_cast<uint16_t>(entries.size()), big_endian);
  std::string after;
  for (const Entry& entry : entries) {
    put(out, entry.tag, big_endian);
    put(out, entry.type, big_endian);
    put(out, entry.count, big_endian);
    if (entry.value.size() <= 4) {
      out += entry.value + std::string(4 - entry.value.size(), '\0');
    } else {
      put(out, static_cast<uint32_t>(after_at + after.size()), big_endian);
      after += entry.value;
      if (after.size() % 2) after.push_back('\0');
    }
  }
  const size_t link = out.size();
  put(out, uint32_t{0}, big_endian);
  out += after;
  return link;
}

/// A classic TIFF file. Directories are before or after their voxels.
inline std::string tiff_file(Random& random, const std::vector<Page>& pages, bool big_endian) {
  std::string out = big_endian ? "MM" : "II";
  put(out, uint16_t{42}, big_endian);
  const bool first = random.chance(50);
  size_t link = out.size();
  put(out, uint32_t{0}, big_endian);
  const auto append_voxels = [&](const Page& page) {
    out += page.voxels;
    if (out.size() % 2) out.push_back('\0');
  };
  for (const Page& page : pages) {
    const int rows = page.samples > 1          ? page.height
                     : page.rows_per_strip > 0 ? page.rows_per_strip
                     : random.chance(50)       ? page.height
                                               : random.between(1, page.height);
    size_t voxels_at = out.size();
    if (!first) append_voxels(page);
    std::vector<Entry> entries = entries_of(page, rows, big_endian);
    if (first) voxels_at = end_of_directory(out.size(), entries);
    std::string& offsets = std::ranges::find(entries, 273, &Entry::tag)->value;
    offsets.clear();
    for (int i = 0; i < strip_count(page, rows); ++i) {
      const uint32_t strip = static_cast<uint32_t>(i * rows) * row_bytes(page);
      put(offsets, page.is_left_out ? 0 : static_cast<uint32_t>(voxels_at) + strip, big_endian);
    }
    std::string directory;
    put(directory, static_cast<uint32_t>(out.size()), big_endian);
    out.replace(link, 4, directory);
    link = append_directory(entries, big_endian, out);
    if (first) append_voxels(page);
  }
  return out;
}

}  // namespace isosplat::conformance
