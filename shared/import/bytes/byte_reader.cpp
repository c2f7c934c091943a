#include "shared/import/bytes/byte_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "shared/import/bytes/readable_file.h"

namespace isosplat::import {
namespace {

class PlainReader : public ByteReader {
 public:
  explicit PlainReader(ReadableFile file) : file_(std::move(file)) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    const auto got = file_.input->read_some(offset, out);
    if (!got) return tl::unexpected(got.error());
    if (*got < out.size()) return file_.ends_early(offset + out.size(), offset + *got, "");
    return {};
  }

  bool is_random_access() const override { return true; }
  uint64_t size_limit() const override { return file_.size; }

  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override {
    return std::min(max_count, file_.size - std::min(file_.size, offset));
  }

  uint64_t available_bytes() override { return file_.size; }

  std::vector<std::filesystem::path> files() const override { return {file_.path}; }

 private:
  ReadableFile file_;
};

}  // namespace

Result<ReadableFile> ReadableFile::open(const std::filesystem::path& path) {
  const auto size = size_of_file(path);
  if (!size) return tl::unexpected(size.error());
  auto opened = open_input(path);
  if (!opened) return tl::unexpected(opened.error());
  return ReadableFile{path, *size, std::move(*opened)};
}

tl::unexpected<Error> ReadableFile::ends_early(uint64_t needed, uint64_t found,
                                               const char* what) const {
  return fail(Status::truncated,
              fmt::format("{}: expected at least {} bytes {}, found {}: the file is incomplete, or "
                          "its header is wrong; copy or download it again",
                          path.string(), needed, what, found));
}

Result<std::unique_ptr<ByteReader>> open_plain(const std::filesystem::path& path) {
  auto file = ReadableFile::open(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<PlainReader>(std::move(*file));
}

Result<std::string> read_beginning(const std::filesystem::path& path, size_t limit) {
  auto reader = open_plain(path);
  if (!reader) return tl::unexpected(reader.error());
  std::string text(static_cast<size_t>(std::min<uint64_t>(limit, (*reader)->size_limit())), '\0');
  auto read = (*reader)->read(0, std::as_writable_bytes(std::span(text)));
  if (!read) return tl::unexpected(read.error());
  return text;
}

bool is_gzip(const std::filesystem::path& path) {
  auto reader = open_plain(path);
  std::array<std::byte, 2> magic{};
  return reader && (*reader)->read(0, magic) && magic[0] == std::byte{0x1f} &&
         magic[1] == std::byte{0x8b};
}

Result<uint64_t> size_of_file(const std::filesystem::path& path) {
  const auto state = input_state(path);
  if (!state) return tl::unexpected(state.error());
  if (state->bytes == 0) {
    return fail(Status::malformed_volume,
                fmt::format("{}: the file is empty: copy or download it again", path.string()));
  }
  return state->bytes;
}

uint64_t total_bytes(const std::vector<std::filesystem::path>& files) {
  uint64_t bytes = 0;
  for (const auto& file : files) bytes += size_of_file(file).value_or(0);
  return bytes;
}

}  // namespace isosplat::import
