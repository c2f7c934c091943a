#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "native/import/dicom_image.h"
#include "shared/base/vec3.h"

// What the files of a folder, or one file, hold: frames with their places and their values. The
// single-frame files of CT, MR and PET, the multi-frame ones with functional groups (Enhanced CT,
// MR, PET), nuclear medicine and dose grids all come to the same frames (PS3.3, C.7.6).
namespace isosplat::dicom {

/// What frames can differ in that share their place: the moment, the echo, … NaN where the file
/// does not say. Text is replaced by a number that stands for it.
enum class Key : uint8_t {
  temporal_position,
  frame_type,
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
  uint32_t image = 0;   ///< in Collection::images
  uint32_t index = 0;   ///< in its image
  uint32_t series = 0;  ///< in Collection::series
  uint32_t stack = 0;   ///< the stack's name, in Collection::texts
  bool is_placed = false;
  bool is_localizer = false;
  bool is_inverse = false;              ///< MONOCHROME1: low values are meant to be shown bright
  Vec3d position{0, 0, 0};              ///< of the centre of the first pixel, mm, LPS
  Vec3d row{1, 0, 0};                   ///< the direction along a row
  Vec3d column{0, 1, 0};                ///< the direction along a column
  double spacing_x = 0, spacing_y = 0;  ///< between pixels, mm; 0: not said
  double slope = 1, intercept = 0;      ///< value = intercept + slope · stored
  std::array<double, kKeys> keys{};
};

/// A file that has no pixels, and its kind.
struct Pixelless {
  std::string file, sop_class;
};

struct Series {
  std::string uid, modality, description;
};

/// The frames of any number of files.
struct Collection {
  std::vector<Image> images;
  std::vector<Frame> frames;
  std::vector<Series> series;
  std::vector<Pixelless> without_pixels;
  std::vector<std::string> texts{""};
  std::map<std::string, uint32_t> series_ids, text_ids;
};

/// What became of a file.
enum class Verdict : uint8_t {
  taken,      ///< its frames are in the collection
  no_pixels,  ///< a report, a plan, an index, …
  colour,     ///< a picture, not scalar values
};

/// Adds a file's frames. Errors: malformed_volume where elements are missing or contradict each
/// other, io_error.
Result<Verdict> add_frames(const Elements& elements, const std::filesystem::path& path,
                           Collection& to);

}  // namespace isosplat::dicom
