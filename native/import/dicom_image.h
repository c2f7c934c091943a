#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "native/import/dicom_elements.h"

// What a file's pixels are, and whether the file has them all (PS3.3, C.7.6.3).
namespace isosplat::dicom {

/// No file has more frames.
inline constexpr double kMaxFrames = 1 << 20;

/// A file's pixels.
struct Image {
  std::string file;
  std::string transfer_syntax;
  PixelPlace pixels;
  bool deflated = false;
  uint64_t deflated_start = 0;
  int32_t columns = 0, rows = 0, frames = 1;
  int allocated = 16, stored = 16, high_bit = 15;  ///< bits of a pixel
  bool is_signed = false, is_float = false;
  bool is_encapsulated = false;
  bool cut_off = false;             ///< the file ends before its last pixel
  bool has_surplus = false;         ///< there are pixels for at least one frame more
  Status refusal = Status::ok;      ///< why no volume can be made of it; the reason in `obstacle`
  std::string obstacle;             ///< empty: none
  std::string assumption;           ///< a note, where a place was assumed; empty: none
  std::string instance_uid;         ///< of the SOP instance
  std::string sop_class;            ///< its kind
  double stated_slice_spacing = 0;  ///< SpacingBetweenSlices; 0: not said
  /// Stored values from `padding` to `padding_limit` (to itself where there is no limit) are said
  /// to be no values.
  std::optional<double> padding, padding_limit;
};

/// Reads what a file with grey pixels says of them. Where no volume can be made of it, the image
/// has an obstacle. Errors: malformed_volume where elements are missing or contradict each other,
/// io_error.
Result<Image> read_image(const Elements& elements, const std::filesystem::path& path);

/// Gives an image an obstacle, unless it has one.
void refuse_image(Image& image, Status status, std::string why);

/// Of which kind a data set is (PS3.4, B.5); empty where it does not say.
std::string_view sop_class(const Item& data);

/// The error for a header that contradicts itself or lacks something.
tl::unexpected<Error> contradiction(const std::filesystem::path& path, std::string_view why);

}  // namespace isosplat::dicom
