#include "shared/import/vtk_xml/array_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "shared/import/codecs/lzf.h"
#include "shared/import/codecs/zlib_inflater.h"
#include "shared/import/voxels/text_voxels.h"
#ifndef __EMSCRIPTEN__
#include "shared/import/codecs/xz_block.h"
#endif

// The values of an array, raw or in base64, with numbers of header_type before them:
//
// uncompressed  bytes, then so many bytes. In base64, both are encoded together.
// compressed    blocks, bytes of a decompressed block, those of the last one (0: the same), and the
//               compressed bytes of each block; then the blocks. In base64, the numbers and all
//               blocks together are encoded separately, each with its own padding.
namespace isosplat::import {
namespace {

/// Larger blocks are refused, since a block is decompressed as a whole.
constexpr uint64_t kMaxBlockBytes = uint64_t{512} << 20;
constexpr uint64_t kMaxBlocks = uint64_t{1} << 24;
/// The most bytes that one byte of LZMA expands to, about.
constexpr uint64_t kMostLzmaExpansion = 16384;

int base64_digit(unsigned char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : -1;
}

class ArrayBytes : public ByteReader {
 public:
  ArrayBytes(const VtkXmlFile& file, const VtkXmlArray& array, std::unique_ptr<ByteReader> bytes)
      : file_(std::move(bytes)),
        path_(file.path),
        name_(array.name),
        compressor_(file.compressor),
        is_base64_(array.format == VtkXmlArray::Format::base64 || file.appended_base64),
        begin_(array.begin),
        end_(array.end) {}

  /// Reads the numbers before the values, and checks them.
  Result<void> open(const VtkXmlFile& file, uint64_t bytes) {
    bytes_ = bytes;
    if (is_base64_) {
      if (auto skipped = skip_space(); !skipped) return skipped;
    }
    const size_t width = file.header_bytes;
    const auto number = [&](const std::vector<std::byte>& from, size_t index) {
      uint64_t value = 0;
      for (size_t i = 0; i < width; ++i) {
        const size_t at = index * width + (file.big_endian ? i : width - 1 - i);
        value = value << 8 | static_cast<uint64_t>(from[at]);
      }
      return value;
    };
    std::vector<std::byte> header((compressor_ == VtkXmlCompressor::none ? 1 : 3) * width);
    if (auto enough = check_size(header.size()); !enough) return enough;
    if (auto read = read_stored(0, header); !read) return read;
    if (compressor_ == VtkXmlCompressor::none) {
      if (number(header, 0) != bytes) return has_other_bytes(number(header, 0));
      values_begin_ = width;
      return check_size(width, bytes);
    }
    const uint64_t blocks = number(header, 0), last = number(header, 2);
    block_bytes_ = number(header, 1);
    if (blocks == 0 || block_bytes_ == 0 || last > block_bytes_ || blocks > bytes) {
      return damaged("expected a number of compressed blocks, and their size");
    }
    const uint64_t others = last > 0 ? blocks - 1 : blocks;
    uint64_t found = 0;
    if (__builtin_mul_overflow(others, block_bytes_, &found) ||
        __builtin_add_overflow(found, last, &found) || found != bytes) {
      return has_other_bytes(found);
    }
    if (block_bytes_ > kMaxBlockBytes || blocks > kMaxBlocks) {
      return fail(
          Status::unsupported_format,
          fmt::format("{}: expected at most {} compressed blocks of at most {} bytes, found "
                      "{} of {}: save the volume with other blocks",
                      path_.string(), kMaxBlocks, kMaxBlockBytes, blocks, block_bytes_));
    }
    const uint64_t header_bytes = (3 + blocks) * width;
    if (auto enough = check_size(header_bytes); !enough) return enough;
    header.resize(static_cast<size_t>(header_bytes));
    if (auto read = read_stored(0, header); !read) return read;
    for (size_t i = 0; i < blocks; ++i) {
      const uint64_t size = number(header, 3 + i), before = ends_.empty() ? 0 : ends_.back();
      if (size > std::numeric_limits<uint64_t>::max() / 4 - before) {
        return damaged("expected the sizes of compressed blocks");
      }
      ends_.push_back(before + size);
    }
    begin_ += is_base64_ ? (header_bytes + 2) / 3 * 4 : header_bytes;
    return check_size(ends_.back());
  }

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (offset > bytes_ || out.size() > bytes_ - offset) {
      return damaged("expected more values");
    }
    if (ends_.empty()) return read_stored(values_begin_ + offset, out);
    while (!out.empty()) {
      if (auto loaded = load(offset / block_bytes_); !loaded) return loaded;
      const auto at = static_cast<size_t>(offset % block_bytes_);
      const size_t count = std::min(out.size(), block_.size() - at);
      std::copy_n(block_.begin() + static_cast<std::ptrdiff_t>(at), count, out.begin());
      offset += count;
      out = out.subspan(count);
    }
    return {};
  }

  bool is_random_access() const override { return ends_.empty() || block_bytes_ <= 1 << 20; }
  uint64_t size_limit() const override { return bytes_; }
  Result<uint64_t> count_after(uint64_t offset, uint64_t most) override {
    return std::min(most, bytes_ - std::min(bytes_, offset));
  }
  uint64_t available_bytes() override { return bytes_; }
  uint64_t resident_bytes() const override {
    const uint64_t bytes = 2 * block_bytes_ + 8 * ends_.size();
    return bytes < 1 << 20 ? 0 : bytes;
  }
  std::vector<std::filesystem::path> files() const override { return {path_}; }

 private:
  tl::unexpected<Error> damaged(const std::string& what) const {
    return malformed_vtk_xml(path_, fmt::format("{} in the array '{}'", what, name_));
  }

  tl::unexpected<Error> has_other_bytes(uint64_t found) const {
    return damaged(
        fmt::format("expected {} bytes, as extents and type say, found {}", bytes_, found));
  }

  /// Whether the file has so many bytes of the array, from begin_ on. Errors: truncated.
  Result<void> check_size(uint64_t first, uint64_t more = 0) const {
    const uint64_t part = end_ - std::min(end_, begin_);
    const uint64_t stored = is_base64_ ? part / 4 * 3 : part;
    if (first <= stored && more <= stored - first) return {};
    return fail(Status::truncated,
                fmt::format("{}: expected {} bytes of the array '{}', found {}: the file is "
                            "incomplete; copy or download it again",
                            path_.string(), first + more, name_, stored));
  }

  Result<void> skip_space() {
    for (std::array<std::byte, 1> byte{}; begin_ < end_; ++begin_) {
      if (auto read = file_->read(begin_, byte); !read) return read;
      const char c = static_cast<char>(byte[0]);
      if (c != ' ' && (c < '\t' || c > '\r')) break;
    }
    return {};
  }

  /// Reads bytes at an offset from begin_, decoded.
  Result<void> read_stored(uint64_t offset, std::span<std::byte> out) {
    if (!is_base64_) return file_->read(begin_ + offset, out);
    while (!out.empty()) {
      const auto skipped = static_cast<size_t>(offset % 3);
      const size_t groups = std::min((skipped + out.size() + 2) / 3, characters_.size() / 4);
      const auto characters = std::span(characters_).first(4 * groups);
      auto read = file_->read(begin_ + offset / 3 * 4, std::as_writable_bytes(characters));
      if (!read) return read;
      size_t at = 0;  // of the next byte to write
      for (size_t i = 0; i < groups; ++i) {
        uint32_t bits = 0;
        int padding = 0;
        for (size_t k = 0; k < 4; ++k) {
          const unsigned char c = characters[4 * i + k];
          const int digit = base64_digit(c);
          if ((digit < 0 && (c != '=' || k < 2)) || (padding > 0 && c != '=')) {
            return damaged("expected base64 without spaces");
          }
          padding += digit < 0;
          bits = bits << 6 | static_cast<uint32_t>(std::max(digit, 0));
        }
        for (size_t k = i == 0 ? skipped : 0; k < 3 && at < out.size(); ++k) {
          if (k >= static_cast<size_t>(3 - padding)) return damaged("expected more base64");
          out[at++] = static_cast<std::byte>(bits >> (16 - 8 * k) & 0xff);
        }
      }
      offset += at;
      out = out.subspan(at);
    }
    return {};
  }

  /// Decompresses a block, unless it is the one in memory.
  Result<void> load(uint64_t index) {
    if (held_ == index) return {};
    const auto at = static_cast<size_t>(index);
    const uint64_t begin = at == 0 ? 0 : ends_[at - 1], size = ends_[at] - begin;
    const uint64_t bytes = std::min(block_bytes_, bytes_ - index * block_bytes_);
    const uint64_t most = compressor_ == VtkXmlCompressor::zlib  ? kMostDeflateExpansion
                          : compressor_ == VtkXmlCompressor::lz4 ? uint64_t{kMostCopyExpansion}
                                                                 : kMostLzmaExpansion;
    held_.reset();
    if (size > 2 * kMaxBlockBytes || bytes / most > size) return damaged_block(index);
    stored_.resize(static_cast<size_t>(size));
    if (auto read = read_stored(begin, stored_); !read) return read;
    block_.resize(static_cast<size_t>(bytes));
    if (!decompress()) return damaged_block(index);
    held_ = index;
    return {};
  }

  bool decompress() {
    if (compressor_ == VtkXmlCompressor::lz4) return decompress_lz4(stored_, block_);
#ifndef __EMSCRIPTEN__
    if (compressor_ == VtkXmlCompressor::lzma) return decompress_xz(stored_, block_);
#endif
    const std::span<const uint8_t> in(reinterpret_cast<const uint8_t*>(stored_.data()),
                                      stored_.size());
    const std::span<uint8_t> out(reinterpret_cast<uint8_t*>(block_.data()), block_.size());
    return zlib_.inflate(in, out) == ZlibInflater::Outcome::exact;
  }

  tl::unexpected<Error> damaged_block(uint64_t index) const {
    return damaged(fmt::format("the compressed block {} is damaged", index));
  }

  std::unique_ptr<ByteReader> file_;
  std::filesystem::path path_;
  std::string name_;
  VtkXmlCompressor compressor_;
  bool is_base64_;
  uint64_t begin_, end_;       ///< of the numbers before the values, later of the blocks
  uint64_t values_begin_ = 0;  ///< from begin_ on
  uint64_t bytes_ = 0;
  uint64_t block_bytes_ = 0;
  std::vector<uint64_t> ends_;  ///< of the compressed blocks; empty: uncompressed
  std::optional<uint64_t> held_;
  std::vector<std::byte> stored_, block_;
  ZlibInflater zlib_;
  std::array<unsigned char, 16 * 1024> characters_;
};

/// The limit of values in text form is the next tag.
Result<std::unique_ptr<ByteReader>> open_text(const VtkXmlFile& file, const VtkXmlArray& array,
                                              uint64_t bytes) {
  const uint64_t values = bytes / voxel_bytes(*array.type);
  if (array.words != values) {
    return malformed_vtk_xml(
        file.path, fmt::format("expected {} values in the array '{}', found {}", values, array.name,
                               array.words));
  }
  return open_text_voxels(file.path, array.begin, *array.type, array.end);
}

/// The bytes of a file from an offset on.
class PlainBytes : public ByteReader {
 public:
  PlainBytes(std::unique_ptr<ByteReader> file, uint64_t begin, uint64_t bytes)
      : file_(std::move(file)), begin_(begin), bytes_(bytes) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    return file_->read(begin_ + offset, out);
  }
  bool is_random_access() const override { return true; }
  uint64_t size_limit() const override { return bytes_; }
  Result<uint64_t> count_after(uint64_t offset, uint64_t most) override {
    return std::min(most, bytes_ - std::min(bytes_, offset));
  }
  uint64_t available_bytes() override { return bytes_; }
  std::vector<std::filesystem::path> files() const override { return file_->files(); }

 private:
  std::unique_ptr<ByteReader> file_;
  uint64_t begin_, bytes_;
};

Result<std::unique_ptr<ByteReader>> open_bytes(const VtkXmlFile& file, const VtkXmlArray& array,
                                               uint64_t bytes) {
  if (array.end - array.begin != bytes) {
    const size_t size = voxel_bytes(*array.type);
    return malformed_vtk_xml(
        file.path, fmt::format("expected {} values in the array '{}', found {}", bytes / size,
                               array.name, (array.end - array.begin) / size));
  }
  auto plain = open_plain(file.path);
  if (!plain) return plain;
  return std::make_unique<PlainBytes>(std::move(*plain), array.begin, bytes);
}

}  // namespace

Result<std::unique_ptr<ByteReader>> open_vtk_xml_array(const VtkXmlFile& file,
                                                       const VtkXmlArray& array, uint64_t bytes) {
  if (array.format == VtkXmlArray::Format::ascii) return open_text(file, array, bytes);
  if (array.format == VtkXmlArray::Format::plain) return open_bytes(file, array, bytes);
#ifdef __EMSCRIPTEN__
  if (file.compressor == VtkXmlCompressor::lzma) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected values compressed by ZLib or LZ4, found LZMA: build the "
                            "store with the program (isosplat build), and open that",
                            file.path.string()));
  }
#endif
  auto plain = open_plain(file.path);
  if (!plain) return tl::unexpected(plain.error());
  auto reader = std::make_unique<ArrayBytes>(file, array, std::move(*plain));
  if (auto opened = reader->open(file, bytes); !opened) return tl::unexpected(opened.error());
  return reader;
}

}  // namespace isosplat::import
