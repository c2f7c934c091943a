#include "shared/import/tiff_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "shared/import/byte_reader.h"
#include "shared/import/header_text.h"

//                 TIFF (42)              BigTIFF (43)
// header          II or MM, 42, u32      II or MM, 43, u16 8, u16 0, u64: the first directory
// directory       u16 n, n entries,      u64 n, n entries,
//                 u32 next               u64 next (0: the last)
// entry           u16 tag, u16 type,     u16 tag, u16 type,
//                 u32 count, 4 bytes     u64 count, 8 bytes: the values, or where they are
namespace isosplat {
namespace {

constexpr uint64_t kSubfileType = 254, kOldSubfileType = 255, kNoData = 42113;

class DirectoryReader {
 public:
  explicit DirectoryReader(std::unique_ptr<ByteReader> file) : file_(std::move(file)) {}

  Result<TiffPages> walk(const std::filesystem::path& path) {
    TiffPages pages;
    std::array<std::byte, 2> order{};
    if (auto read = file_->read(0, order); !read) return tl::unexpected(read.error());
    big_endian_ = pages.big_endian = order[0] == std::byte{'M'};
    const auto version = number(2, 2);
    big_tiff_ = version == 43;
    auto next = big_tiff_ ? number(8, 8) : number(4, 4);
    std::set<uint64_t> seen;
    while (next && *next != 0) {
      const uint64_t at = *next;
      const auto entries = number(at, big_tiff_ ? 8 : 2);
      const uint64_t first = at + (big_tiff_ ? 8 : 2), entry = big_tiff_ ? 20 : 12;
      if (!entries || *entries == 0 || *entries > 65536 || !seen.insert(at).second) {
        next = std::nullopt;
        break;
      }
      next = number(first + *entries * entry, big_tiff_ ? 8 : 4);
      if (!next) break;
      bool is_copy = false;
      for (uint64_t i = 0; i < *entries; ++i) {
        const uint64_t entry_offset = first + i * entry;
        if (!has_values(entry_offset)) {
          next = std::nullopt;
          break;
        }
        const auto tag = number(entry_offset, 2);
        if (tag == kSubfileType) is_copy = (value(entry_offset).value_or(0) & 5) != 0;
        if (tag == kOldSubfileType) is_copy = value(entry_offset) == 2;
        if (tag == kNoData && pages.offsets.empty())
          pages.no_data = number_in(trimmed(text(entry_offset)));
      }
      if (!next) break;
      if (is_copy) {
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

 private:
  /// An unsigned number of 2, 4 or 8 bytes. Nothing if the file ends first.
  std::optional<uint64_t> number(uint64_t at, size_t bytes) {
    std::array<std::byte, 8> raw{};
    const auto part = std::span(raw).first(bytes);
    if (at > file_->size_limit() || file_->size_limit() - at < bytes || !file_->read(at, part)) {
      return std::nullopt;
    }
    if (!big_endian_) std::reverse(part.begin(), part.end());
    uint64_t result = 0;
    for (const std::byte b : part) result = result << 8 | std::to_integer<uint64_t>(b);
    return result;
  }

  /// Whether the values of an entry are inside the file.
  bool has_values(uint64_t entry) {
    constexpr uint64_t kBytes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
    const auto type = number(entry + 2, 2), count = number(entry + 4, big_tiff_ ? 8 : 4);
    if (!type || !count) return false;
    const uint64_t each = *type < std::size(kBytes) ? kBytes[*type] : 0;
    if (each == 0) return true;  // an unknown type
    const uint64_t size = file_->size_limit(), room = big_tiff_ ? 8 : 4;
    if (*count > size / each) return false;
    if (*count * each <= room) return true;
    const auto at = number(entry + (big_tiff_ ? 12 : 8), big_tiff_ ? 8 : 4);
    return at && *at <= size && *count * each <= size - *at;
  }

  /// The value of an entry with one number of type SHORT or LONG.
  std::optional<uint64_t> value(uint64_t entry) {
    const auto type = number(entry + 2, 2);
    const uint64_t at = entry + (big_tiff_ ? 12 : 8);
    return number(at, type == 3 ? 2 : 4);
  }

  /// An entry of type ASCII.
  std::string text(uint64_t entry) {
    const auto count = number(entry + 4, big_tiff_ ? 8 : 4);
    const uint64_t field = entry + (big_tiff_ ? 12 : 8), room = big_tiff_ ? 8 : 4;
    if (!count || *count == 0 || *count > 256) return {};
    const auto at = *count <= room ? std::optional(field) : number(field, big_tiff_ ? 8 : 4);
    std::string found(static_cast<size_t>(*count), '\0');
    if (!at || *at > file_->size_limit() || file_->size_limit() - *at < *count ||
        !file_->read(*at, std::as_writable_bytes(std::span(found)))) {
      return {};
    }
    return found.c_str();
  }

  std::unique_ptr<ByteReader> file_;
  bool big_endian_ = false, big_tiff_ = false;
};

}  // namespace

Result<TiffPages> find_tiff_pages(const std::filesystem::path& path) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  return DirectoryReader(std::move(*file)).walk(path);
}

}  // namespace isosplat
