#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/bytes/byte_reader.h"
#include "shared/import/dicom/tags.h"

namespace isosplat::import::dicom {

/// Reads the bytes of a data set from front to back, through a small window. Errors: those of the
/// reader, and truncated where the bytes end early.
class ElementInput {
 public:
  /// `end`: the end of the bytes; unknown for deflated data. Reader and path must outlive it.
  ElementInput(ByteReader& file, const std::filesystem::path& path, uint64_t start,
               std::optional<uint64_t> end)
      : file_(file), path_(path), position_(start), end_(end) {}

  /// Offset of the next byte.
  uint64_t position() const { return position_; }
  void move_to(uint64_t position) { position_ = position; }

  /// The end of the bytes; the greatest number if it is unknown.
  uint64_t end() const { return end_.value_or(std::numeric_limits<uint64_t>::max()); }

  /// Whether this many more bytes exist. If the end is unknown, large counts are checked by
  /// reading.
  Result<bool> has(uint64_t bytes);

  /// Copies bytes without advancing the position.
  Result<void> look(std::span<std::byte> out);

  Result<void> read(std::span<std::byte> out);

  /// Checks the end of a deflated data set: a skipped element may extend beyond it.
  Result<void> check_end();

  /// The error malformed_volume at this position.
  tl::unexpected<Error> malformed(std::string_view why) const;

  /// The error truncated. `needed`: size of the element `tag` in bytes; 0 if its tag is not known.
  tl::unexpected<Error> ends_early(Tag tag, uint64_t needed) const;

 private:
  Result<bool> fill(size_t bytes);

  ByteReader& file_;
  const std::filesystem::path& path_;
  uint64_t position_;
  std::optional<uint64_t> end_;
  std::vector<std::byte> window_;  ///< buffered bytes of the input
  uint64_t window_start_ = 0;
};

}  // namespace isosplat::import::dicom
