#include "shared/import/dicom/element_input.h"

#include <fmt/format.h>

#include <algorithm>

namespace isosplat::import::dicom {
namespace {

constexpr size_t kWindow = 8 * 1024;
constexpr uint64_t kMaxPeeked = 16;

}  // namespace

Result<bool> ElementInput::has(uint64_t bytes) {
  if (end_) return position_ <= *end_ && bytes <= *end_ - position_;
  return bytes > kMaxPeeked ? true : fill(static_cast<size_t>(bytes));
}

/// Fills the window with at least this many bytes from the position on; false if the file ends
/// first.
Result<bool> ElementInput::fill(size_t bytes) {
  const uint64_t window_end = window_start_ + window_.size();
  if (position_ >= window_start_ && position_ + bytes <= window_end) return true;
  uint64_t known = bytes;
  if (end_) {
    if (position_ > *end_ || bytes > *end_ - position_) return false;
    known = std::min(std::max<uint64_t>(bytes, kWindow), *end_ - position_);
  }
  const bool overlaps = position_ >= window_start_ && position_ < window_end;
  window_.erase(window_.begin(),
                overlaps ? window_.begin() + static_cast<std::ptrdiff_t>(position_ - window_start_)
                         : window_.end());
  window_start_ = position_;
  const size_t held = window_.size();
  window_.resize(static_cast<size_t>(known));
  const auto read = file_.read(position_ + held, std::span(window_).subspan(held));
  if (read) return true;
  window_.resize(held);
  if (!end_ && read.error().status == Status::truncated) return false;
  return tl::unexpected(read.error());
}

Result<void> ElementInput::look(std::span<std::byte> out) {
  const auto filled = fill(out.size());
  if (!filled) return tl::unexpected(filled.error());
  if (!*filled) return ends_early(0, out.size());
  std::copy_n(window_.begin() + static_cast<std::ptrdiff_t>(position_ - window_start_), out.size(),
              out.begin());
  return {};
}

Result<void> ElementInput::read(std::span<std::byte> out) {
  auto read = look(out);
  if (read) position_ += out.size();
  return read;
}

Result<void> ElementInput::check_end() {
  std::byte last{};
  if (end_ || position_ == 0) return {};
  return file_.read(position_ - 1, std::span(&last, 1));
}

tl::unexpected<Error> ElementInput::malformed(std::string_view why) const {
  return fail(Status::malformed_volume,
              fmt::format("{}: its DICOM elements are damaged near byte {} ({}): copy or export "
                          "the file again",
                          path_.string(), position_, why));
}

tl::unexpected<Error> ElementInput::ends_early(Tag tag, uint64_t needed) const {
  return fail(Status::truncated,
              fmt::format("{}: expected {} bytes for the element {}, found the end of the file: "
                          "it is incomplete; copy or download it again",
                          path_.string(), needed, name_of(tag)));
}

}  // namespace isosplat::import::dicom
