#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "native/import/byte_reader.h"
#include "native/import/dicom_tags.h"

// The elements of a DICOM file up to its pixels (PS3.5 and PS3.10).
namespace isosplat::dicom {

class Item;

/// An element that dicom_tags.h lists.
struct Element {
  Tag tag = 0;
  std::string text;             ///< text values as they are, several separated by backslashes
  std::vector<double> numbers;  ///< binary values
  std::vector<Item> items;      ///< of a sequence
};

/// A data set, or an item of a sequence.
class Item {
 public:
  /// Null where the element is absent.
  const Element* find(Tag tag) const;

  /// The text of an element without the spaces around it; empty where it is absent.
  std::string_view text(Tag tag) const;

  /// The values of a numeric element; those that are not numbers are NaN. Empty where it is absent.
  std::vector<double> numbers(Tag tag) const;

  /// The first value of a numeric element; nothing where it is absent or not a finite number.
  std::optional<double> number(Tag tag) const;

  /// The first item of a sequence; null where it is absent or empty.
  const Item* first_item(Tag sequence) const;

  std::vector<Element> elements;  ///< in the file's order
};

/// How the pixels follow: native pixels are at an offset, encapsulated ones in fragments.
struct PixelPlace {
  static constexpr uint64_t kUndefined = std::numeric_limits<uint64_t>::max();

  Tag tag = 0;            ///< kPixels, kFloatPixels, kDoublePixels; 0: the file has none
  uint64_t offset = 0;    ///< in the file, or in what its data set inflates to
  uint64_t bytes = 0;     ///< as the element says; kUndefined for fragments
  bool in_words = false;  ///< VR OW: big-endian files swap the bytes of each 16-bit word
};

struct Elements {
  Item data;  ///< with the transfer syntax
  std::string transfer_syntax;
  PixelPlace pixels;
  bool deflated = false;        ///< `pixels.offset` counts in the inflated data set
  uint64_t deflated_start = 0;  ///< where the deflated data set starts in the file
};

/// Whether a file is DICOM: it has the prefix "DICM", or begins as a data set without one does.
/// `beginning`: its first bytes, 140 or more where it has as many.
bool looks_like_dicom(std::string_view beginning);

/// Reads the elements of a file up to its pixels; values that nobody asks for are skipped without
/// being read. Holds what dicom_tags.h lists, whatever else the file has. Errors: io_error,
/// truncated where the file ends within an element, malformed_volume.
Result<Elements> read_elements(const std::filesystem::path& path);

}  // namespace isosplat::dicom
