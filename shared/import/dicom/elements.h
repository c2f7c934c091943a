#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/dicom/tags.h"

// The elements of a DICOM file up to its pixels (PS3.5 and PS3.10).
namespace isosplat::import::dicom {

class Item;

/// An element that tags.h lists.
struct Element {
  Tag tag = 0;
  std::string text;             ///< text value; several values are separated by backslashes
  std::vector<double> numbers;  ///< binary values
  std::vector<Item> items;      ///< items of a sequence
};

/// A data set, or an item of a sequence.
class Item {
 public:
  /// Null if the element is absent.
  const Element* find(Tag tag) const;

  /// The text of an element without surrounding spaces; empty if it is absent.
  std::string_view text(Tag tag) const;

  /// The values of a numeric element; values that are not numbers are NaN. Empty if it is absent.
  std::vector<double> numbers(Tag tag) const;

  /// The first value of a numeric element; nothing if it is absent or not a finite number.
  std::optional<double> number(Tag tag) const;

  /// The first item of a sequence; null if it is absent or empty.
  const Item* first_item(Tag sequence) const;

  std::vector<Element> elements;  ///< in file order
};

/// The location of the pixels: native pixels at an offset, encapsulated ones in fragments.
struct PixelPlace {
  static constexpr uint64_t kUndefined = std::numeric_limits<uint64_t>::max();

  Tag tag = 0;            ///< kPixels, kFloatPixels, kDoublePixels; 0: the file has none
  uint64_t offset = 0;    ///< in the file, or in the inflated data set
  uint64_t bytes = 0;     ///< size of the element's value; kUndefined for fragments
  bool in_words = false;  ///< VR OW: big-endian files swap the bytes of each 16-bit word
};

struct Elements {
  Item data;  ///< including the transfer syntax
  std::string transfer_syntax;
  PixelPlace pixels;
  bool deflated = false;        ///< `pixels.offset` is relative to the inflated data set
  uint64_t deflated_start = 0;  ///< offset of the deflated data set in the file
};

/// Whether a file is DICOM: it has the prefix "DICM", or begins like a data set without the prefix.
/// `beginning`: its first bytes, at least 140 unless the file is shorter.
bool looks_like_dicom(std::string_view beginning);

/// Reads the elements of a file up to its pixels. Only elements that tags.h lists are kept in
/// memory; other values are skipped without being read. Errors: io_error, truncated if the file
/// ends within an element, malformed_volume.
Result<Elements> read_elements(const std::filesystem::path& path);

}  // namespace isosplat::import::dicom
