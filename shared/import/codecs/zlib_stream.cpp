#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <utility>

#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/codecs/inflate_stream.h"

namespace isosplat::import {
namespace {

constexpr int kRawWindow = -15;            // for zlib: deflated data without a container
constexpr int kContainedWindow = 15 + 32;  // gzip or zlib, by the header

class ZlibStream : public InflateStream {
 public:
  ZlibStream(const ReadableFile& file, uint64_t start, Deflate kind)
      : file_(file), start_(start), kind_(kind) {}
  ZlibStream(const ZlibStream&) = delete;
  ZlibStream& operator=(const ZlibStream&) = delete;
  ~ZlibStream() override { stop(); }

  bool is_running() const override { return running_; }

  uint64_t position() const override { return position_; }

  Result<void> begin() override {
    if (auto started = start_zlib(kind_ == Deflate::raw ? kRawWindow : kContainedWindow);
        !started) {
      return started;
    }
    is_raw_ = kind_ == Deflate::raw;
    trailer_bytes_ = 0;
    position_ = 0;
    input_offset_ = start_;
    return {};
  }

  Result<void> begin_at(const AccessPoint& point) override {
    if (auto started = start_zlib(kRawWindow); !started) return started;
    is_raw_ = true;
    trailer_bytes_ = point.trailer_bytes;
    position_ = point.output;
    input_offset_ = point.input;
    if (point.bits > 0) {
      std::byte before{};
      const auto got = file_.input->read_some(point.input - 1, std::span(&before, 1));
      if (!got) return tl::unexpected(got.error());
      inflatePrime(&stream_, point.bits, std::to_integer<int>(before) >> (8 - point.bits));
    }
    if (!point.window.empty()) {
      inflateSetDictionary(&stream_, reinterpret_cast<const Bytef*>(point.window.data()),
                           static_cast<uInt>(point.window.size()));
    }
    return {};
  }

  Result<size_t> expand_some(std::span<std::byte> out, AccessPoints* points) override {
    size_t done = 0;
    bool is_last = false;
    if (kind_ == Deflate::raw && ended_member_) return done;
    while (done < out.size()) {
      if (stream_.avail_in == 0) {
        const auto got = read_input();
        if (!got) return tl::unexpected(got.error());
        if (*got == 0 && ended_member_) return done;
        is_last = *got == 0;  // zlib may still hold input that it has read
      }
      // Stops at the next block for an access point. With Z_BLOCK, zlib may stop without output.
      const bool stops = points && !is_last && points->wants(position_);
      const size_t room = std::min<size_t>(out.size() - done, AccessPoints::kFirstDistance);
      stream_.next_out = reinterpret_cast<Bytef*>(out.data() + done);
      stream_.avail_out = static_cast<uInt>(room);
      const int status = inflate(&stream_, stops ? Z_BLOCK : Z_NO_FLUSH);
      const size_t made = room - stream_.avail_out;
      done += made;
      position_ += made;
      if (status == Z_STREAM_END && kind_ == Deflate::raw) {
        ended_member_ = true;
        return done;
      }
      if (status == Z_STREAM_END) {
        if (auto next = begin_next_member(); !next) return tl::unexpected(next.error());
      } else if (is_last && made == 0) {
        return file_.ends_early(position_ + (out.size() - done), position_, "after decompression");
      } else if (status == Z_DATA_ERROR && ended_member_ && made == 0) {
        // Bytes after the last member are not gzip data, so the data end here.
        stream_.avail_in = 0;
        input_offset_ = file_.size;
        return done;
      } else if (status != Z_OK && status != Z_BUF_ERROR) {
        return damaged(stream_.msg ? stream_.msg : "not gzip data");
      } else if (made > 0) {
        ended_member_ = false;
      }
      if (stops && status == Z_OK && is_between_blocks()) points->add(point());
    }
    return done;
  }

 private:
  Result<void> start_zlib(int window_bits) {
    stop();
    stream_ = z_stream{};
    if (inflateInit2(&stream_, window_bits) != Z_OK) {
      return fail(Status::out_of_memory, "zlib could not be started: not enough memory");
    }
    running_ = true;
    ended_member_ = false;
    return {};
  }

  void stop() {
    if (running_) inflateEnd(&stream_);
    running_ = false;
  }

  /// Returns the number of bytes read: 0 at the end of the file.
  Result<size_t> read_input() {
    const auto got = file_.input->read_some(input_offset_, input_);
    if (!got) return got;
    // A member begins with 0x1f in gzip; the first byte of zlib data differs.
    if (!is_raw_ && *got > 0 && stream_.total_in == 0) note_container(input_[0]);
    input_offset_ += *got;
    stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
    stream_.avail_in = static_cast<uInt>(*got);
    return got;
  }

  void note_container(std::byte first) { trailer_bytes_ = first == std::byte{0x1f} ? 8 : 4; }

  /// Prepares for another member, which may follow.
  Result<void> begin_next_member() {
    ended_member_ = true;
    if (is_raw_) {  // started at an access point, so zlib has not read the container
      input_offset_ -= stream_.avail_in;
      input_offset_ += trailer_bytes_;
      stream_.avail_in = 0;
      is_raw_ = false;
      inflateReset2(&stream_, kContainedWindow);
      return {};
    }
    inflateReset(&stream_);
    if (stream_.avail_in > 0) note_container(std::byte{*stream_.next_in});
    return {};
  }

  /// Whether zlib stopped before a block of the data; false before the trailer.
  bool is_between_blocks() const {
    return (stream_.data_type & 128) != 0 && (stream_.data_type & 64) == 0;
  }

  /// The access point at the present position. Requires is_between_blocks().
  AccessPoint point() {
    AccessPoint point{
        position_, input_offset_ - stream_.avail_in, stream_.data_type & 7, trailer_bytes_, {}};
    uInt bytes = 0;
    point.window.resize(AccessPoints::kWindowBytes);
    inflateGetDictionary(&stream_, reinterpret_cast<Bytef*>(point.window.data()), &bytes);
    point.window.resize(bytes);
    return point;
  }

  tl::unexpected<Error> damaged(const char* reason) {
    return fail(Status::malformed_volume,
                fmt::format("{}: the compressed data are damaged near byte {} ({}): copy or "
                            "download the file again",
                            file_.path.string(), input_offset_ - stream_.avail_in, reason));
  }

  const ReadableFile& file_;
  uint64_t start_;
  Deflate kind_;
  z_stream stream_{};
  bool running_ = false;
  bool ended_member_ = false;
  bool is_raw_ = false;         ///< zlib does not see the container
  uint32_t trailer_bytes_ = 0;  ///< of the present member
  uint64_t position_ = 0;
  uint64_t input_offset_ = 0;  ///< of the next input byte, in the file
  std::array<std::byte, 64 * 1024> input_;
};

}  // namespace

std::unique_ptr<InflateStream> make_zlib_stream(const ReadableFile& file, uint64_t start,
                                                Deflate kind) {
  return std::make_unique<ZlibStream>(file, start, kind);
}

}  // namespace isosplat::import
