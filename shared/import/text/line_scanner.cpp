#include "shared/import/text/line_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

constexpr size_t kMaxLine = 4096;

}  // namespace

LineScanner::LineScanner(std::filesystem::path path, std::unique_ptr<ByteReader> file,
                         std::string format)
    : path_(std::move(path)), file_(std::move(file)), format_(std::move(format)) {}

Result<std::optional<std::string>> LineScanner::line() {
  std::string text;
  for (;;) {
    const auto c = take();
    if (!c) return tl::unexpected(c.error());
    if (*c < 0 && text.empty()) return std::optional<std::string>();
    if (*c < 0 || *c == '\n') break;
    text.push_back(static_cast<char>(*c));
    if (text.size() > kMaxLine) return malformed("expected a line of text, found other bytes");
  }
  if (text.ends_with('\r')) text.pop_back();
  return std::optional<std::string>(std::move(text));
}

Result<std::vector<std::string>> LineScanner::next_words() {
  for (;;) {
    auto text = line();
    if (!text) return tl::unexpected(text.error());
    if (!*text) return std::vector<std::string>();
    const auto found = words(**text);
    if (!found.empty()) return std::vector<std::string>(found.begin(), found.end());
  }
}

bool LineScanner::skip_bytes(uint64_t bytes) {
  next_ = end_ = 0;
  const uint64_t size = file_->size_limit();
  const bool fits = position_ <= size && bytes <= size - position_;
  position_ = fits ? position_ + bytes : size;
  return fits;
}

Result<bool> LineScanner::skip_numbers(uint64_t count) {
  bool in_word = false;
  for (uint64_t done = 0; done < count || in_word;) {
    const auto c = take();
    if (!c) return tl::unexpected(c.error());
    const bool separates = *c < 0 || *c == ' ' || (*c >= '\t' && *c <= '\r');
    if (*c < 0) return done == count && !in_word;
    if (in_word && separates && done == count) break;
    if (!separates && !in_word) ++done;
    in_word = !separates;
  }
  return true;
}

tl::unexpected<Error> LineScanner::malformed(const std::string& what) const {
  return fail(Status::malformed_volume,
              fmt::format("{}: {} before byte {}: the {} file is damaged; export the volume "
                          "again",
                          path_.string(), what, position_, format_));
}

/// The next character, or −1.
Result<int> LineScanner::take() {
  if (next_ == end_) {
    const uint64_t size = file_->size_limit();
    const auto some =
        static_cast<size_t>(std::min<uint64_t>(buffer_.size(), size - std::min(size, position_)));
    if (some == 0) return -1;
    auto read = file_->read(position_, std::as_writable_bytes(std::span(buffer_).first(some)));
    if (!read) return tl::unexpected(read.error());
    next_ = 0;
    end_ = some;
  }
  ++position_;
  return static_cast<unsigned char>(buffer_[next_++]);
}

}  // namespace isosplat::import
