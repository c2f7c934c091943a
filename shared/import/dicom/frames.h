#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/import/dicom/image.h"

// Frames with positions and values, from the files of a folder or from one file. Single-frame files
// of CT, MR and PET, multi-frame files with functional groups (Enhanced CT, MR, PET), nuclear
// medicine and dose grids all become the same kind of frames (PS3.3, C.7.6).
namespace isosplat::import::dicom {

/// Attributes that distinguish frames at the same position: time, echo, … NaN if the file does not
/// have the attribute. Text is replaced by a number that identifies it.
enum class Key : uint8_t {
  temporal_position,
  frame_type,
  quantity,
  echo,
  b_value,
  gradient,
  inversion_time,
  energy_window,
  detector,
  rr_interval,
  time_slot,
  dimension_1,
  dimension_2,
  dimension_3,
  dimension_4,
  dimension_5,
  trigger_time,
  acquisition,
  acquisition_time,
  reference_time,
  content_time,
  instance,
};
inline constexpr size_t kKeys = static_cast<size_t>(Key::instance) + 1;

struct Frame {
  uint32_t image = 0;   ///< index in Collection::images
  uint32_t index = 0;   ///< index of the frame in its image
  uint32_t tile = 0;    ///< index of the slice in the frame, which is a mosaic
  uint32_t series = 0;  ///< index in Collection::series
  uint32_t stack = 0;   ///< index of the stack's name in Collection::texts
  int segment = 0;      ///< number of its segment; 0: none
  bool is_placed = false;
  bool is_oriented = false;
  bool is_localizer = false;
  bool is_inverse = false;              ///< MONOCHROME1: low values are displayed bright
  Vec3d position{0, 0, 0};              ///< of the centre of the first pixel, mm, LPS
  Vec3d row{1, 0, 0};                   ///< direction along a row
  Vec3d column{0, 1, 0};                ///< direction along a column
  double spacing_x = 0, spacing_y = 0;  ///< distance between pixels, mm; 0: unknown
  double slope = 1, intercept = 0;      ///< value = intercept + slope · stored
  double location = std::numeric_limits<double>::quiet_NaN();  ///< Slice Location; NaN: absent
  std::array<double, kKeys> keys{};
};

/// A file without pixels, and its SOP class.
struct Pixelless {
  std::string file, sop_class;
};

struct Series {
  std::string uid, modality, description;
  std::string date;  ///< YYYYMMDD, as DICOM writes it; empty: not stated
};

/// The frames of several files.
struct Collection {
  std::vector<Image> images;
  std::vector<Frame> frames;
  std::vector<Series> series;
  std::vector<Pixelless> without_pixels;
  std::vector<std::string> slides;  ///< "9 tiles of a whole-slide image of …", for each such file
  std::vector<std::string> texts{""};
  std::map<std::string, uint32_t> series_ids, text_ids;
};

/// How add_frames classified a file.
enum class FileContent : uint8_t {
  frames,     ///< its frames were added to the collection
  no_pixels,  ///< a report, a plan, an index, …
  colour,     ///< a colour picture, not scalar values
  tiles,      ///< tiles of a whole-slide image: Collection::slides describes them
};

/// Adds a file's frames. Errors: malformed_volume if elements are missing or contradict each other,
/// io_error.
Result<FileContent> add_frames(const Elements& elements, const std::filesystem::path& path,
                               Collection& to);

}  // namespace isosplat::import::dicom
