#include "shared/import/tiff/pages.h"

#include <fmt/format.h>

#include <set>

#include "shared/import/text/header_text.h"
#include "shared/import/tiff/directory.h"

namespace isosplat::import {
namespace {

enum Tag : uint16_t {
  kSubfileType = 254,
  kOldSubfileType = 255,
  kWidth = 256,
  kHeight = 257,
  kBits = 258,
  kDescription = 270,
  kStripOffsets = 273,
  kSamples = 277,
  kStripBytes = 279,
  kTileOffsets = 324,
  kTileBytes = 325,
  kSampleFormat = 339,
  kDepth = 32997,
  kUic1 = 33628,
  kLsm = 34412,
  kGdalMetadata = 42112,
  kNoData = 42113,
};

/// Whether a page is a smaller copy or a mask of another.
bool is_copy(TiffDirectoryReader& reader, const TiffDirectory& directory) {
  if (const TiffEntry* type = directory.find(kSubfileType)) {
    return (reader.number(*type).value_or(0) & 5) != 0;
  }
  const TiffEntry* type = directory.find(kOldSubfileType);
  return type && reader.number(*type) == 2;
}

/// The number of strips or tiles of a page that have neither an offset nor a size. `budget`: the
/// maximum number of values to read, for all pages.
size_t left_out_parts(TiffDirectoryReader& reader, const TiffDirectory& directory,
                      uint64_t& budget) {
  const TiffEntry* sizes = directory.find(kTileBytes);
  const TiffEntry* offsets = directory.find(kTileOffsets);
  if (!sizes) sizes = directory.find(kStripBytes);
  if (!offsets) offsets = directory.find(kStripOffsets);
  if (!sizes || !offsets) return 0;
  const std::vector<uint64_t> each = reader.numbers(*sizes, budget);
  budget -= each.size();
  size_t count = 0;
  for (size_t i = 0; i < each.size(); ++i) {
    if (each[i] == 0 && reader.number(*offsets, i) == 0) ++count;
  }
  return count;
}

std::optional<TiffEntry> entry_of(const TiffDirectory& directory, uint16_t tag) {
  const TiffEntry* entry = directory.find(tag);
  return entry ? std::optional(*entry) : std::nullopt;
}

TiffPageEntry describe(TiffDirectoryReader& reader, const TiffDirectory& directory) {
  const auto number = [&](uint16_t tag, uint64_t otherwise) {
    const TiffEntry* entry = directory.find(tag);
    return entry ? reader.number(*entry).value_or(otherwise) : otherwise;
  };
  return {{number(kWidth, 0), number(kHeight, 0), number(kDepth, 1), number(kBits, 1),
           number(kSampleFormat, 1), number(kSamples, 1)},
          entry_of(directory, kDescription)};
}

void read_first(TiffDirectoryReader& reader, const TiffDirectory& directory, TiffPages& pages) {
  if (const TiffEntry* no_data = directory.find(kNoData)) {
    pages.no_data = number_in(trimmed(reader.text(*no_data, 256)));
  }
  if (const TiffEntry* metadata = directory.find(kGdalMetadata)) {
    pages.gdal_metadata = reader.text(*metadata, 1 << 20);
  }
  std::optional<TiffEntry>* const uic[] = {&pages.uic1, &pages.uic2, &pages.uic3, &pages.uic4};
  for (uint16_t i = 0; i < 4; ++i) {
    *uic[i] = entry_of(directory, static_cast<uint16_t>(kUic1 + i));
  }
  pages.lsm = entry_of(directory, kLsm);
}

}  // namespace

Result<TiffPages> find_tiff_pages(const std::filesystem::path& path) {
  auto reader = TiffDirectoryReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  TiffPages pages;
  pages.big_endian = reader->big_endian();
  std::set<uint64_t> seen;
  uint64_t budget = uint64_t{1} << 26;
  auto next = reader->first();
  while (next && *next != 0) {
    const uint64_t at = *next;
    const auto directory = seen.insert(at).second ? reader->read(at) : std::nullopt;
    if (!directory) {
      next = std::nullopt;
      break;
    }
    next = directory->next;
    pages.chain.push_back(at);
    if (pages.offsets.empty()) read_first(*reader, *directory, pages);
    if (is_copy(*reader, *directory)) {
      ++pages.left_out;
    } else {
      pages.left_out_parts += left_out_parts(*reader, *directory, budget);
      pages.entries.push_back(describe(*reader, *directory));
      pages.offsets.push_back(at);
    }
  }
  pages.ends_early = !next;
  if (!pages.offsets.empty()) return pages;
  return fail(Status::malformed_volume,
              fmt::format("{}: expected TIFF pages, found no complete one: the file is damaged "
                          "or incomplete; copy or download it again",
                          path.string()));
}

}  // namespace isosplat::import
