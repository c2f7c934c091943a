#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "shared/import/dicom/element_input.h"
#include "shared/import/dicom/elements.h"
#include "shared/import/dicom/tags.h"

// How the headers and the values of elements are encoded (PS3.5, 6.2 and 7.1).
namespace isosplat::import::dicom {

/// The length of a sequence, an item or encapsulated pixels that a delimiter ends.
inline constexpr uint32_t kUndefinedLength = 0xffffffff;

/// The encoding of a data set.
struct Syntax {
  bool is_explicit = true;
  bool big_endian = false;
};

/// The header of an element.
///
///   implicit:              | tag (4) | length (4) |
///   explicit, short forms: | tag (4) | VR (2) | length (2) |
///   explicit, long forms:  | tag (4) | VR (2) | 0 (2) | length (4) |
struct ElementHeader {
  Tag tag = 0;
  std::array<char, 2> vr{};  ///< zeros if the file has no VR
  uint32_t length = 0;

  bool is_vr(std::string_view name) const { return std::string_view(vr.data(), 2) == name; }
};

/// Whether a text is a value representation.
bool is_vr(std::string_view name);

inline uint16_t u16_at(const std::byte* bytes, bool big_endian) {
  uint16_t value;
  std::memcpy(&value, bytes, sizeof value);
  return big_endian ? __builtin_bswap16(value) : value;
}

inline uint32_t u32_at(const std::byte* bytes, bool big_endian) {
  uint32_t value;
  std::memcpy(&value, bytes, sizeof value);
  return big_endian ? __builtin_bswap32(value) : value;
}

inline Tag tag_at(const std::byte* bytes, bool big_endian) {
  return Tag{u16_at(bytes, big_endian)} << 16 | u16_at(bytes + 2, big_endian);
}

/// Reads a header. `end`: of the enclosing item. Errors: those of the input, malformed_volume.
Result<ElementHeader> read_header(ElementInput& in, Syntax syntax, uint64_t end);

/// The representation of a value, from its VR, or from the registry if there is no VR.
Kind kind_of(const ElementHeader& header, Kind registered);

/// An element with the value that these bytes encode.
Element make_element(Syntax syntax, Tag tag, Kind kind, std::span<const std::byte> bytes);

}  // namespace isosplat::import::dicom
