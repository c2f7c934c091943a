#include <bzlib.h>
#include <fmt/format.h>
#include <lzma.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <array>
#include <utility>

#include "shared/import/bytes/readable_file.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/codecs/inflate_stream.h"
#include "shared/import/codecs/packing.h"

namespace isosplat::import {
namespace {

constexpr uint64_t kMaxMemory = uint64_t{256} << 20;

/// The compressed bytes of a file, in pieces.
class PackedBytes {
 public:
  PackedBytes(ReadableFile file, Packing packing) : file_(std::move(file)), packing_(packing) {}

  /// The next piece; empty at the end of the file.
  Result<std::span<std::byte>> next() {
    const auto got = file_.input->read_some(at_, piece_);
    if (!got) return tl::unexpected(got.error());
    at_ += *got;
    return std::span(piece_).first(*got);
  }

  tl::unexpected<Error> damaged() const {
    return fail(Status::malformed_volume,
                fmt::format("{}: the {}-compressed data are damaged before byte {}: copy "
                            "or download the file again",
                            file_.path.string(), name_of(packing_), at_));
  }

  tl::unexpected<Error> ends_early() const {
    return fail(Status::truncated,
                fmt::format("{}: the {}-compressed data end early, after {} bytes: the "
                            "file is incomplete; copy or download it again",
                            file_.path.string(), name_of(packing_), file_.size));
  }

  tl::unexpected<Error> needs_memory() const {
    return fail(Status::out_of_memory,
                fmt::format("{}: expected data that can be decompressed with {} MiB of memory, "
                            "found that more are needed: decompress the file with {} -d",
                            file_.path.string(), kMaxMemory >> 20, name_of(packing_)));
  }

  const ReadableFile& file() const { return file_; }

 private:
  ReadableFile file_;
  Packing packing_;
  uint64_t at_ = 0;
  std::array<std::byte, 64 * 1024> piece_;
};

class GzipStream : public UnpackStream {
 public:
  explicit GzipStream(PackedBytes bytes)
      : bytes_(std::move(bytes)),
        stream_(make_zlib_stream(bytes_.file(), 0, Deflate::gzip_or_zlib)) {}

  Result<size_t> read_some(std::span<std::byte> out) override {
    if (!stream_->is_running()) {
      if (auto begun = stream_->begin(); !begun) return tl::unexpected(begun.error());
    }
    return stream_->expand_some(out);
  }

 private:
  PackedBytes bytes_;
  std::unique_ptr<InflateStream> stream_;
};

class Bzip2Stream : public UnpackStream {
 public:
  explicit Bzip2Stream(PackedBytes bytes) : bytes_(std::move(bytes)) {}
  Bzip2Stream(const Bzip2Stream&) = delete;
  Bzip2Stream& operator=(const Bzip2Stream&) = delete;
  ~Bzip2Stream() override { stop(); }

  Result<size_t> read_some(std::span<std::byte> out) override {
    size_t done = 0;
    while (done < out.size()) {
      if (stream_.avail_in == 0) {
        const auto piece = bytes_.next();
        if (!piece) return tl::unexpected(piece.error());
        if (piece->empty() && !is_running_) return done;
        if (piece->empty()) return bytes_.ends_early();
        stream_.next_in = reinterpret_cast<char*>(piece->data());
        stream_.avail_in = static_cast<unsigned>(piece->size());
      }
      if (!is_running_ && BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) {
        return bytes_.needs_memory();
      }
      is_running_ = true;
      const size_t room = std::min<size_t>(out.size() - done, 1 << 30);
      stream_.next_out = reinterpret_cast<char*>(out.data() + done);
      stream_.avail_out = static_cast<unsigned>(room);
      const int status = BZ2_bzDecompress(&stream_);
      done += room - stream_.avail_out;
      if (status == BZ_STREAM_END) {
        stop();  // another stream may follow
      } else if (status != BZ_OK) {
        return bytes_.damaged();
      }
    }
    return done;
  }

 private:
  void stop() {
    if (std::exchange(is_running_, false)) BZ2_bzDecompressEnd(&stream_);
  }

  PackedBytes bytes_;
  bz_stream stream_{};
  bool is_running_ = false;
};

class XzStream : public UnpackStream {
 public:
  explicit XzStream(PackedBytes bytes) : bytes_(std::move(bytes)) {}
  XzStream(const XzStream&) = delete;
  XzStream& operator=(const XzStream&) = delete;
  ~XzStream() override { lzma_end(&stream_); }

  Result<size_t> read_some(std::span<std::byte> out) override {
    if (!is_running_ && lzma_stream_decoder(&stream_, kMaxMemory, LZMA_CONCATENATED) != LZMA_OK) {
      return bytes_.needs_memory();
    }
    is_running_ = true;
    stream_.next_out = reinterpret_cast<uint8_t*>(out.data());
    stream_.avail_out = out.size();
    bool is_last = false;
    while (stream_.avail_out > 0 && !has_ended_) {
      if (stream_.avail_in == 0) {
        const auto piece = bytes_.next();
        if (!piece) return tl::unexpected(piece.error());
        stream_.next_in = reinterpret_cast<const uint8_t*>(piece->data());
        stream_.avail_in = piece->size();
        is_last = piece->empty();
      }
      switch (lzma_code(&stream_, is_last ? LZMA_FINISH : LZMA_RUN)) {
        case LZMA_OK:
          break;
        case LZMA_STREAM_END:
          has_ended_ = true;
          break;
        case LZMA_BUF_ERROR:
          return bytes_.ends_early();
        case LZMA_MEMLIMIT_ERROR:
        case LZMA_MEM_ERROR:
          return bytes_.needs_memory();
        default:
          return bytes_.damaged();
      }
    }
    return out.size() - stream_.avail_out;
  }

 private:
  PackedBytes bytes_;
  lzma_stream stream_ = LZMA_STREAM_INIT;
  bool is_running_ = false;
  bool has_ended_ = false;
};

class ZstdStream : public UnpackStream {
 public:
  explicit ZstdStream(PackedBytes bytes) : bytes_(std::move(bytes)) {}

  Result<size_t> read_some(std::span<std::byte> out) override {
    if (!stream_) return bytes_.needs_memory();
    ZSTD_outBuffer to{out.data(), out.size(), 0};
    while (to.pos < to.size) {
      if (from_.pos == from_.size) {
        const auto piece = bytes_.next();
        if (!piece) return tl::unexpected(piece.error());
        from_ = {piece->data(), piece->size(), 0};
        if (piece->empty() && is_between_frames_) return to.pos;
        if (piece->empty()) return bytes_.ends_early();
      }
      // Windows of up to 128 MiB, the library's limit.
      const size_t left = ZSTD_decompressStream(stream_.get(), &to, &from_);
      if (ZSTD_isError(left)) {
        const ZSTD_ErrorCode code = ZSTD_getErrorCode(left);
        const bool is_large = code == ZSTD_error_frameParameter_windowTooLarge ||
                              code == ZSTD_error_memory_allocation;
        return is_large ? bytes_.needs_memory() : bytes_.damaged();
      }
      is_between_frames_ = left == 0;
    }
    return to.pos;
  }

 private:
  struct Free {
    void operator()(ZSTD_DCtx* stream) const { ZSTD_freeDCtx(stream); }
  };
  PackedBytes bytes_;
  std::unique_ptr<ZSTD_DCtx, Free> stream_{ZSTD_createDCtx()};
  ZSTD_inBuffer from_{nullptr, 0, 0};
  bool is_between_frames_ = true;
};

}  // namespace

Result<std::unique_ptr<UnpackStream>> open_unpack_stream(const std::filesystem::path& path,
                                                         Packing packing) {
  auto file = ReadableFile::open(path);
  if (!file) return tl::unexpected(file.error());
  PackedBytes bytes(std::move(*file), packing);
  switch (packing) {
    case Packing::bzip2:
      return std::make_unique<Bzip2Stream>(std::move(bytes));
    case Packing::xz:
      return std::make_unique<XzStream>(std::move(bytes));
    case Packing::zstd:
      return std::make_unique<ZstdStream>(std::move(bytes));
    default:
      return std::make_unique<GzipStream>(std::move(bytes));
  }
}

}  // namespace isosplat::import
