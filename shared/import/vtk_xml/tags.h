#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "shared/core/base/status.h"
#include "shared/import/bytes/byte_reader.h"
#include "shared/import/text/xml_scanner.h"

namespace isosplat::import {

/// Reads the tags of an XML file one after the other, and counts the words between them. Needs
/// little memory, however long the text between tags is.
class XmlTags {
 public:
  explicit XmlTags(ByteReader& file) : file_(file) {}

  /// The next tag; its views are valid until the next call. Nothing at the end of the file, and
  /// after a tag of more than 64 KiB. Errors: those of the reader.
  Result<std::optional<XmlTag>> next();

  uint64_t begin() const { return begin_; }  ///< offset of the "<" of the last tag
  uint64_t end() const { return position_ - (filled_ - next_); }  ///< offset of the byte after it
  uint64_t words() const { return words_; }                       ///< words before the last tag

 private:
  Result<bool> fill();

  ByteReader& file_;
  std::string text_;
  uint64_t begin_ = 0, words_ = 0, position_ = 0;
  size_t next_ = 0, filled_ = 0;
  std::array<char, 16 * 1024> buffer_;
};

}  // namespace isosplat::import
