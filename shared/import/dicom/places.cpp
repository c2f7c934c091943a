#include "shared/import/dicom/places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/dicom/mosaic.h"

namespace isosplat::import::dicom {
namespace {

bool is_finite(Vec3d v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_spacing(double s) {
  return s > 0 && s < 1e6;
}

/// The axis that a letter of Patient Orientation names (PS3.3, C.7.6.1.1.1); zeros for others.
Vec3d axis_of(std::string_view letters) {
  switch (letters.empty() ? ' ' : letters.front()) {
    case 'L':
      return {1, 0, 0};
    case 'R':
      return {-1, 0, 0};
    case 'P':
      return {0, 1, 0};
    case 'A':
      return {0, -1, 0};
    case 'H':
      return {0, 0, 1};
    case 'F':
      return {0, 0, -1};
    default:
      return {0, 0, 0};
  }
}

class PlaceReader {
 public:
  PlaceReader(const FrameGroups& groups, const std::filesystem::path& path, Image& image)
      : groups_(groups), data_(groups.data()), path_(path), image_(image) {}

  Result<void> read_place(size_t i, Frame& frame) {
    const Item* plane = groups_.find(i, kPlanePositionSequence);
    Tag tag = kImagePosition;
    if (!plane) {
      plane = groups_.find(i, kPlanePositionVolumeSequence);
      if (plane) tag = kVolumePosition;
    }
    if (!plane && image_.frames == 1) plane = &data_;
    if (plane) {
      const auto position = vector_at(*plane, tag, 0, 3, "position");
      if (!position) return tl::unexpected(position.error());
      frame.is_placed = position->has_value();
      frame.position = position->value_or(Vec3d{0, 0, 0});
    }
    const Item* orientation = groups_.find(i, kPlaneOrientationSequence);
    tag = kImageOrientation;
    if (!orientation) {
      orientation = groups_.find(i, kPlaneOrientationVolumeSequence);
      if (orientation) tag = kVolumeOrientation;
    }
    const auto read = read_orientation(orientation ? *orientation : data_, tag, frame);
    if (!read) return tl::unexpected(read.error());
    frame.is_oriented = *read;
    if (!*read && frame.is_placed) {
      return malformed("it has slice positions, but no slice orientation");
    }
    return {};
  }

  void read_spacing(size_t i, Frame& frame) {
    const Item* measures = groups_.find(i, kPixelMeasuresSequence);
    std::vector<double> spacing;
    if (measures) spacing = measures->numbers(kPixelSpacing);
    if (spacing.size() < 2) spacing = data_.numbers(kPixelSpacing);
    if (spacing.size() < 2) spacing = ultrasound_spacing();
    if (spacing.size() < 2) {
      for (const Tag other : {kImagerPixelSpacing, kNominalScannedPixelSpacing}) {
        if (spacing.size() >= 2) break;
        spacing = data_.numbers(other);
      }
      if (spacing.size() >= 2) {
        add_note(image_,
                 "the pixel spacing is measured at the detector, and is smaller in the object by "
                 "the magnification; --spacing sets another spacing");
      }
    }
    if (spacing.size() < 2) spacing = spacing_of_ratio();
    if (spacing.size() >= 2 && is_spacing(spacing[0]) && is_spacing(spacing[1])) {
      frame.spacing_y = spacing[0];  // the row spacing is the first value
      frame.spacing_x = spacing[1];
    }
  }

  Result<void> place_together(std::vector<Frame>& frames) {
    if (frames.size() < 2) {
      if (!frames.front().is_placed) assume_orientation(frames);
      return {};
    }
    const auto placed = std::count_if(frames.begin(), frames.end(),
                                      [](const Frame& frame) { return frame.is_placed; });
    if (placed == static_cast<std::ptrdiff_t>(frames.size())) return {};
    if (placed > 0) return malformed("some of its frames have a position, others have none");

    const Item* first = &data_;
    if (const Item* detector = data_.first_item(kDetectorInformation)) {
      if (detector->find(kImagePosition)) first = detector;
      for (Frame& frame : frames) {
        if (frame.is_oriented && first == &data_) break;
        const auto read = read_orientation(*detector, kImageOrientation, frame);
        if (!read) return tl::unexpected(read.error());
        frame.is_oriented = frame.is_oriented || *read;
      }
    }
    const auto position = vector_at(*first, kImagePosition, 0, 3, "position");
    if (!position) return tl::unexpected(position.error());
    const Vec3d origin = position->value_or(Vec3d{0, 0, 0});
    assume_orientation(frames);
    const auto along = data_.find(kGridFrameOffsets)      ? dose_offsets(frames, origin)
                       : data_.find(kSliceLocationVector) ? location_offsets(frames)
                                                          : even_offsets(frames);
    if (!along) return tl::unexpected(along.error());
    for (size_t i = 0; i < frames.size(); ++i) {
      frames[i].position = origin + (*along)[i];
      frames[i].is_placed = true;
    }
    if (!*position) {
      add_note(image_, "the file has no position for its first frame: 0, 0, 0 is assumed");
    }
    return {};
  }

  /// Sets missing orientations from the letters of Patient Orientation, or else to x and y.
  void assume_orientation(std::vector<Frame>& frames) {
    const std::string_view letters = data_.text(kPatientOrientation);
    const size_t middle = letters.find('\\');
    const bool has_both = middle != letters.npos;
    const Vec3d row = axis_of(letters.substr(0, middle));
    const Vec3d column = has_both ? axis_of(letters.substr(middle + 1)) : Vec3d{0, 0, 0};
    const bool is_stated = length(cross(row, column)) > 0;
    for (Frame& frame : frames) {
      if (frame.is_oriented) continue;
      if (is_stated) {
        frame.row = row;
        frame.column = column;
        add_note(image_,
                 fmt::format("the orientation is stated by letters only (Patient Orientation {}\\{}"
                             "): rows and columns are taken along the axes of the patient",
                             letters.substr(0, middle), letters.substr(middle + 1)));
      } else {
        add_note(image_,
                 "the file has no orientation (Image Orientation): rows along x and columns along "
                 "y are assumed");
      }
    }
  }

  Result<void> place_tiles(std::vector<Frame>& frames) {
    const auto mosaic = read_mosaic(data_);
    if (!mosaic) {
      refuse_image(image_, Status::unsupported_format,
                   "expected a slice per frame, or a Siemens mosaic with its CSA header, found a "
                   "mosaic that does not state the number of its slices: the header was probably "
                   "removed when the files were anonymized; use the original files");
      return {};
    }
    const int across = static_cast<int>(std::ceil(std::sqrt(mosaic->slices)));
    if (frames.size() != 1 || image_.columns % across != 0 || image_.rows % across != 0) {
      return malformed(
          fmt::format("expected a mosaic of {} slices in {} rows and columns, found "
                      "{} frames of {} × {} pixels",
                      mosaic->slices, across, frames.size(), image_.columns, image_.rows));
    }
    Frame first = frames.front();
    if (!first.is_placed || !(first.spacing_x > 0)) {
      return malformed("a mosaic needs a position, an orientation and a pixel spacing");
    }
    image_.columns /= across;
    image_.rows /= across;
    // The position is that of a slice as large as the mosaic, with the same centre as the slices.
    first.position = first.position +
                     first.row * (first.spacing_x * (image_.stored_columns - image_.columns) / 2) +
                     first.column * (first.spacing_y * (image_.stored_rows - image_.rows) / 2);
    const Vec3d normal = cross(first.row, first.column);
    double direction = 1;
    if (mosaic->normal) {
      direction = dot(normal, *mosaic->normal);
      if (std::abs(std::abs(direction) - 1) > 0.01) {
        return malformed("the normal of its mosaic is not that of its orientation");
      }
    } else {
      add_note(image_,
               "the file does not state the normal of its slices (CSA header): the first slice of "
               "the mosaic is taken as the first along row × column");
    }
    const Vec3d step = normal * std::copysign(frame_distance(), direction);
    frames.assign(static_cast<size_t>(mosaic->slices), first);
    for (size_t i = 0; i < frames.size(); ++i) {
      frames[i].tile = static_cast<uint32_t>(i);
      frames[i].position = first.position + step * static_cast<double>(i);
    }
    return {};
  }

 private:
  tl::unexpected<Error> malformed(std::string_view why) const { return contradiction(path_, why); }

  /// The components of a vector; nothing if the element is absent. Errors: malformed_volume.
  Result<std::optional<Vec3d>> vector_at(const Item& item, Tag tag, size_t first, size_t count,
                                         const char* name) const {
    const Element* element = item.find(tag);
    if (!element || (element->numbers.empty() && item.text(tag).empty())) return std::nullopt;
    const std::vector<double> n = item.numbers(tag);
    if (n.size() != count) {
      return malformed(
          fmt::format("expected {} numbers as its {}, found {}", count, name, n.size()));
    }
    const Vec3d v{n[first], n[first + 1], n[first + 2]};
    if (!is_finite(v)) {
      return malformed(fmt::format("its {} has values that are not finite numbers", name));
    }
    return v;
  }

  /// False if the item has no orientation.
  Result<bool> read_orientation(const Item& item, Tag tag, Frame& frame) const {
    const auto row = vector_at(item, tag, 0, 6, "orientation");
    if (!row) return tl::unexpected(row.error());
    const auto column = vector_at(item, tag, 3, 6, "orientation");
    if (!column) return tl::unexpected(column.error());
    if (!*row || !*column) return false;
    const Vec3d r = **row, c = **column;
    const double lengths[] = {length(r), length(c)};
    const bool is_unit = std::abs(lengths[0] - 1) < 0.01 && std::abs(lengths[1] - 1) < 0.01;
    if (!is_unit || std::abs(dot(r, c)) > 0.01) {
      return malformed("its rows and columns are not perpendicular unit vectors");
    }
    // Removes rounding errors: makes both vectors unit length and perpendicular.
    frame.row = r * (1 / lengths[0]);
    const Vec3d across = c - frame.row * dot(c, frame.row);
    frame.column = across * (1 / length(across));
    return true;
  }

  /// The spacing of the only calibrated region of an ultrasound image (PS3.3, C.8.5.5); empty if
  /// there is none.
  std::vector<double> ultrasound_spacing() const {
    constexpr double kCentimetres = 3;
    const Element* regions = data_.find(kUltrasoundRegions);
    if (!regions || regions->items.size() != 1) return {};
    const Item& region = regions->items.front();
    const auto dx = region.number(kPhysicalDeltaX), dy = region.number(kPhysicalDeltaY);
    if (!dx || !dy || region.number(kPhysicalUnitsX) != kCentimetres ||
        region.number(kPhysicalUnitsY) != kCentimetres) {
      return {};
    }
    return {10 * std::abs(*dy), 10 * std::abs(*dx)};
  }

  /// A spacing with the ratio that the file states; empty if it states none.
  std::vector<double> spacing_of_ratio() {
    const std::vector<double> ratio = data_.numbers(kPixelAspectRatio);
    if (ratio.size() != 2 || !(ratio[0] > 0) || !(ratio[1] > 0)) return {};
    add_note(
        image_,
        "the file states only the ratio of its pixel spacings (Pixel Aspect Ratio): 1 mm along "
        "rows is assumed; --spacing sets another");
    return {ratio[0] / ratio[1], 1};
  }

  /// Frame offsets of a dose grid relative to the first frame (PS3.3, C.8.8.3.2). If the first
  /// value is 0, the values are offsets along the normal; if it is the z of the position, they are
  /// z coordinates.
  Result<std::vector<Vec3d>> dose_offsets(const std::vector<Frame>& frames, Vec3d origin) const {
    const auto offsets = numbers_of_frames(kGridFrameOffsets, frames.size(), "offsets of frames");
    if (!offsets) return tl::unexpected(offsets.error());
    const Vec3d normal = cross(frames[0].row, frames[0].column);
    const bool is_relative = offsets->front() == 0;
    const bool is_z = std::abs(offsets->front() - origin.z) < 1e-3 && std::abs(normal.z) > 0.999;
    if (!is_relative && !is_z) {
      return malformed(
          fmt::format("its frame offsets begin with {}, which is neither 0 nor the z of "
                      "its position, {}",
                      offsets->front(), origin.z));
    }
    std::vector<Vec3d> along;
    for (const double offset : *offsets) {
      along.push_back(is_relative ? normal * offset : Vec3d{0, 0, offset - offsets->front()});
    }
    return along;
  }

  /// The numbers of an element with one for each frame. Errors: malformed_volume.
  Result<std::vector<double>> numbers_of_frames(Tag tag, size_t frames, const char* what) const {
    std::vector<double> numbers = data_.numbers(tag);
    if (numbers.size() != frames) {
      return malformed(fmt::format("it has {} frames and {} {}", frames, numbers.size(), what));
    }
    if (!std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); })) {
      return malformed(fmt::format("its {} are not numbers", what));
    }
    return numbers;
  }

  /// Frame offsets by the slice locations of the frames.
  Result<std::vector<Vec3d>> location_offsets(const std::vector<Frame>& frames) {
    const auto places = numbers_of_frames(kSliceLocationVector, frames.size(), "slice locations");
    if (!places) return tl::unexpected(places.error());
    add_note(image_,
             "the frames have slice locations instead of positions: they are taken as positions "
             "along row × column");
    std::vector<Vec3d> along;
    for (size_t i = 0; i < frames.size(); ++i) {
      const Vec3d normal = cross(frames[i].row, frames[i].column);
      along.push_back(normal * ((*places)[i] - places->front()));
    }
    return along;
  }

  /// Frame offsets relative to the first frame, with equal steps along the normal. A negative
  /// spacing goes against the normal (PS3.3, C.8.4.15).
  Result<std::vector<Vec3d>> even_offsets(const std::vector<Frame>& frames) {
    const double spacing = frame_distance();
    std::vector<double> slices;
    if (data_.find(kSliceVector)) {
      auto numbers = numbers_of_frames(kSliceVector, frames.size(), "numbers of slices");
      if (!numbers) return tl::unexpected(numbers.error());
      slices = std::move(*numbers);
    } else {
      add_note(image_,
               "the frames have no positions: they are stacked in the order of the file, along "
               "row × column");
    }
    std::vector<Vec3d> along;
    for (size_t i = 0; i < frames.size(); ++i) {
      const double step = slices.empty() ? static_cast<double>(i) : slices[i] - 1;
      along.push_back(cross(frames[i].row, frames[i].column) * (spacing * step));
    }
    return along;
  }

  /// The stated distance between frames; may be negative. Without one, notes the assumption.
  double frame_distance() {
    const auto spacing = groups_.number(0, kPixelMeasuresSequence, kSpacingBetweenSlices);
    if (spacing && *spacing != 0) return *spacing;
    const auto thickness = groups_.number(0, kPixelMeasuresSequence, kSliceThickness);
    const bool has_thickness = thickness && *thickness > 0;
    const double assumed = has_thickness ? *thickness : 1;
    add_note(image_, fmt::format("the file has no distance between frames (Spacing Between "
                                 "Slices): {} mm is assumed, {}; --spacing sets another",
                                 assumed,
                                 has_thickness ? "the slice thickness"
                                               : "since the file has no slice thickness either"));
    return assumed;
  }

  const FrameGroups& groups_;
  const Item& data_;
  const std::filesystem::path& path_;
  Image& image_;
};

}  // namespace

Result<void> read_places(const FrameGroups& groups, const std::filesystem::path& path, Image& image,
                         std::vector<Frame>& frames) {
  PlaceReader reader(groups, path, image);
  for (size_t i = 0; i < frames.size(); ++i) {
    if (auto r = reader.read_place(i, frames[i]); !r) return r;
    reader.read_spacing(i, frames[i]);
  }
  return {};
}

Result<void> place_together(const FrameGroups& groups, const std::filesystem::path& path,
                            Image& image, std::vector<Frame>& frames) {
  return PlaceReader(groups, path, image).place_together(frames);
}

Result<void> place_tiles(const FrameGroups& groups, const std::filesystem::path& path, Image& image,
                         std::vector<Frame>& frames) {
  return PlaceReader(groups, path, image).place_tiles(frames);
}

}  // namespace isosplat::import::dicom
