#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "shared/import/dicom/elements.h"

// Describes a file's pixels, and checks that the file has all of them (PS3.3, C.7.6.3).
namespace isosplat::import::dicom {

/// Upper limit of the number of frames in a file.
inline constexpr double kMaxFrames = 1 << 20;

/// The meaning of the pixels of a segmentation (PS3.3, C.8.20).
struct Segmentation {
  enum class Kind : uint8_t {
    none,        ///< the file is not a segmentation
    binary,      ///< each frame has one segment: 0 or 1
    fractional,  ///< each frame has one segment: from 0 to `max_fraction`, which stands for 1
    labels       ///< each pixel is the number of its segment
  };
  struct Segment {
    int number = 0;
    std::string label;
    std::string meaning = {};          ///< of its codes: type and modifier
    std::vector<double> cie_lab = {};  ///< L*, a*, b* in 16 bits each; or empty
  };
  Kind kind = Kind::none;
  std::vector<Segment> segments;
  int max_fraction = 255;
  std::string fraction_type;  ///< PROBABILITY or OCCUPANCY
  double background = 0;      ///< the stored value of pixels outside all segments
};

/// A file that is one of several parts of an image (PS3.3, C.7.6.16.1.1).
struct Concatenation {
  std::string uid;  ///< empty: the file is the whole image
  int number = 0;   ///< of this part, from 1
  int total = 0;    ///< 0: unknown
};

/// The pixels of a file.
struct Image {
  std::string file;
  std::string transfer_syntax;
  PixelPlace pixels;
  bool deflated = false;
  uint64_t deflated_start = 0;
  int32_t columns = 0, rows = 0;  ///< of a slice
  int32_t frames = 1;
  /// Size of a stored frame. The frame of a mosaic contains several slices, from left to right and
  /// top to bottom.
  int32_t stored_columns = 0, stored_rows = 0;
  int allocated = 16, stored = 16, high_bit = 15;  ///< bits of a pixel
  bool is_signed = false, is_float = false;
  bool is_encapsulated = false;
  bool cut_off = false;             ///< the file ends before its last pixel
  bool has_surplus = false;         ///< the file has pixels for at least one extra row
  Status refusal = Status::ok;      ///< the status of a refusal; `obstacle` has the reason
  std::string obstacle;             ///< reason for the refusal; empty: none
  std::vector<std::string> notes;   ///< assumptions, each once
  std::string instance_uid;         ///< SOP Instance UID
  std::string sop_class;            ///< SOP Class UID
  std::string frame_of_reference;   ///< Frame of Reference UID: of the positions; empty: unknown
  double stated_slice_spacing = 0;  ///< Spacing Between Slices; 0: absent
  double slice_thickness = 0;       ///< 0: absent
  /// Stored values from `padding` to `padding_limit` (equal to `padding` if the file gives no
  /// limit) are padding, not values.
  std::optional<double> padding, padding_limit;
  Segmentation segmentation;
  Concatenation concatenation;

  int32_t slices_across() const { return stored_columns / columns; }
};

/// Reads the description of a file's greyscale pixels or labels. If it cannot become a volume, the
/// image has an obstacle. Errors: malformed_volume if elements are missing or contradict each
/// other, io_error.
Result<Image> read_image(const Elements& elements, const std::filesystem::path& path);

/// Sets the obstacle of an image, unless it already has one.
void refuse_image(Image& image, Status status, std::string why);

/// Adds a note, unless the image has it, or has 32.
void add_note(Image& image, std::string note);

/// The SOP class of a data set (PS3.4, B.5); empty if absent.
std::string_view sop_class(const Item& data);

/// The error for a header that is incomplete or contradicts itself.
tl::unexpected<Error> contradiction(const std::filesystem::path& path, std::string_view why);

}  // namespace isosplat::import::dicom
