#include "shared/import/codecs/lzf.h"

#include <cstdint>
#include <cstring>

// LZF   u8 c < 32: c + 1 literal bytes follow.
//       Otherwise a copy: bits 5 to 7 of c are its length - 2 (7: u8 is added), bits 0 to 4 and u8
//       its distance - 1.
// LZ4   u8: bits 4 to 7 are the number of literal bytes, bits 0 to 3 the length - 4 of a copy. If
//       one of them is 15, bytes are added to it, up to the first one that is not 255. The literal
//       bytes and u16 distance follow. The last pair has no copy.
namespace isosplat::import {
namespace {

class Copier {
 public:
  Copier(std::span<const std::byte> in, std::span<std::byte> out) : in_(in), out_(out) {}

  bool has_more() const { return at_ < in_.size(); }
  bool is_full() const { return done_ == out_.size(); }
  /// 0 after the end; then has_failed.
  size_t byte() {
    if (at_ == in_.size()) {
      failed_ = true;
      return 0;
    }
    return static_cast<size_t>(in_[at_++]);
  }
  bool has_failed() const { return failed_; }

  void take(size_t count) {
    if (count > in_.size() - at_ || count > out_.size() - done_) {
      failed_ = true;
      return;
    }
    if (count > 0) std::memcpy(out_.data() + done_, in_.data() + at_, count);
    at_ += count;
    done_ += count;
  }

  /// A copy may overlap its source: then it repeats it.
  void repeat(size_t distance, size_t count) {
    if (distance == 0 || distance > done_ || count > out_.size() - done_) {
      failed_ = true;
      return;
    }
    for (size_t i = 0; i < count; ++i, ++done_) out_[done_] = out_[done_ - distance];
  }

 private:
  std::span<const std::byte> in_;
  std::span<std::byte> out_;
  size_t at_ = 0, done_ = 0;
  bool failed_ = false;
};

}  // namespace

bool decompress_lzf(std::span<const std::byte> in, std::span<std::byte> out) {
  Copier copier(in, out);
  while (copier.has_more() && !copier.has_failed()) {
    const size_t control = copier.byte();
    if (control < 32) {
      copier.take(control + 1);
      continue;
    }
    size_t count = control >> 5;
    if (count == 7) count += copier.byte();
    const size_t distance = ((control & 31) << 8 | copier.byte()) + 1;
    copier.repeat(distance, count + 2);
  }
  return !copier.has_failed() && copier.is_full();
}

bool decompress_lz4(std::span<const std::byte> in, std::span<std::byte> out) {
  Copier copier(in, out);
  const auto extended = [&](size_t count) {
    if (count < 15) return count;
    for (size_t more = 255; more == 255 && !copier.has_failed();) count += more = copier.byte();
    return count;
  };
  while (copier.has_more() && !copier.has_failed()) {
    const size_t token = copier.byte();
    copier.take(extended(token >> 4));
    if (!copier.has_more()) break;
    const size_t low = copier.byte(), distance = low | copier.byte() << 8;
    copier.repeat(distance, extended(token & 15) + 4);
  }
  return !copier.has_failed() && copier.is_full();
}

}  // namespace isosplat::import
