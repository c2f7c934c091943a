#include "shared/import/codecs/zip_directory.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "shared/import/codecs/deflated_reader.h"

// The end of an archive:
//
// directory   of each file: "PK\1\2", fields of 46 bytes, its name, extra fields, a comment
//             "PK\6\6" and 52 more bytes: the directory with 64-bit numbers, if it is large
//             "PK\6\7" and 16 more bytes: where that is
// end         "PK\5\6" and 18 more bytes, and a comment
namespace isosplat::import {
namespace {

constexpr uint64_t kEndBytes = 22, kMaxComment = 65'535, kEntryBytes = 46, kLocalBytes = 30;
constexpr uint64_t kMaxMembers = 100'000, kMaxDirectory = uint64_t{64} << 20;

/// Little-endian fields of a text; zeros beyond its end.
uint64_t field(std::string_view bytes, size_t at, size_t size) {
  uint64_t value = 0;
  for (size_t i = size; i-- > 0;) {
    value = value << 8 | (at + i < bytes.size() ? static_cast<uint8_t>(bytes[at + i]) : 0u);
  }
  return value;
}

Result<std::string> read(ByteReader& file, uint64_t offset, uint64_t size) {
  std::string bytes(static_cast<size_t>(size), '\0');
  auto done = file.read(offset, std::as_writable_bytes(std::span(bytes)));
  if (!done) return tl::unexpected(done.error());
  return bytes;
}

tl::unexpected<Error> malformed(const std::filesystem::path& path, const char* what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the ZIP archive is damaged; copy or download it again",
                          path.string(), what));
}

/// Bytes of a file from `begin` on.
class PartReader : public ByteReader {
 public:
  PartReader(std::unique_ptr<ByteReader> file, uint64_t begin, uint64_t size)
      : file_(std::move(file)), begin_(begin), size_(size) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (offset > size_ || out.size() > size_ - offset) {
      return fail(Status::truncated,
                  fmt::format("{}: expected at least {} bytes of a file in the archive, found {}: "
                              "the archive is damaged; copy or download it again",
                              file_->files().front().string(), offset + out.size(), size_));
    }
    return file_->read(begin_ + offset, out);
  }
  bool is_random_access() const override { return true; }
  uint64_t size_limit() const override { return size_; }
  Result<uint64_t> count_after(uint64_t offset, uint64_t most) override {
    return std::min(most, size_ - std::min(size_, offset));
  }
  uint64_t available_bytes() override { return size_; }
  std::vector<std::filesystem::path> files() const override { return file_->files(); }

 private:
  std::unique_ptr<ByteReader> file_;
  uint64_t begin_, size_;
};

/// Replaces numbers that are all ones by the 64-bit ones of the extra field 1.
void widen(std::string_view extra, ZipMember& member) {
  for (size_t at = 0; at + 4 <= extra.size(); at += 4 + field(extra, at + 2, 2)) {
    if (field(extra, at, 2) != 1) continue;
    size_t next = at + 4;
    for (uint64_t* const number : {&member.bytes, &member.stored_bytes, &member.header}) {
      if (*number != 0xffffffff) continue;
      *number = field(extra, next, 8);
      next += 8;
    }
    return;
  }
}

}  // namespace

Result<std::vector<ZipMember>> read_zip_directory(const std::filesystem::path& path) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  const uint64_t size = (*file)->size_limit();
  const uint64_t tail = std::min(size, kEndBytes + kMaxComment);
  const auto end = read(**file, size - tail, tail);
  if (!end) return tl::unexpected(end.error());
  const size_t at = end->rfind("PK\5\6");
  if (at == end->npos || at + kEndBytes > end->size()) {
    return fail(Status::truncated,
                fmt::format("{}: expected the directory of a ZIP archive at its end, found none: "
                            "the file is incomplete; copy or download it again",
                            path.string()));
  }
  uint64_t count = field(*end, at + 10, 2), bytes = field(*end, at + 12, 4);
  uint64_t begin = field(*end, at + 16, 4);
  if (count == 0xffff || bytes == 0xffffffff || begin == 0xffffffff) {
    const uint64_t end_at = size - tail + at;
    const auto locator = read(**file, end_at - std::min<uint64_t>(end_at, 20), 20);
    if (!locator) return tl::unexpected(locator.error());
    if (!locator->starts_with("PK\6\7")) return malformed(path, "expected a 64-bit directory");
    const auto wide = read(**file, field(*locator, 8, 8), 56);
    if (!wide) return tl::unexpected(wide.error());
    if (!wide->starts_with("PK\6\6")) return malformed(path, "expected a 64-bit directory");
    count = field(*wide, 32, 8);
    bytes = field(*wide, 40, 8);
    begin = field(*wide, 48, 8);
  }
  if (count > kMaxMembers || bytes > kMaxDirectory) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected an archive of at most {} files, found {}: unpack it",
                            path.string(), kMaxMembers, count));
  }
  if (begin > size || bytes > size - begin) return malformed(path, "expected a directory inside");
  const auto directory = read(**file, begin, bytes);
  if (!directory) return tl::unexpected(directory.error());
  std::vector<ZipMember> members;
  std::string_view rest = *directory;
  for (uint64_t i = 0; i < count; ++i) {
    if (rest.size() < kEntryBytes || !rest.starts_with("PK\1\2")) {
      return malformed(path, "expected as many files in the directory as its end says");
    }
    const uint64_t name = field(rest, 28, 2), extra = field(rest, 30, 2);
    const uint64_t entry = kEntryBytes + name + extra + field(rest, 32, 2);
    if (entry > rest.size()) return malformed(path, "expected whole entries of the directory");
    ZipMember member;
    member.is_encrypted = (field(rest, 8, 2) & 1) != 0;
    member.method = static_cast<uint16_t>(field(rest, 10, 2));
    member.stored_bytes = field(rest, 20, 4);
    member.bytes = field(rest, 24, 4);
    member.header = field(rest, 42, 4);
    member.name = rest.substr(kEntryBytes, static_cast<size_t>(name));
    // Messages are one line.
    std::replace_if(
        member.name.begin(), member.name.end(), [](unsigned char c) { return c < ' '; }, '?');
    widen(rest.substr(static_cast<size_t>(kEntryBytes + name), static_cast<size_t>(extra)), member);
    members.push_back(std::move(member));
    rest.remove_prefix(static_cast<size_t>(entry));
  }
  return members;
}

Result<std::unique_ptr<ByteReader>> open_zip_member(const std::filesystem::path& path,
                                                    const ZipMember& member) {
  if (member.is_encrypted || (member.method != 0 && member.method != 8)) {
    return fail(
        Status::unsupported_format,
        fmt::format("{}: expected {} to be stored or deflated, found {}: unpack the archive",
                    path.string(), member.name,
                    member.is_encrypted ? "encryption" : "another compression"));
  }
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  const auto local = read(**file, member.header, kLocalBytes);
  if (!local) return tl::unexpected(local.error());
  if (!local->starts_with("PK\3\4")) return malformed(path, "expected the header of a file");
  const uint64_t begin = member.header + kLocalBytes + field(*local, 26, 2) + field(*local, 28, 2);
  const uint64_t size = (*file)->size_limit();
  if (begin > size || member.stored_bytes > size - begin ||
      (member.method == 0 && member.stored_bytes != member.bytes)) {
    return malformed(path, "expected the bytes of a file");
  }
  if (member.method == 8) return open_deflated(path, begin, Deflate::raw);
  return std::make_unique<PartReader>(std::move(*file), begin, member.bytes);
}

}  // namespace isosplat::import
