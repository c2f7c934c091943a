#include "shared/import/dicom/lossless_jpeg.h"

#include <array>
#include <optional>
#include <vector>

//   SOI | markers with segments: DHT, DRI, SOF3, … | SOS | codes, RSTn between them | EOI
//
// A sample is stored as the difference from a prediction by its neighbours:
//   c b
//   a x
namespace isosplat::import {
namespace {

/// Huffman codes of the number of bits of differences (T.81, annex C).
class CodeTable {
 public:
  /// Returns false if a length has more codes than possible.
  bool build(std::span<const uint8_t> counts, std::span<const uint8_t> symbols) {
    entries_.assign(size_t{1} << 16, 0);
    size_t next = 0, symbol = 0;
    for (unsigned length = 1; length <= 16; ++length) {
      const size_t each = size_t{1} << (16 - length);
      for (unsigned i = 0; i < counts[length - 1]; ++i, next += each) {
        if (next + each > entries_.size() || symbols[symbol] > 16) return false;
        const auto entry = static_cast<uint16_t>(length << 8 | symbols[symbol++]);
        for (size_t code = next; code < next + each; ++code) entries_[code] = entry;
      }
    }
    return true;
  }

  bool is_empty() const { return entries_.empty(); }

  /// The code at the beginning of 16 bits: its length in the high byte, its symbol in the low one;
  /// 0 if there is none.
  uint16_t find(uint32_t bits) const { return entries_[bits]; }

 private:
  std::vector<uint16_t> entries_;
};

/// The bits of a scan. It ends at a marker; zeros follow.
class Bits {
 public:
  explicit Bits(std::span<const uint8_t> in) : in_(in) {}

  /// The next 16 bits.
  uint32_t peek() {
    for (; held_ < 32; held_ += 8) {
      uint8_t byte = 0;
      if (at_ >= in_.size() || is_marker()) {
        missing_ += 8;
      } else {
        byte = in_[at_];
        at_ += byte == 0xff ? 2 : 1;
      }
      hold_ = hold_ << 8 | byte;
    }
    return static_cast<uint32_t>(hold_ >> (held_ - 16)) & 0xffff;
  }

  /// Takes up to 16 bits after peek.
  uint32_t take(unsigned count) {
    held_ -= count;
    return static_cast<uint32_t>(hold_ >> held_) & ((1u << count) - 1);
  }

  /// Whether more bits were taken than exist.
  bool is_overrun() const { return held_ < missing_; }

  /// Skips a restart marker. Returns false if another marker follows.
  bool restart() {
    hold_ = held_ = missing_ = 0;
    while (at_ < in_.size() && !is_marker()) ++at_;
    while (in_.size() - at_ > 1 && in_[at_ + 1] == 0xff) ++at_;
    if (in_.size() - at_ < 2 || in_[at_ + 1] < 0xd0 || in_[at_ + 1] > 0xd7) return false;
    at_ += 2;
    return true;
  }

 private:
  bool is_marker() const {
    return in_[at_] == 0xff && (at_ + 1 >= in_.size() || in_[at_ + 1] != 0);
  }

  std::span<const uint8_t> in_;
  size_t at_ = 0;
  uint64_t hold_ = 0;
  unsigned held_ = 0,
           missing_ = 0;  ///< number of bits in hold_, and how many of them are not of the scan
};

int predicted(int predictor, int a, int b, int c) {
  switch (predictor) {
    case 1:
      return a;
    case 2:
      return b;
    case 3:
      return c;
    case 4:
      return a + b - c;
    case 5:
      return a + ((b - c) >> 1);
    case 6:
      return b + ((a - c) >> 1);
    default:
      return (a + b) >> 1;
  }
}

class Decoder {
 public:
  Decoder(std::span<const uint8_t> in, size_t columns, std::span<uint16_t> out)
      : in_(in), columns_(columns), out_(out) {}

  int decode() {
    if (in_.size() < 2 || in_[0] != 0xff || in_[1] != 0xd8) return 0;
    in_ = in_.subspan(2);
    for (;;) {
      while (in_.size() > 1 && in_[0] == 0xff && in_[1] == 0xff) in_ = in_.subspan(1);
      if (in_.size() < 4 || in_[0] != 0xff) return 0;
      const uint8_t marker = in_[1];
      const size_t bytes = u16(in_, 2);
      if (bytes < 2 || bytes > in_.size() - 2) return 0;
      const auto segment = in_.subspan(4, bytes - 2);
      in_ = in_.subspan(2 + bytes);
      if (marker == 0xda) return read_scan_header(segment) && decode_scan() ? bits_ : 0;
      if (marker == 0xc3 && !read_frame_header(segment)) return 0;
      if (marker == 0xc4 && !read_tables(segment)) return 0;
      if (marker == 0xdd) {
        if (segment.size() < 2) return 0;
        restart_samples_ = u16(segment, 0);
      }
    }
  }

 private:
  static size_t u16(std::span<const uint8_t> bytes, size_t at) {
    return static_cast<size_t>(bytes[at] << 8 | bytes[at + 1]);
  }

  bool read_frame_header(std::span<const uint8_t> segment) {
    if (segment.size() < 9) return false;
    bits_ = segment[0];
    const size_t rows = u16(segment, 1);
    return bits_ >= 2 && bits_ <= 16 && segment[5] == 1 && u16(segment, 3) == columns_ &&
           rows > 0 && columns_ > 0 && out_.size() == rows * columns_;
  }

  bool read_tables(std::span<const uint8_t> segment) {
    while (!segment.empty()) {
      if (segment.size() < 17) return false;
      const auto counts = segment.subspan(1, 16);
      size_t symbols = 0;
      for (const uint8_t count : counts) symbols += count;
      const size_t id = segment[0];
      if (id > 3 || segment.size() < 17 + symbols) return false;
      if (!tables_[id].build(counts, segment.subspan(17, symbols))) return false;
      segment = segment.subspan(17 + symbols);
    }
    return true;
  }

  bool read_scan_header(std::span<const uint8_t> segment) {
    if (segment.size() < 6 || segment[0] != 1) return false;
    const size_t id = segment[2] >> 4;
    if (id > 3 || tables_[id].is_empty() || bits_ == 0) return false;
    table_ = &tables_[id];
    predictor_ = segment[3];
    shift_ = segment[5] & 15;
    return predictor_ >= 1 && predictor_ <= 7 && shift_ < bits_ && restart_samples_ % columns_ == 0;
  }

  /// A difference. Nothing if these bits are no code.
  std::optional<int> difference(Bits& bits) const {
    const uint16_t entry = table_->find(bits.peek());
    if (entry == 0) return std::nullopt;
    bits.take(entry >> 8);
    const unsigned size = entry & 0xff;
    if (size == 0) return 0;
    if (size == 16) return 32768;
    bits.peek();
    const int value = static_cast<int>(bits.take(size));
    return value < 1 << (size - 1) ? value - (1 << size) + 1 : value;
  }

  bool decode_scan() {
    Bits bits(in_);
    const size_t rows = out_.size() / columns_, restart_rows = restart_samples_ / columns_;
    for (size_t y = 0; y < rows; ++y) {
      bool is_first = y == 0;
      if (y > 0 && restart_rows > 0 && y % restart_rows == 0) {
        if (!bits.restart()) return false;
        is_first = true;
      }
      uint16_t* row = out_.data() + y * columns_;
      const uint16_t* above = is_first ? nullptr : row - columns_;
      for (size_t x = 0; x < columns_; ++x) {
        const auto step = difference(bits);
        if (!step || bits.is_overrun()) return false;
        const int start = 1 << (bits_ - shift_ - 1);
        const int guess = !above   ? x == 0 ? start : row[x - 1]
                            : x == 0 ? above[0]
                                   : predicted(predictor_, row[x - 1], above[x], above[x - 1]);
        row[x] = static_cast<uint16_t>(guess + *step);
      }
    }
    for (uint16_t& sample : out_) sample = static_cast<uint16_t>(sample << shift_);
    return true;
  }

  std::span<const uint8_t> in_;
  size_t columns_;
  std::span<uint16_t> out_;
  std::array<CodeTable, 4> tables_;
  const CodeTable* table_ = nullptr;
  size_t restart_samples_ = 0;
  int bits_ = 0, predictor_ = 1, shift_ = 0;
};

}  // namespace

int decode_lossless_jpeg(std::span<const uint8_t> in, size_t columns, std::span<uint16_t> out) {
  return Decoder(in, columns, out).decode();
}

}  // namespace isosplat::import
