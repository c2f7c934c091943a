#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

/// Reads the lines of a file with a header and values, and skips values. `format`: its name, for
/// messages. Errors: those of the reader, and where stated.
class LineScanner {
 public:
  LineScanner(std::filesystem::path path, std::unique_ptr<ByteReader> file, std::string format);

  /// Offset of the next byte in the file.
  uint64_t position() const { return position_; }

  /// The next line, without its end. Nothing at the end of the file. Errors: malformed_volume for a
  /// line that is too long, which is probably binary values.
  Result<std::optional<std::string>> line();

  /// The words of the next line that is not empty. Empty at the end of the file. Errors: those of
  /// line().
  Result<std::vector<std::string>> next_words();

  /// The next byte, or −1 at the end of the file.
  Result<int> byte() { return take(); }

  /// Skips binary values. False if the file ends first.
  bool skip_bytes(uint64_t bytes);

  /// Skips numbers in text form. False if the file ends before or directly after the last number.
  Result<bool> skip_numbers(uint64_t count);

  /// The error malformed_volume at the current position.
  tl::unexpected<Error> malformed(const std::string& what) const;

 private:
  Result<int> take();

  std::filesystem::path path_;
  std::unique_ptr<ByteReader> file_;
  std::string format_;
  uint64_t position_ = 0;
  size_t next_ = 0, end_ = 0;
  std::array<char, 16 * 1024> buffer_;
};

}  // namespace isosplat::import
