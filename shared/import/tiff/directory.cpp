#include "shared/import/tiff/directory.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <span>

//                 TIFF (42)              BigTIFF (43)
// header          II or MM, 42, u32      II or MM, 43, u16 8, u16 0, u64: the first directory
// directory       u16 n, n entries,      u64 n, n entries,
//                 u32 next               u64 next (0: the last)
// entry           u16 tag, u16 type,     u16 tag, u16 type,
//                 u32 count, 4 bytes     u64 count, 8 bytes: the values, or where they are
namespace isosplat::import {
namespace {

constexpr uint64_t kMaxEntries = 65536;

/// The size of a value in bytes; 0: the type is unknown.
size_t bytes_of_type(uint16_t type) {
  constexpr uint8_t kBytes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  return type < std::size(kBytes) ? kBytes[type] : 0;
}

constexpr uint16_t kByte = 1, kShort = 3, kLong = 4, kRational = 5, kFloat = 11, kDouble = 12,
                   kIfd = 13, kLong8 = 16, kIfd8 = 18;

/// std::bit_cast, which libc++ 13 lacks.
template <class To, class From>
To same_bits(From from) {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  std::memcpy(&to, &from, sizeof to);
  return to;
}

}  // namespace

const TiffEntry* TiffDirectory::find(uint16_t tag) const {
  const auto found = std::find_if(entries.begin(), entries.end(),
                                  [&](const TiffEntry& entry) { return entry.tag == tag; });
  return found == entries.end() ? nullptr : &*found;
}

Result<TiffDirectoryReader> TiffDirectoryReader::open(const std::filesystem::path& path) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  std::array<std::byte, 4> head{};
  if (auto read = (*file)->read(0, head); !read) return tl::unexpected(read.error());
  TiffDirectoryReader reader(std::move(*file));
  reader.big_endian_ = head[0] == std::byte{'M'};
  reader.version_ = static_cast<uint16_t>(reader.word_in(&head[2], 2));
  reader.big_tiff_ = reader.version_ == 43;
  return reader;
}

std::optional<uint64_t> TiffDirectoryReader::first() {
  return big_tiff_ ? word(8, 8) : word(4, 4);
}

std::optional<TiffDirectory> TiffDirectoryReader::read(uint64_t at) {
  const size_t pointer = big_tiff_ ? 8 : 4, entry_bytes = 4 + 2 * pointer;
  const auto count = word(at, big_tiff_ ? 8 : 2);
  if (!count || *count == 0 || *count > kMaxEntries) return std::nullopt;
  const uint64_t begin = at + (big_tiff_ ? 8 : 2);
  const size_t bytes = static_cast<size_t>(*count) * entry_bytes;
  if (!is_inside(begin, bytes + pointer)) return std::nullopt;
  std::vector<std::byte> raw(bytes + pointer);
  if (!file_->read(begin, raw)) return std::nullopt;
  TiffDirectory directory;
  directory.next = word_in(raw.data() + bytes, pointer);
  directory.entries.reserve(static_cast<size_t>(*count));
  for (size_t i = 0; i < bytes; i += entry_bytes) {
    const std::byte* from = raw.data() + i;
    TiffEntry entry{static_cast<uint16_t>(word_in(from, 2)),
                    static_cast<uint16_t>(word_in(from + 2, 2)), word_in(from + 4, pointer),
                    begin + i + 4 + pointer};
    if (const size_t each = bytes_of_type(entry.type); each > 0) {
      if (entry.count > file_bytes() / each) return std::nullopt;
      if (entry.count * each > pointer) entry.at = word_in(from + 4 + pointer, pointer);
      if (!is_inside(entry.at, entry.count * each)) return std::nullopt;
    }
    directory.entries.push_back(entry);
  }
  return directory;
}

std::optional<uint64_t> TiffDirectoryReader::number(const TiffEntry& entry, uint64_t index) {
  if (index >= entry.count) return std::nullopt;
  switch (entry.type) {
    case kByte:
    case kShort:
    case kLong:
    case kIfd:
    case kLong8:
    case kIfd8: {
      const size_t bytes = bytes_of_type(entry.type);
      return word(entry.at + index * bytes, bytes);
    }
    default:
      return std::nullopt;
  }
}

std::vector<uint64_t> TiffDirectoryReader::numbers(const TiffEntry& entry, uint64_t max_count) {
  if (entry.count > max_count || !number(entry)) return {};
  const size_t each = bytes_of_type(entry.type), count = static_cast<size_t>(entry.count);
  std::vector<std::byte> raw(count * each);
  if (!file_->read(entry.at, raw)) return {};
  std::vector<uint64_t> values(count);
  for (size_t i = 0; i < count; ++i) values[i] = word_in(raw.data() + i * each, each);
  return values;
}

std::optional<double> TiffDirectoryReader::real(const TiffEntry& entry) {
  if (entry.count == 0) return std::nullopt;
  if (entry.type == kRational) {
    const auto above = word(entry.at, 4), below = word(entry.at + 4, 4);
    if (!above || !below || *below == 0) return std::nullopt;
    return static_cast<double>(*above) / static_cast<double>(*below);
  }
  if (entry.type != kFloat && entry.type != kDouble) return number(entry);
  const auto bits = word(entry.at, entry.type == kFloat ? 4 : 8);
  if (!bits) return std::nullopt;
  if (entry.type == kDouble) return same_bits<double>(*bits);
  return same_bits<float>(static_cast<uint32_t>(*bits));
}

std::string TiffDirectoryReader::text(const TiffEntry& entry, uint64_t max_bytes) {
  if (bytes_of_type(entry.type) != 1 || entry.count > max_bytes) return {};
  std::string found(static_cast<size_t>(entry.count), '\0');
  if (!file_->read(entry.at, std::as_writable_bytes(std::span(found)))) return {};
  return found.c_str();
}

/// An unsigned number of 2, 4 or 8 bytes. Nothing if it is not inside the file.
std::optional<uint64_t> TiffDirectoryReader::word(uint64_t at, size_t bytes) {
  std::array<std::byte, 8> raw{};
  if (!is_inside(at, bytes) || !file_->read(at, std::span(raw).first(bytes))) return std::nullopt;
  return word_in(raw.data(), bytes);
}

uint64_t TiffDirectoryReader::word_in(const std::byte* from, size_t bytes) const {
  uint64_t result = 0;
  for (size_t i = 0; i < bytes; ++i) {
    result = result << 8 | std::to_integer<uint64_t>(from[big_endian_ ? i : bytes - 1 - i]);
  }
  return result;
}

bool TiffDirectoryReader::is_inside(uint64_t at, uint64_t bytes) const {
  return at <= file_bytes() && bytes <= file_bytes() - at;
}

}  // namespace isosplat::import
