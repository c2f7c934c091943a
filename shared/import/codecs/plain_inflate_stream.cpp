#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "shared/import/codecs/checksums.h"
#include "shared/import/codecs/deflate_decoder.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/codecs/inflate_stream.h"

// The containers of deflated data: gzip (RFC 1952) and zlib (RFC 1950).
namespace isosplat::import {
namespace {

class PlainInflateStream : public InflateStream {
 public:
  PlainInflateStream(const ReadableFile& file, uint64_t start, Deflate kind)
      : file_(file), start_(start), kind_(kind) {}

  bool is_running() const override { return decoder_.has_value(); }
  uint64_t position() const override { return position_; }

  Result<void> begin() override {
    restart(start_, kind_ == Deflate::raw ? Container::raw : Container::unknown);
    made_bytes_ = position_ = 0;
    if (kind_ == Deflate::raw) decoder_->begin({});
    return {};
  }

  Result<void> begin_at(const AccessPoint& point) override {
    restart(point.input - (point.bits > 0 ? 1 : 0), Container::skipped);
    made_bytes_ = position_ = point.output;
    trailer_bytes_ = point.trailer_bytes;
    if (point.bits > 0 && !decoder_->drop_bits(static_cast<unsigned>(8 - point.bits))) {
      return tl::unexpected(decoder_->failure());
    }
    decoder_->begin(point.window);
    return {};
  }

  Result<size_t> expand_some(std::span<std::byte> out, AccessPoints* points) override {
    size_t done = 0;
    for (;;) {
      const auto made = decoder_->made();
      const size_t count = std::min(made.size(), out.size() - done);
      if (count > 0) std::memcpy(out.data() + done, made.data(), count);
      decoder_->take(count);
      done += count;
      position_ += count;
      if (count < made.size()) return done;
      // Decompresses the data behind the last byte before that byte is returned, so that damage
      // there is found together with it.
      const bool is_filled = done == out.size();
      if (ended_) return done;
      if (auto went = advance(points); !went) {
        if (!is_filled || went.error().status == Status::malformed_volume) {
          return tl::unexpected(went.error());
        }
        return done;
      }
      if (short_ && decoder_->made().empty()) {
        if (is_filled) return done;
        return file_.ends_early(position_ + (out.size() - done), position_, "after decompression");
      }
      if (is_filled && (!decoder_->made().empty() || ended_)) return done;
    }
  }

 private:
  enum class Container : uint8_t { unknown, gzip, zlib, raw, skipped };

  /// The result of looking for the beginning of a member.
  enum class Start : uint8_t {
    member,
    ends_early,  ///< the file ends
    failed,      ///< the file cannot be read
    wrong_check,
    unknown_method,
    wrong_window,
    needs_dictionary,  ///< a preset dictionary, which is not available
    unknown_flags,
    wrong_header_crc,
  };

  /// The error of a member's header, in zlib's words.
  static const char* text_of(Start start) {
    switch (start) {
      case Start::wrong_check:
        return "incorrect header check";
      case Start::unknown_method:
        return "unknown compression method";
      case Start::wrong_window:
        return "invalid window size";
      case Start::unknown_flags:
        return "unknown header flags set";
      case Start::wrong_header_crc:
        return "header crc mismatch";
      default:
        return "not gzip data";
    }
  }

  void restart(uint64_t offset, Container container) {
    input_begin_ = offset;
    input_offset_ = offset;
    container_ = container;
    is_between_members_ = container == Container::unknown;
    has_member_ = ended_ = short_ = false;
    crc_ = 0;
    adler_ = 1;
    decoder_.emplace([this](std::span<uint8_t> into) -> Result<size_t> {
      const auto got = file_.input->read_some(input_offset_, std::as_writable_bytes(into));
      if (got) input_offset_ += *got;
      return got;
    });
  }

  /// Decompresses some more. Sets ended_ at the regular end, short_ if the file ends before it.
  Result<void> advance(AccessPoints* points) {
    if (short_) return {};
    if (is_between_members_) {
      const bool is_first = !has_member_;
      const Start start = read_container();
      if (start == Start::member) {
        is_between_members_ = false;
        return {};
      }
      if (start == Start::failed) return tl::unexpected(decoder_->failure());
      // Bytes after the last member are not gzip data, so the data end here.
      if (!is_first) {
        ended_ = true;
      } else if (start == Start::ends_early) {
        short_ = true;
      } else {
        return damaged(text_of(start));
      }
      return {};
    }
    const auto stop = decoder_->run();
    const auto made = decoder_->made();
    made_bytes_ += made.size();
    if (container_ == Container::gzip) crc_ = crc32(crc_, made);
    if (container_ == Container::zlib) adler_ = adler32(adler_, made);
    member_bytes_ += made.size();
    if (!made.empty()) is_empty_member_ = false;
    switch (stop) {
      case DeflateDecoder::Stop::full:
        return {};
      case DeflateDecoder::Stop::block:
        if (points && points->wants(made_bytes_)) points->add(point());
        return {};
      case DeflateDecoder::Stop::end:
        return end_member();
      case DeflateDecoder::Stop::short_:
        short_ = true;
        return {};
      case DeflateDecoder::Stop::failed:
        return tl::unexpected(decoder_->failure());
      case DeflateDecoder::Stop::damaged:
        if (has_member_ && is_empty_member_) {
          ended_ = true;
          return {};
        }
        if (made.empty()) return damaged(decoder_->damage());
        return {};  // once the output has been taken, the decoder stops here again
    }
    return {};
  }

  /// Reads the header of a member.
  Start read_container() {
    const int first = byte(), second = byte();
    if (second < 0) return last_byte_;
    if (first == 0x1f && second == 0x8b) {
      if (const Start start = read_gzip_header(); start != Start::member) return start;
      container_ = Container::gzip;
      trailer_bytes_ = 8;
    } else {
      if ((first * 256 + second) % 31 != 0) return Start::wrong_check;
      if ((first & 15) != 8) return Start::unknown_method;
      if (first >> 4 > 7) return Start::wrong_window;
      if ((second & 0x20) != 0) return Start::needs_dictionary;
      container_ = Container::zlib;
      trailer_bytes_ = 4;
    }
    crc_ = 0;
    adler_ = 1;
    member_bytes_ = 0;
    is_empty_member_ = true;
    decoder_->begin({});
    return Start::member;
  }

  Start read_gzip_header() {
    header_crc_ = crc32(0, std::array<uint8_t, 2>{0x1f, 0x8b});
    const int method = byte(), flags = byte();
    if (flags < 0) return last_byte_;
    if (method != 8) return Start::unknown_method;
    if ((flags & 0xe0) != 0) return Start::unknown_flags;
    for (int i = 0; i < 6; ++i) byte();
    if ((flags & 4) != 0) {
      const int low = byte(), high = byte();
      for (int i = 0; i < high * 256 + low; ++i) {
        if (byte() < 0) break;
      }
    }
    for (const int text : {8, 16}) {
      if ((flags & text) == 0) continue;
      while (byte() > 0) {
      }
    }
    if ((flags & 2) != 0) {
      const uint32_t expected = header_crc_ & 0xffff;
      const int low = byte(), high = byte();
      if (high >= 0 && static_cast<uint32_t>(high * 256 + low) != expected) {
        return Start::wrong_header_crc;
      }
    }
    return last_byte_;
  }

  /// A byte of the container; negative if there is none. Sets last_byte_.
  int byte() {
    const int value = decoder_->byte();
    last_byte_ = value >= 0 ? Start::member : value == -1 ? Start::ends_early : Start::failed;
    if (value >= 0) header_crc_ = crc32(header_crc_, std::array{static_cast<uint8_t>(value)});
    return value;
  }

  Result<void> end_member() {
    if (container_ == Container::raw) {
      ended_ = true;
      return {};
    }
    std::array<uint32_t, 2> trailer{};
    for (uint32_t i = 0; i < trailer_bytes_; ++i) {
      const int value = byte();
      if (value == -1) short_ = true;
      if (value == -2) return tl::unexpected(decoder_->failure());
      if (value < 0) return {};
      const auto bits = static_cast<uint32_t>(value);
      if (trailer_bytes_ == 4) {
        trailer[0] = trailer[0] << 8 | bits;  // zlib's trailer is big-endian
      } else {
        trailer[i / 4] |= bits << 8 * (i % 4);
      }
      if (i == 3 && ((container_ == Container::gzip && trailer[0] != crc_) ||
                     (container_ == Container::zlib && trailer[0] != adler_))) {
        return damaged("incorrect data check");
      }
    }
    if (container_ == Container::gzip && trailer[1] != static_cast<uint32_t>(member_bytes_)) {
      return damaged("incorrect length check");
    }
    has_member_ = is_between_members_ = true;
    return {};
  }

  AccessPoint point() {
    AccessPoint point{made_bytes_,
                      input_begin_ + decoder_->input_bytes(),
                      static_cast<int>(decoder_->unused_bits()),
                      trailer_bytes_,
                      {}};
    const auto window = std::as_bytes(decoder_->window());
    point.window.assign(window.begin(), window.end());
    return point;
  }

  tl::unexpected<Error> damaged(const char* reason) {
    return fail(Status::malformed_volume,
                fmt::format("{}: the compressed data are damaged near byte {} ({}): copy or "
                            "download the file again",
                            file_.path.string(), input_begin_ + decoder_->input_bytes(), reason));
  }

  const ReadableFile& file_;
  uint64_t start_;
  Deflate kind_;
  std::optional<DeflateDecoder> decoder_;
  Container container_ = Container::unknown;
  uint64_t input_begin_ = 0;   ///< offset in the file of decoder_'s input
  uint64_t input_offset_ = 0;  ///< of the next byte to read
  uint64_t position_ = 0, made_bytes_ = 0, member_bytes_ = 0;
  uint32_t trailer_bytes_ = 0, crc_ = 0, adler_ = 1, header_crc_ = 0;
  Start last_byte_ = Start::member;  ///< the result for the last byte of a container
  bool is_between_members_ = false, has_member_ = false, is_empty_member_ = false;
  bool ended_ = false, short_ = false;
};

}  // namespace

std::unique_ptr<InflateStream> make_plain_inflate_stream(const ReadableFile& file, uint64_t start,
                                                         Deflate kind) {
  return std::make_unique<PlainInflateStream>(file, start, kind);
}

}  // namespace isosplat::import
