#include "shared/import/codecs/deflated_reader.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/readable_file.h"
#include "shared/import/codecs/access_points.h"
#include "shared/import/codecs/inflate_stream.h"

namespace isosplat::import {
namespace {

std::unique_ptr<InflateStream> make_stream(const ReadableFile& file, uint64_t start, Deflate kind) {
#ifdef __EMSCRIPTEN__
  return make_plain_inflate_stream(file, start, kind);
#else
  return make_zlib_stream(file, start, kind);
#endif
}

/// Has two streams. The first one decompresses all bytes once, in order, and verifies their
/// checksums. The second one decompresses earlier bytes again.
class DeflatedReader : public ByteReader {
 public:
  DeflatedReader(ReadableFile file, uint64_t start, Deflate kind)
      : file_(std::move(file)),
        start_(start),
        first_(make_stream(file_, start, kind)),
        again_(make_stream(file_, start, kind)) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (auto begun = begin(); !begun) return begun;
    if (offset < first_->position()) {
      const auto passed =
          static_cast<size_t>(std::min<uint64_t>(out.size(), first_->position() - offset));
      if (auto read = read_again(offset, out.first(passed)); !read) return read;
      offset += passed;
      out = out.subspan(passed);
    }
    if (out.empty()) return {};
    if (auto there = advance_to(offset); !there) return there;
    return expand(*first_, out);
  }

  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override {
    if (auto begun = begin(); !begun) return tl::unexpected(begun.error());
    if (auto there = advance_to(offset); !there) return tl::unexpected(there.error());
    while (first_->position() - offset < max_count) {
      const auto room = static_cast<size_t>(
          std::min<uint64_t>(max_count - (first_->position() - offset), skipped_.size()));
      const auto made = first_->expand_some(std::span(skipped_).first(room), &points_);
      if (!made) return tl::unexpected(made.error());
      if (*made == 0) break;
    }
    return std::min(max_count, first_->position() - offset);
  }

  uint64_t available_bytes() override {
    if (!begin()) return 0;
    for (;;) {
      const auto made = first_->expand_some(skipped_, &points_);
      if (!made || *made == 0) return first_->position();
    }
  }

  uint64_t size_limit() const override {
    const uint64_t bytes = file_.size - std::min(start_, file_.size);
    return bytes > std::numeric_limits<uint64_t>::max() / 1040 ? bytes : bytes * 1040;
  }

  uint64_t resident_bytes() const override { return AccessPoints::max_bytes(size_limit()); }

  std::vector<std::filesystem::path> files() const override { return {file_.path}; }

 private:
  Result<void> begin() {
    if (first_->is_running()) return {};
    return first_->begin();
  }

  Result<void> advance_to(uint64_t offset) {
    while (first_->position() < offset) {
      const auto skip = std::min<uint64_t>(offset - first_->position(), skipped_.size());
      if (auto r = expand(*first_, std::span(skipped_).first(static_cast<size_t>(skip))); !r) {
        return r;
      }
    }
    return {};
  }

  /// Reads bytes before first_->position().
  Result<void> read_again(uint64_t offset, std::span<std::byte> out) {
    const AccessPoint* const point = points_.before(offset);
    const uint64_t nearest = point ? point->output : 0;
    if (!again_->is_running() || again_->position() > offset || again_->position() < nearest) {
      if (auto begun = point ? again_->begin_at(*point) : again_->begin(); !begun) return begun;
    }
    while (again_->position() < offset) {
      const auto skip = std::min<uint64_t>(offset - again_->position(), skipped_.size());
      if (auto r = expand(*again_, std::span(skipped_).first(static_cast<size_t>(skip))); !r) {
        return r;
      }
    }
    return expand(*again_, out);
  }

  Result<void> expand(InflateStream& stream, std::span<std::byte> out) {
    const auto done = stream.expand_some(out, &stream == first_.get() ? &points_ : nullptr);
    if (!done) return tl::unexpected(done.error());
    if (*done == out.size()) return {};
    return file_.ends_early(stream.position() + (out.size() - *done), stream.position(),
                            "after decompression");
  }

  ReadableFile file_;
  uint64_t start_;
  AccessPoints points_;
  std::unique_ptr<InflateStream> first_, again_;
  std::array<std::byte, 16 * 1024> skipped_;
};

}  // namespace

Result<std::unique_ptr<ByteReader>> open_deflated(const std::filesystem::path& path, uint64_t start,
                                                  Deflate kind) {
  auto file = ReadableFile::open(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<DeflatedReader>(std::move(*file), start, kind);
}

}  // namespace isosplat::import
