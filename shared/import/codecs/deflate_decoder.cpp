#include "shared/import/codecs/deflate_decoder.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace isosplat::import {
namespace {

constexpr size_t kInputBytes = size_t{64} << 10;
constexpr size_t kPadding = 64;                   ///< zeros after the last byte of the input
constexpr size_t kMadeBytes = size_t{128} << 10;  ///< capacity of the buffer for output
/// An upper bound of the lengths of all codes of a block, which take 14 + 19 · 3 + 320 · 14 bits.
constexpr size_t kHeaderBytes = 640;

uint64_t mask(unsigned bits) {
  return (uint64_t{1} << bits) - 1;
}

/// Copies a match, which may overlap its own output. May write up to 15 bytes after it.
void copy_match(uint8_t* to, size_t distance, size_t length) {
  const uint8_t* from = to - distance;
  if (distance >= 16) {
    for (size_t i = 0; i < length; i += 16) std::memcpy(to + i, from + i, 16);
  } else if (distance == 1) {
    std::memset(to, *from, length);
  } else {
    for (size_t i = 0; i < length; ++i) to[i] = from[i];
  }
}

}  // namespace

DeflateDecoder::DeflateDecoder(Read read)
    : read_(std::move(read)),
      input_(kInputBytes + kPadding),
      buffer_(kWindow + kMadeBytes + kLongest) {}

void DeflateDecoder::reset() {
  at_ = input_end_ = input_begin_ = 0;
  input_ended_ = input_failed_ = false;
  hold_ = held_ = 0;
  begin_ = taken_ = end_ = 0;
}

void DeflateDecoder::begin(std::span<const std::byte> window) {
  state_ = State::header;
  is_last_ = false;
  damage_ = "";
  if (taken_ == end_) begin_ = taken_ = end_ = 0;
  make_room();
  begin_ = end_;
  if (window.empty()) return;
  const size_t bytes = std::min(window.size(), kWindow);
  std::memcpy(buffer_.data() + end_, window.data() + window.size() - bytes, bytes);
  end_ += bytes;
  taken_ = end_;
}

bool DeflateDecoder::drop_bits(unsigned count) {
  if (!has_input(1)) return false;
  bits(count);
  return true;
}

std::span<const uint8_t> DeflateDecoder::window() const {
  const size_t bytes = std::min(kWindow, end_ - begin_);
  return {buffer_.data() + end_ - bytes, bytes};
}

uint64_t DeflateDecoder::input_bytes() const {
  return input_begin_ + at_ - (held_ >> 3);
}

/// Ensures that this many bytes of the input are available, or that the input has ended. Returns
/// false if it cannot be read.
bool DeflateDecoder::has_input(size_t bytes) {
  if (input_failed_) return false;
  if (input_ended_ || (at_ <= input_end_ && input_end_ - at_ >= bytes)) return true;
  at_ -= held_ >> 3;
  held_ &= 7;
  hold_ &= mask(held_);
  std::memmove(input_.data(), input_.data() + at_, input_end_ - at_);
  input_begin_ += at_;
  input_end_ -= at_;
  at_ = 0;
  while (input_end_ < bytes && !input_ended_) {
    const auto got = read_(std::span(input_).subspan(input_end_, kInputBytes - input_end_));
    if (!got) {
      input_failed_ = true;
      failure_ = got.error();
      return false;
    }
    input_end_ += *got;
    input_ended_ = *got == 0;
  }
  if (input_ended_) std::memset(input_.data() + input_end_, 0, kPadding);
  return true;
}

/// Fills hold_ to at least 56 bits. Requires has_input, and that the input is not overrun.
void DeflateDecoder::refill() {
  uint64_t next;
  std::memcpy(&next, input_.data() + at_, sizeof next);
  hold_ |= next << held_;
  at_ += (63 - held_) >> 3;
  held_ |= 56;
}

/// Takes up to 16 bits.
uint32_t DeflateDecoder::bits(unsigned count) {
  if (held_ < count && !is_overrun()) refill();
  const auto value = static_cast<uint32_t>(hold_ & mask(count));
  hold_ >>= count;
  held_ -= std::min(held_, count);
  return value;
}

/// Whether zeros after the end of the input were used as input.
bool DeflateDecoder::is_overrun() const {
  return input_ended_ && at_ * 8 > input_end_ * 8 + held_;
}

int DeflateDecoder::byte() {
  at_ -= held_ >> 3;
  hold_ = held_ = 0;
  if (!has_input(1)) return -2;
  return at_ < input_end_ ? input_[at_++] : -1;
}

DeflateDecoder::Stop DeflateDecoder::damaged(const char* why) {
  if (is_overrun()) return Stop::short_;
  damage_ = why;
  return Stop::damaged;
}

/// If all output was taken, moves the window to the beginning of the buffer.
void DeflateDecoder::make_room() {
  if (taken_ < end_ || end_ <= kWindow) return;
  const size_t shift = end_ - kWindow;
  std::memmove(buffer_.data(), buffer_.data() + shift, kWindow);
  begin_ -= std::min(begin_, shift);
  taken_ = end_ = kWindow;
}

DeflateDecoder::Stop DeflateDecoder::run() {
  if (*damage_ != '\0') return Stop::damaged;
  for (;;) {
    make_room();
    if (buffer_.size() - end_ < kLongest) return Stop::full;
    Stop stop = Stop::full;
    switch (state_) {
      case State::header:
        if (is_last_) {
          state_ = State::end;
          continue;
        }
        stop = read_header();
        break;
      case State::stored:
        stop = copy_stored();
        break;
      case State::codes:
        stop = decode_codes();
        break;
      case State::end:
        return Stop::end;
    }
    if (stop != Stop::block) return stop;
    if (state_ == State::header && !is_last_) return Stop::block;
  }
}

/// Reads the header of a block. Returns Stop::block if it was read.
DeflateDecoder::Stop DeflateDecoder::read_header() {
  if (!has_input(kHeaderBytes)) return Stop::failed;
  is_last_ = bits(1) == 1;
  const uint32_t type = bits(2);
  if (is_overrun()) return Stop::short_;
  if (type == 3) return damaged("invalid block type");
  if (type == 2) return read_lengths();
  if (type == 0) {
    bits(held_ & 7);
    const uint32_t size = bits(16), inverse = bits(16);
    if (is_overrun()) return Stop::short_;
    if (size != (inverse ^ 0xffff)) return damaged("invalid stored block lengths");
    stored_ = size;
    state_ = State::stored;
    return Stop::block;
  }
  std::array<uint8_t, 288> lengths;
  for (size_t i = 0; i < lengths.size(); ++i) {
    lengths[i] = i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8;
  }
  std::array<uint8_t, 32> distances;
  distances.fill(5);
  literals_.build(HuffmanTable::Kind::literals, lengths);
  distances_.build(HuffmanTable::Kind::distances, distances);
  state_ = State::codes;
  return Stop::block;
}

/// Reads the codes of a block (RFC 1951, 3.2.7).
DeflateDecoder::Stop DeflateDecoder::read_lengths() {
  const size_t literals = bits(5) + 257, distances = bits(5) + 1, count = bits(4) + 4;
  if (literals > 286 || distances > 30) return damaged("too many length or distance symbols");
  static constexpr uint8_t kOrder[] = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                       11, 4,  12, 3, 13, 2, 14, 1, 15};
  std::array<uint8_t, 19> code_lengths{};
  for (size_t i = 0; i < count; ++i) code_lengths[kOrder[i]] = static_cast<uint8_t>(bits(3));
  if (!literals_.build(HuffmanTable::Kind::code_lengths, code_lengths)) {
    return damaged("invalid code lengths set");
  }
  std::array<uint8_t, 286 + 30> lengths{};
  for (size_t i = 0; i < literals + distances;) {
    if (is_overrun()) return Stop::short_;
    refill();
    const uint32_t entry = literals_.find(hold_);
    if ((entry >> 8 & 0xff) == HuffmanTable::kInvalid) return damaged("invalid code lengths set");
    bits(entry & 0xff);
    const uint32_t symbol = entry >> 16;
    if (symbol < 16) {
      lengths[i++] = static_cast<uint8_t>(symbol);
      continue;
    }
    if (symbol == 16 && i == 0) return damaged("invalid bit length repeat");
    const uint8_t value = symbol == 16 ? lengths[i - 1] : uint8_t{0};
    const size_t repeat = symbol == 16 ? 3 + bits(2) : symbol == 17 ? 3 + bits(3) : 11 + bits(7);
    if (i + repeat > literals + distances) return damaged("invalid bit length repeat");
    std::fill_n(lengths.begin() + static_cast<std::ptrdiff_t>(i), repeat, value);
    i += repeat;
  }
  if (is_overrun()) return Stop::short_;
  if (lengths[256] == 0) return damaged("invalid code -- missing end-of-block");
  const std::span<const uint8_t> all(lengths);
  if (!literals_.build(HuffmanTable::Kind::literals, all.first(literals))) {
    return damaged("invalid literal/lengths set");
  }
  if (!distances_.build(HuffmanTable::Kind::distances, all.subspan(literals, distances))) {
    return damaged("invalid distances set");
  }
  state_ = State::codes;
  return Stop::block;
}

/// Returns Stop::block at the end of the block.
DeflateDecoder::Stop DeflateDecoder::copy_stored() {
  at_ -= held_ >> 3;
  hold_ = held_ = 0;
  while (stored_ > 0) {
    const size_t room = buffer_.size() - end_;
    if (room < kLongest) return Stop::full;
    if (!has_input(1)) return Stop::failed;
    const size_t count = std::min({stored_, room - kLongest + 1, input_end_ - at_});
    if (count == 0) return Stop::short_;
    std::memcpy(buffer_.data() + end_, input_.data() + at_, count);
    at_ += count;
    end_ += count;
    stored_ -= count;
  }
  state_ = State::header;
  return Stop::block;
}

/// Returns Stop::block at the end of the block.
DeflateDecoder::Stop DeflateDecoder::decode_codes() {
  for (;;) {
    if (buffer_.size() - end_ < kLongest) return Stop::full;
    if (!has_input(16)) return Stop::failed;
    // Zeros that are not input may follow the last bytes, so every code is checked there.
    const bool is_near_end = at_ + 16 > input_end_;
    if (is_near_end && is_overrun()) return Stop::short_;
    refill();
    uint64_t hold = hold_;
    unsigned used = 0;  // up to 48 bits: 15 + 5 of the length, 15 + 13 of the distance
    const auto next = [&](const HuffmanTable& table) {
      const uint32_t entry = table.find(hold);
      hold >>= entry & 0xff;
      used += entry & 0xff;
      return entry;
    };
    const auto kind_of = [](uint32_t entry) { return entry >> 8 & 0xff; };
    uint32_t entry = next(literals_);
    if (!is_near_end) {
      // Two literals before the code leave 26 bits for it: enough for another literal or for a
      // length. A distance follows after the next refill.
      for (int i = 0; i < 2 && kind_of(entry) == HuffmanTable::kLiteral; ++i) {
        buffer_[end_++] = static_cast<uint8_t>(entry >> 16);
        hold_ = hold;
        held_ -= std::exchange(used, 0);
        entry = next(literals_);
      }
      if (held_ < 48) {
        if (kind_of(entry) == HuffmanTable::kLiteral) {
          buffer_[end_++] = static_cast<uint8_t>(entry >> 16);
          hold_ = hold;
          held_ -= used;
          continue;
        }
        refill();
        hold = hold_ >> used;
      }
    }
    uint32_t kind = kind_of(entry);
    size_t length = 0, distance = 0;
    if (kind < 16) {
      length = (entry >> 16) + static_cast<size_t>(hold & mask(kind));
      hold >>= kind;
      used += kind;
      const uint32_t far = next(distances_);
      kind = kind_of(far);
      if (kind >= 16) {
        if (is_near_end) bits(15);
        return damaged("invalid distance code");
      }
      distance = (far >> 16) + static_cast<size_t>(hold & mask(kind));
      hold >>= kind;
      used += kind;
    } else if (kind == HuffmanTable::kInvalid) {
      if (is_near_end) bits(15);
      return damaged("invalid literal/length code");
    }
    hold_ = hold;
    held_ -= used;
    if (is_near_end && is_overrun()) return Stop::short_;
    if (length > 0) {
      if (distance > end_ - begin_) return damaged("invalid distance too far back");
      copy_match(buffer_.data() + end_, distance, length);
      end_ += length;
    } else if (kind == HuffmanTable::kLiteral) {
      buffer_[end_++] = static_cast<uint8_t>(entry >> 16);
    } else {
      state_ = State::header;
      return Stop::block;
    }
  }
}

}  // namespace isosplat::import
