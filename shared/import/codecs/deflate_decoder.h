#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/codecs/huffman_table.h"

namespace isosplat::import {

/// Decompresses deflated data (RFC 1951) forwards. It pulls its input, so that it never stops
/// inside of a code, and keeps what it has made, with the 32 KiB before it, in a buffer.
class DeflateDecoder {
 public:
  /// Fills bytes with what follows of the input. Returns how many: 0 at its end.
  using Read = std::function<Result<size_t>(std::span<uint8_t>)>;

  enum class Stop : uint8_t {
    full,     ///< the buffer has no room: take its bytes
    block,    ///< between two blocks
    end,      ///< the last block has ended
    short_,   ///< the input ends before the data
    damaged,  ///< damage() says why
    failed    ///< the input could not be read: failure()
  };

  explicit DeflateDecoder(Read read);

  /// Forgets its input and what it has made: the next byte is the first that `read` gives then.
  void reset();

  /// Begins with deflated data here, after the whole bytes that were taken. `window`: up to 32 KiB
  /// of output before them.
  void begin(std::span<const std::byte> window);

  /// Drops input bits: those of a byte that belong to what comes before the data.
  bool drop_bits(unsigned count);

  /// Continues until one of the above. Bytes that were made before it stay available.
  Stop run();

  /// What was made and not taken yet.
  std::span<const uint8_t> made() const { return {buffer_.data() + taken_, end_ - taken_}; }
  void take(size_t count) { taken_ += count; }

  /// The up to 32 KiB before the end of made().
  std::span<const uint8_t> window() const;

  const char* damage() const { return damage_; }
  Error failure() const { return failure_; }

  /// A whole byte of the input, after the present one; −1 at its end, −2 if it cannot be read.
  int byte();

  /// How many bytes of the input were used, of the present one a part: its high unused_bits().
  uint64_t input_bytes() const;
  unsigned unused_bits() const { return held_ & 7; }

 private:
  enum class State : uint8_t { header, stored, codes, end };

  static constexpr size_t kWindow = size_t{32} << 10;
  static constexpr size_t kLongest = 258 + 16;  ///< of a match, with what copies may write after it

  bool has_input(size_t bytes);
  void refill();
  uint32_t bits(unsigned count);
  bool is_overrun() const;
  Stop damaged(const char* why);
  Stop read_header();
  Stop read_lengths();
  Stop copy_stored();
  Stop decode_codes();
  void make_room();

  Read read_;
  Error failure_;
  const char* damage_ = "";
  State state_ = State::header;
  bool is_last_ = false;
  size_t stored_ = 0;

  std::vector<uint8_t> input_;
  size_t at_ = 0, input_end_ = 0;  ///< of the bytes in input_
  uint64_t input_begin_ = 0;       ///< of input_[0] in the input
  bool input_ended_ = false, input_failed_ = false;
  uint64_t hold_ = 0;
  unsigned held_ = 0;  ///< bits in hold_

  std::vector<uint8_t> buffer_;
  size_t begin_ = 0;  ///< of the bytes that distances may reach
  size_t taken_ = 0, end_ = 0;

  HuffmanTable literals_, distances_;
};

}  // namespace isosplat::import
