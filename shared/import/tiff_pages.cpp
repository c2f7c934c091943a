#include "shared/import/tiff_pages.h"

#include <fmt/format.h>

#include <set>

#include "shared/import/header_text.h"
#include "shared/import/tiff_directory.h"

namespace isosplat {
namespace {

constexpr uint16_t kSubfileType = 254, kOldSubfileType = 255, kNoData = 42113;

/// Whether a page is a smaller copy or a mask of another.
bool is_copy(TiffDirectoryReader& reader, const TiffDirectory& directory) {
  if (const TiffEntry* type = directory.find(kSubfileType)) {
    return (reader.number(*type).value_or(0) & 5) != 0;
  }
  const TiffEntry* type = directory.find(kOldSubfileType);
  return type && reader.number(*type) == 2;
}

}  // namespace

Result<TiffPages> find_tiff_pages(const std::filesystem::path& path) {
  auto reader = TiffDirectoryReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  TiffPages pages;
  pages.big_endian = reader->big_endian();
  std::set<uint64_t> seen;
  auto next = reader->first();
  while (next && *next != 0) {
    const uint64_t at = *next;
    const auto directory = seen.insert(at).second ? reader->read(at) : std::nullopt;
    if (!directory) {
      next = std::nullopt;
      break;
    }
    next = directory->next;
    const TiffEntry* no_data = directory->find(kNoData);
    if (no_data && pages.offsets.empty()) {
      pages.no_data = number_in(trimmed(reader->text(*no_data, 256)));
    }
    if (is_copy(*reader, *directory)) {
      ++pages.left_out;
    } else {
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

}  // namespace isosplat
