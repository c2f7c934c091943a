#include "native/import/byte_reader.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "shared/posix_file/posix_file.h"

namespace isosplat {
namespace {

/// An open file, and its size when it was opened.
struct File {
  static Result<File> open(const std::filesystem::path& path) {
    const auto size = size_of_file(path);
    if (!size) return tl::unexpected(size.error());
    auto opened = PosixFile::open(path);
    if (!opened) return tl::unexpected(opened.error());
    return File{path, *size, std::move(*opened)};
  }

  std::filesystem::path path;
  uint64_t size = 0;
  PosixFile open_file;
};

tl::unexpected<Error> ends_early(const std::filesystem::path& path, uint64_t needed, uint64_t found,
                                 const char* what) {
  return fail(Status::truncated,
              fmt::format("{}: expected at least {} bytes {}, found {}: the file is incomplete, or "
                          "its header is wrong; copy or download it again",
                          path.string(), needed, what, found));
}

class PlainReader : public ByteReader {
 public:
  explicit PlainReader(File file) : file_(std::move(file)) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    const auto got = file_.open_file.read_some(offset, out);
    if (!got) return tl::unexpected(got.error());
    if (*got < out.size()) return ends_early(file_.path, offset + out.size(), offset + *got, "");
    return {};
  }

  uint64_t size_limit() const override { return file_.size; }

  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override {
    return std::min(max_count, file_.size - std::min(file_.size, offset));
  }

  uint64_t available_bytes() override { return file_.size; }

  std::vector<std::filesystem::path> files() const override { return {file_.path}; }

 private:
  File file_;
};

class DeflatedReader : public ByteReader {
 public:
  DeflatedReader(File file, uint64_t start, Deflate kind)
      : file_(std::move(file)), start_(start), kind_(kind) {}
  ~DeflatedReader() override { stop(); }

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (auto there = go_to(offset); !there) return there;
    return expand(out);
  }

  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override {
    if (auto there = go_to(offset); !there) return tl::unexpected(there.error());
    uint64_t count = 0;
    while (count < max_count) {
      const auto room = static_cast<size_t>(std::min<uint64_t>(max_count - count, skipped_.size()));
      const auto made = expand_some(std::span(skipped_).first(room));
      if (!made) return tl::unexpected(made.error());
      if (*made == 0) break;
      count += *made;
    }
    return count;
  }

  uint64_t available_bytes() override {
    if (!begin()) return 0;
    for (;;) {
      const auto made = expand_some(skipped_);
      if (!made || *made == 0) return position_;
    }
  }

  uint64_t size_limit() const override {
    const uint64_t bytes = file_.size - std::min(start_, file_.size);
    return bytes > std::numeric_limits<uint64_t>::max() / 1040 ? bytes : bytes * 1040;
  }
  std::vector<std::filesystem::path> files() const override { return {file_.path}; }

 private:
  Result<void> begin() {
    stop();
    stream_ = z_stream{};
    // 32: detects gzip or zlib by the header; negative: raw deflate.
    if (inflateInit2(&stream_, kind_ == Deflate::raw ? -15 : 15 + 32) != Z_OK) {
      return fail(Status::out_of_memory, "zlib could not be started: not enough memory");
    }
    running_ = true;
    ended_member_ = false;
    position_ = 0;
    input_offset_ = start_;
    return {};
  }

  void stop() {
    if (running_) inflateEnd(&stream_);
    running_ = false;
  }

  tl::unexpected<Error> damaged(const char* reason) {
    return fail(Status::malformed_volume,
                fmt::format("{}: the compressed data are damaged near byte {} ({}): copy or "
                            "download the file again",
                            file_.path.string(), input_offset_ - stream_.avail_in, reason));
  }

  Result<void> go_to(uint64_t offset) {
    if (!running_ || offset < position_) {
      if (auto begun = begin(); !begun) return begun;
    }
    while (position_ < offset) {
      const auto skip = std::min<uint64_t>(offset - position_, skipped_.size());
      if (auto r = expand(std::span(skipped_).first(static_cast<size_t>(skip))); !r) return r;
    }
    return {};
  }

  Result<void> expand(std::span<std::byte> out) {
    const auto done = expand_some(out);
    if (!done) return tl::unexpected(done.error());
    if (*done == out.size()) return {};
    return ends_early(file_.path, position_ + (out.size() - *done), position_,
                      "after decompression");
  }

  /// Decompresses up to out.size() bytes; fewer only at the regular end of the data.
  Result<size_t> expand_some(std::span<std::byte> out) {
    size_t done = 0;
    bool is_last = false;
    if (kind_ == Deflate::raw && ended_member_) return done;
    while (done < out.size()) {
      if (stream_.avail_in == 0) {
        const auto got = file_.open_file.read_some(input_offset_, input_);
        if (!got) return tl::unexpected(got.error());
        if (*got == 0 && ended_member_) return done;
        is_last = *got == 0;  // zlib may still hold input that it has read
        input_offset_ += *got;
        stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
        stream_.avail_in = static_cast<uInt>(*got);
      }
      const size_t room = std::min<size_t>(out.size() - done, 1u << 30);
      stream_.next_out = reinterpret_cast<Bytef*>(out.data() + done);
      stream_.avail_out = static_cast<uInt>(room);
      const int status = inflate(&stream_, Z_NO_FLUSH);
      const size_t made = room - stream_.avail_out;
      done += made;
      position_ += made;
      if (status == Z_STREAM_END && kind_ == Deflate::raw) {
        ended_member_ = true;
        return done;
      }
      if (status == Z_STREAM_END) {
        inflateReset(&stream_);  // another member may follow
        ended_member_ = true;
      } else if (is_last && made == 0) {
        return ends_early(file_.path, position_ + (out.size() - done), position_,
                          "after decompression");
      } else if (status == Z_DATA_ERROR && ended_member_ && made == 0) {
        // Bytes after the last member are not gzip data: the data end here.
        stream_.avail_in = 0;
        input_offset_ = file_.size;
        return done;
      } else if (status != Z_OK && status != Z_BUF_ERROR) {
        return damaged(stream_.msg ? stream_.msg : "not gzip data");
      } else if (made > 0) {
        ended_member_ = false;
      }
    }
    return done;
  }

  File file_;
  uint64_t start_;
  Deflate kind_;
  z_stream stream_{};
  bool running_ = false;
  bool ended_member_ = false;
  uint64_t position_ = 0;      ///< decompressed bytes returned since the beginning
  uint64_t input_offset_ = 0;  ///< of the next input byte, in the file
  std::array<std::byte, 64 * 1024> input_;
  std::array<std::byte, 16 * 1024> skipped_;
};

}  // namespace

Result<std::unique_ptr<ByteReader>> open_plain(const std::filesystem::path& path) {
  auto file = File::open(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<PlainReader>(std::move(*file));
}

Result<std::unique_ptr<ByteReader>> open_deflated(const std::filesystem::path& path, uint64_t start,
                                                  Deflate kind) {
  auto file = File::open(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<DeflatedReader>(std::move(*file), start, kind);
}

bool is_gzip(const std::filesystem::path& path) {
  auto reader = open_plain(path);
  std::array<std::byte, 2> magic{};
  return reader && (*reader)->read(0, magic) && magic[0] == std::byte{0x1f} &&
         magic[1] == std::byte{0x8b};
}

Result<uint64_t> size_of_file(const std::filesystem::path& path) {
  const auto identity = file_identity(path);
  if (!identity) return tl::unexpected(identity.error());
  if (identity->bytes == 0) {
    return fail(Status::malformed_volume,
                fmt::format("{}: the file is empty: copy or download it again", path.string()));
  }
  return identity->bytes;
}

}  // namespace isosplat
