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

/// Decompresses deflated data (RFC 1951) forwards. It pulls its input through a callback, so that
/// it never stops inside a code. A buffer keeps the output, with the 32 KiB before it.
class DeflateDecoder {
 public:
  /// Fills the bytes with the next input. Returns their number; 0 at the end of the input.
  using Read = std::function<Result<size_t>(std::span<uint8_t>)>;

  enum class Stop : uint8_t {
    full,     ///< the buffer is full: take its bytes
    block,    ///< between two blocks
    end,      ///< the last block has ended
    short_,   ///< the input ends before the data
    damaged,  ///< damage() says why
    failed    ///< the input could not be read: failure()
  };

  explicit DeflateDecoder(Read read);

  /// Discards input and output. The next call of `read` then returns the first byte.
  void reset();

  /// Starts to decompress deflated data at the present position of the input. `window`: up to 32
  /// KiB of output before this position.
  void begin(std::span<const std::byte> window);

  /// Drops input bits: the bits of a byte that belong to the data before this position.
  bool drop_bits(unsigned count);

  /// Continues until one of the stops above. Output from before the stop remains available.
  Stop run();

  /// The output that has not been taken yet.
  std::span<const uint8_t> made() const { return {buffer_.data() + taken_, end_ - taken_}; }
  void take(size_t count) { taken_ += count; }

  /// The up to 32 KiB of output before the end of made().
  std::span<const uint8_t> window() const;

  const char* damage() const { return damage_; }
  Error failure() const { return failure_; }

  /// The next whole byte of the input; −1 at its end, −2 if it cannot be read.
  int byte();

  /// Number of input bytes that were used. Of the last one, the high unused_bits() are not used
  /// yet.
  uint64_t input_bytes() const;
  unsigned unused_bits() const { return held_ & 7; }

 private:
  enum class State : uint8_t { header, stored, codes, end };

  static constexpr size_t kWindow = size_t{32} << 10;
  static constexpr size_t kLongest =
      258 + 16;  ///< of a match, and the bytes that copying may write after it

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
  size_t at_ = 0, input_end_ = 0;  ///< offsets in input_
  uint64_t input_begin_ = 0;       ///< offset of input_[0] in the input
  bool input_ended_ = false, input_failed_ = false;
  uint64_t hold_ = 0;
  unsigned held_ = 0;  ///< number of bits in hold_

  std::vector<uint8_t> buffer_;
  size_t begin_ = 0;  ///< beginning of the bytes that distances may reach
  size_t taken_ = 0, end_ = 0;

  HuffmanTable literals_, distances_;
};

}  // namespace isosplat::import
