#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

/// An entry of a directory. If its type is known, its values lie inside the file.
struct TiffEntry {
  uint16_t tag = 0;
  uint16_t type = 0;
  uint64_t count = 0;
  uint64_t at = 0;  ///< offset of the first value
};

struct TiffDirectory {
  std::vector<TiffEntry> entries;
  uint64_t next = 0;  ///< offset of the next directory; 0 if this is the last one

  /// The first entry with this tag; null: none has it.
  const TiffEntry* find(uint16_t tag) const;
};

/// Reads the directories of a TIFF or BigTIFF file, of both byte orders (TIFF 6.0, section 2).
class TiffDirectoryReader {
 public:
  /// Errors: io_error, truncated.
  static Result<TiffDirectoryReader> open(const std::filesystem::path& path);

  bool big_endian() const { return big_endian_; }
  uint64_t file_bytes() const { return file_->size_limit(); }
  ByteReader& file() { return *file_; }

  /// 42: TIFF; 43: BigTIFF; other numbers are not TIFF files.
  uint16_t version() const { return version_; }

  /// Offset of the first directory. Nothing if the file ends before it.
  std::optional<uint64_t> first();

  /// Nothing if the directory is empty, or if it or one of its values is not inside the file.
  std::optional<TiffDirectory> read(uint64_t at);

  /// A value of type BYTE, SHORT, LONG, IFD, or one of their 8-byte forms.
  std::optional<uint64_t> number(const TiffEntry& entry, uint64_t index = 0);

  /// All values of the types of `number`, or none if the entry has another type or more than
  /// `max_count` values.
  std::vector<uint64_t> numbers(const TiffEntry& entry, uint64_t max_count = uint64_t{1} << 24);

  /// The first value of type RATIONAL, FLOAT or DOUBLE, or of one of the above.
  std::optional<double> real(const TiffEntry& entry);

  /// A text up to its first null; empty if it has more than `max_bytes`.
  std::string text(const TiffEntry& entry, uint64_t max_bytes);

 private:
  explicit TiffDirectoryReader(std::unique_ptr<ByteReader> file) : file_(std::move(file)) {}

  std::optional<uint64_t> word(uint64_t at, size_t bytes);
  uint64_t word_in(const std::byte* from, size_t bytes) const;
  bool is_inside(uint64_t at, uint64_t bytes) const;

  std::unique_ptr<ByteReader> file_;
  bool big_endian_ = false, big_tiff_ = false;
  uint16_t version_ = 0;
};

}  // namespace isosplat::import
