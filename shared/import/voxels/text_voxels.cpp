#include "shared/import/voxels/text_voxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "shared/import/text/float_from_chars.h"
#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

constexpr size_t kMaxWord = 512;

bool is_separator(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f' || c == ',';
}

/// Reads the characters of a file one after another.
class Characters {
 public:
  Characters(std::unique_ptr<ByteReader> file, uint64_t start, std::optional<uint64_t> end)
      : file_(std::move(file)),
        start_(start),
        limit_(std::min(end.value_or(file_->size_limit()), file_->size_limit())),
        has_end_(end.has_value()),
        position_(start) {}

  void restart() {
    position_ = start_;
    next_ = end_ = 0;
  }

  /// The next character, or −1 at the end of the file.
  Result<int> take() {
    if (next_ == end_) {
      const auto some = static_cast<size_t>(
          std::min<uint64_t>(buffer_.size(), limit_ - std::min(limit_, position_)));
      if (some == 0) return -1;
      auto read = file_->read(position_, std::as_writable_bytes(std::span(buffer_).first(some)));
      if (!read) return tl::unexpected(read.error());
      position_ += some;
      next_ = 0;
      end_ = some;
    }
    return static_cast<unsigned char>(buffer_[next_++]);
  }

  uint64_t position() const { return position_ - (end_ - next_); }
  uint64_t bytes() const { return limit_ - std::min(limit_, start_); }
  /// Whether the text ends before a known character, so that its last word is whole.
  bool has_end() const { return has_end_; }
  std::vector<std::filesystem::path> files() const { return file_->files(); }
  std::string name() const { return file_->files().front().string(); }

 private:
  std::unique_ptr<ByteReader> file_;
  uint64_t start_, limit_;
  bool has_end_;
  uint64_t position_;
  size_t next_ = 0, end_ = 0;
  std::array<char, 64 * 1024> buffer_;
};

/// The common part of text readers: they parse items of a fixed size in sequence.
class ItemReader : public ByteReader {
 public:
  ItemReader(std::unique_ptr<ByteReader> file, uint64_t start, std::optional<uint64_t> end,
             size_t item_bytes)
      : characters_(std::move(file), start, end), item_bytes_(item_bytes) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (offset < position_) restart();
    while (position_ < offset + out.size()) {
      const auto got = next(item_);
      if (!got) return tl::unexpected(got.error());
      if (!*got) return ends_early(offset + out.size());
      for (size_t i = 0; i < item_bytes_; ++i, ++position_) {
        if (position_ >= offset && position_ < offset + out.size()) {
          out[static_cast<size_t>(position_ - offset)] = item_[i];
        }
      }
    }
    return {};
  }

  Result<uint64_t> count_after(uint64_t offset, uint64_t most) override {
    if (offset < position_) restart();
    uint64_t count = 0;
    while (count < most) {
      const auto got = next(item_);
      if (!got) return tl::unexpected(got.error());
      if (!*got && position_ < offset) return ends_early(offset);
      if (!*got) break;
      position_ += item_bytes_;
      if (position_ > offset) count += item_bytes_;
    }
    return std::min(count, most);
  }

  uint64_t available_bytes() override {
    restart();
    for (;;) {
      const auto got = next(item_);
      if (!got || !*got) return position_;
      position_ += item_bytes_;
    }
  }

  std::vector<std::filesystem::path> files() const override { return characters_.files(); }

 protected:
  /// Parses the next item; false at the end of the text.
  virtual Result<bool> next(std::span<std::byte> item) = 0;

  size_t item_bytes() const { return item_bytes_; }
  uint64_t items_before() const { return position_ / item_bytes_; }
  Characters& characters() { return characters_; }
  const Characters& characters() const { return characters_; }

 private:
  void restart() {
    characters_.restart();
    position_ = 0;
  }

  tl::unexpected<Error> ends_early(uint64_t needed_bytes) const {
    return fail(Status::truncated,
                fmt::format("{}: expected at least {} values, found {}: the file is incomplete, or "
                            "its header is wrong; copy or download it again",
                            characters_.name(), (needed_bytes + item_bytes_ - 1) / item_bytes_,
                            position_ / item_bytes_));
  }

  Characters characters_;
  size_t item_bytes_;
  uint64_t position_ = 0;
  std::array<std::byte, 8> item_{};
};

template <class T>
bool parse(std::string_view word, std::span<std::byte> item) {
  if (word.starts_with('+')) word.remove_prefix(1);
  T value{};
  const char* end = word.data() + word.size();
  std::from_chars_result parsed{};
  if constexpr (std::is_integral_v<T>) {
    parsed = std::from_chars(word.data(), end, value);
  } else {
    parsed = float_from_chars(word.data(), end, value);
  }
  if constexpr (std::is_integral_v<T>) {
    // Some writers write integers as "12." or "1.2e1": accepted if the value is exact.
    if (parsed.ec != std::errc{} || parsed.ptr != end) {
      double number = 0;
      parsed = float_from_chars(word.data(), end, number);
      if (parsed.ec != std::errc{} || parsed.ptr != end || !(std::abs(number) < 9e15)) return false;
      const auto whole = static_cast<int64_t>(number);
      value = static_cast<T>(whole);
      if (static_cast<double>(whole) != number || static_cast<double>(value) != number) {
        return false;
      }
    }
  } else if (parsed.ec == std::errc::result_out_of_range && parsed.ptr == end) {
    // Values outside the type's range become 0 or infinity, as in strtod.
    value = std::is_same_v<T, float>
                ? static_cast<T>(std::strtof(std::string(word).c_str(), nullptr))
                : static_cast<T>(std::strtod(std::string(word).c_str(), nullptr));
    parsed.ec = std::errc{};
  }
  if (parsed.ec != std::errc{} || parsed.ptr != end) return false;
  std::memcpy(item.data(), &value, sizeof(T));
  return true;
}

bool parse_word(VoxelType type, std::string_view word, std::span<std::byte> item) {
  return with_voxel_type(type, [&]<class T>(T) { return parse<T>(word, item); });
}

/// The beginning of a word, for messages.
std::string printable(std::string_view word) {
  std::string text(word.substr(0, 40));
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text;
}

class TextReader : public ItemReader {
 public:
  TextReader(std::unique_ptr<ByteReader> file, uint64_t start, std::optional<uint64_t> end,
             VoxelType type)
      : ItemReader(std::move(file), start, end, voxel_bytes(type)), type_(type) {}

  uint64_t size_limit() const override {  // a digit and a separator per voxel
    return (characters().bytes() / 2 + 1) * item_bytes();
  }

 protected:
  Result<bool> next(std::span<std::byte> item) override {
    word_.clear();
    for (;;) {
      const auto c = characters().take();
      if (!c) return tl::unexpected(c.error());
      const bool ends = *c < 0 || is_separator(static_cast<char>(*c));
      if (*c < 0 && !word_.empty() && !characters().has_end()) {
        return fail(Status::truncated,
                    fmt::format("{}: expected white space after the last number, '{}', found the "
                                "end: the number may be cut off; copy the file again, or end its "
                                "last line",
                                characters().name(), printable(word_)));
      }
      if (ends && !word_.empty()) break;
      if (*c < 0) return false;
      if (!ends && word_.size() < kMaxWord) word_.push_back(static_cast<char>(*c));
    }
    if (!parse_word(type_, word_, item)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected a number of the header's voxel type as value {}, found "
                              "'{}' before byte {}: the file is damaged, or its header is wrong; "
                              "export it again",
                              characters().name(), items_before() + 1, printable(word_),
                              characters().position()));
    }
    return true;
  }

 private:
  VoxelType type_;
  std::string word_;
};

int hex_digit(int c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

class HexReader : public ItemReader {
 public:
  HexReader(std::unique_ptr<ByteReader> file, uint64_t start)
      : ItemReader(std::move(file), start, std::nullopt, 1) {}

  uint64_t size_limit() const override { return characters().bytes() / 2; }

 protected:
  Result<bool> next(std::span<std::byte> item) override {
    int digits = 0, value = 0;
    while (digits < 2) {
      const auto c = characters().take();
      if (!c) return tl::unexpected(c.error());
      if (*c < 0 && digits == 0) return false;
      if (*c >= 0 && is_separator(static_cast<char>(*c)) && *c != ',') continue;
      const int digit = hex_digit(*c);
      if (digit < 0) {
        return fail(Status::malformed_volume,
                    fmt::format("{}: expected two hexadecimal digits for byte {}, found {}: the "
                                "file is damaged; export it again",
                                characters().name(), items_before(),
                                *c < 0 ? "the end" : "something else"));
      }
      value = 16 * value + digit;
      ++digits;
    }
    item[0] = static_cast<std::byte>(value);
    return true;
  }
};

}  // namespace

Result<std::unique_ptr<ByteReader>> open_text_voxels(const std::filesystem::path& path,
                                                     uint64_t start, VoxelType type,
                                                     std::optional<uint64_t> end) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<TextReader>(std::move(*file), start, end, type);
}

Result<std::unique_ptr<ByteReader>> open_hex(const std::filesystem::path& path, uint64_t start) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<HexReader>(std::move(*file), start);
}

}  // namespace isosplat::import
