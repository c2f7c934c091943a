#include "shared/import/dicom_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "shared/import/dicom_image.h"

namespace isosplat::dicom {
namespace {

uint32_t text_id(Collection& collection, std::string_view text) {
  if (text.empty()) return 0;
  const auto [found, is_new] = collection.text_ids.try_emplace(
      std::string(text), static_cast<uint32_t>(collection.texts.size()));
  if (is_new) collection.texts.emplace_back(text);
  return found->second;
}

/// A label as a number; NaN for an empty label.
double text_key(Collection& collection, std::string_view text) {
  return text.empty() ? std::nan("") : text_id(collection, text);
}

/// Seconds since a fixed time, from a date "YYYYMMDD" (or "YYYY.MM.DD") and a time "HHMMSS.FFFFFF"
/// (or "HH:MM:SS"); NaN if there is no time.
double seconds_of(std::string_view date, std::string_view time) {
  const auto digits = [](std::string_view text) {
    std::string out;
    for (const char c : text) {
      if ((c >= '0' && c <= '9')) out += c;
      if (c == '+' || c == '-') break;
    }
    return out;
  };
  const std::string t = digits(time), d = digits(date);
  if (t.size() < 2) return std::nan("");
  const auto part = [](const std::string& text, size_t at, size_t count) {
    return at < text.size() ? std::stod(text.substr(at, count)) : 0.0;
  };
  double seconds = part(t, 0, 2) * 3600 + part(t, 2, 2) * 60 + part(t, 4, 2);
  if (t.size() > 6) seconds += std::stod("0." + t.substr(6, 9));
  // Days need not be exact, only ordered and distinct.
  if (d.size() >= 8) seconds += 86400 * (372 * part(d, 0, 4) + 31 * part(d, 4, 2) + part(d, 6, 2));
  return seconds;
}

double seconds_of(std::string_view date_time) {
  if (date_time.size() < 10) return std::nan("");
  return seconds_of(date_time.substr(0, 8), date_time.substr(8));
}

bool is_finite(Vec3d v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Reads the frames of one file into the collection.
class FileReader {
 public:
  FileReader(const Elements& elements, const std::filesystem::path& path, Collection& to)
      : elements_(elements), data_(elements.data), path_(path), to_(to) {
    shared_ = data_.first_item(kSharedGroups);
    if (const Element* groups = data_.find(kPerFrameGroups)) per_frame_ = &groups->items;
  }

  Result<FileContent> read() {
    if (elements_.pixels.tag == 0) {
      to_.without_pixels.push_back({path_.string(), std::string(sop_class(data_))});
      return FileContent::no_pixels;
    }
    photometric_ = data_.text(kPhotometric);
    const bool is_grey =
        photometric_.empty() || photometric_ == "MONOCHROME1" || photometric_ == "MONOCHROME2";
    if (!is_grey || data_.number(kSamplesPerPixel).value_or(1) != 1) return FileContent::colour;
    auto image = read_image(elements_, path_);
    if (!image) return tl::unexpected(image.error());
    image_ = std::move(*image);

    const auto frames = static_cast<size_t>(image_.frames);
    if (per_frame_ && !per_frame_->empty() && per_frame_->size() != frames) {
      return malformed(fmt::format("it has {} frames and {} items that describe them", frames,
                                   per_frame_->size()));
    }
    std::vector<Frame> made(frames);
    for (size_t i = 0; i < frames; ++i) {
      if (auto r = read_frame(i, made[i]); !r) return tl::unexpected(r.error());
    }
    if (auto r = place_together(made); !r) return tl::unexpected(r.error());
    to_.images.push_back(std::move(image_));
    to_.frames.insert(to_.frames.end(), made.begin(), made.end());
    return FileContent::frames;
  }

 private:
  tl::unexpected<Error> malformed(std::string_view why) const { return contradiction(path_, why); }

  /// The item of a functional group for a frame: the frame's own, or the item shared by all frames.
  const Item* group(size_t frame, Tag sequence) const {
    if (per_frame_ && frame < per_frame_->size()) {
      if (const Item* own = (*per_frame_)[frame].first_item(sequence)) return own;
    }
    return shared_ ? shared_->first_item(sequence) : nullptr;
  }

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

  Result<void> read_place(size_t i, Frame& frame) {
    const Item* plane = group(i, kPlanePositionSequence);
    Tag tag = kImagePosition;
    if (!plane) {
      plane = group(i, kPlanePositionVolumeSequence);
      if (plane) tag = kVolumePosition;
    }
    if (!plane && image_.frames == 1) plane = &data_;
    if (plane) {
      const auto position = vector_at(*plane, tag, 0, 3, "position");
      if (!position) return tl::unexpected(position.error());
      frame.is_placed = position->has_value();
      frame.position = position->value_or(Vec3d{0, 0, 0});
    }
    const Item* orientation = group(i, kPlaneOrientationSequence);
    tag = kImageOrientation;
    if (!orientation) {
      orientation = group(i, kPlaneOrientationVolumeSequence);
      if (orientation) tag = kVolumeOrientation;
    }
    return read_orientation(orientation ? *orientation : data_, tag, frame);
  }

  Result<void> read_orientation(const Item& item, Tag tag, Frame& frame) {
    const auto row = vector_at(item, tag, 0, 6, "orientation");
    if (!row) return tl::unexpected(row.error());
    const auto column = vector_at(item, tag, 3, 6, "orientation");
    if (!column) return tl::unexpected(column.error());
    if (!*row || !*column) {
      if (frame.is_placed && !is_volume_frame(tag)) {
        return malformed("it has slice positions, but no slice orientation");
      }
      return {};
    }
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
    return {};
  }

  static bool is_volume_frame(Tag tag) { return tag == kVolumeOrientation; }

  void read_spacing(size_t i, Frame& frame) {
    const Item* measures = group(i, kPixelMeasuresSequence);
    std::vector<double> spacing = (measures ? *measures : data_).numbers(kPixelSpacing);
    if (spacing.size() < 2 && !measures) {
      for (const Tag other : {kImagerPixelSpacing, kNominalScannedPixelSpacing}) {
        if (spacing.size() >= 2) break;
        spacing = data_.numbers(other);
      }
      if (spacing.size() >= 2) {
        image_.assumption =
            "the pixel spacing is measured at the detector, and is smaller in the object by the "
            "magnification; --spacing sets another spacing";
      }
    }
    const auto is_spacing = [](double s) { return s > 0 && s < 1e6; };
    if (spacing.size() >= 2 && is_spacing(spacing[0]) && is_spacing(spacing[1])) {
      frame.spacing_y = spacing[0];  // the row spacing is the first value
      frame.spacing_x = spacing[1];
    }
  }

  Result<void> read_values(size_t i, Frame& frame) {
    const Item* transformation = group(i, kPixelValueTransformation);
    const Item& item = transformation ? *transformation : data_;
    frame.slope = item.number(kRescaleSlope).value_or(1);
    frame.intercept = item.number(kRescaleIntercept).value_or(0);
    if (const auto scaling = data_.number(kDoseGridScaling)) frame.slope = *scaling;
    for (const Tag tag : {kRescaleSlope, kRescaleIntercept, kDoseGridScaling}) {
      const Item& holder = tag == kDoseGridScaling ? data_ : item;
      const Element* element = holder.find(tag);
      if (element && !holder.text(tag).empty() && !holder.number(tag)) {
        return malformed("its rescale slope or intercept is not a number");
      }
    }
    if (frame.slope == 0) return malformed("its rescale slope is 0, so all values would be equal");
    if (const Element* lut = data_.find(kModalityLut); lut && !lut->items.empty()) {
      refuse_image(
          image_, Status::unsupported_type,
          "expected pixels with slope and intercept, found a lookup table for their values: "
          "export it with the table applied");
    }
    return {};
  }

  void set_number(Frame& frame, Key key, const Item* item, Tag tag) {
    if (!item) return;
    if (const auto number = item->number(tag)) frame.keys[static_cast<size_t>(key)] = *number;
  }

  void set(Frame& frame, Key key, double value) {
    if (!std::isnan(value)) frame.keys[static_cast<size_t>(key)] = value;
  }

  /// The i-th number of a vector that nuclear medicine files have for their frames.
  void set_from_vector(Frame& frame, Key key, Tag tag, size_t i) {
    const std::vector<double> numbers = data_.numbers(tag);
    if (i < numbers.size()) set(frame, key, numbers[i]);
  }

  void read_keys(size_t i, Frame& frame) {
    frame.keys.fill(std::nan(""));
    const Item* content = group(i, kFrameContentSequence);
    set_number(frame, Key::temporal_position, &data_, kTemporalPosition);
    set_number(frame, Key::temporal_position, content, kTemporalPositionIndex);
    set(frame, Key::frame_type, text_key(to_, data_.text(kImageType)));
    for (const Tag tag : {kMrFrameTypeSequence, kCtFrameTypeSequence, kPetFrameTypeSequence}) {
      if (const Item* type = group(i, tag)) {
        set(frame, Key::frame_type, text_key(to_, type->text(kFrameType)));
      }
    }
    set_number(frame, Key::echo, &data_, kEchoTime);
    set_number(frame, Key::echo, &data_, kEchoNumber);
    set_number(frame, Key::echo, group(i, kMrEchoSequence), kEffectiveEchoTime);
    set_number(frame, Key::inversion_time, &data_, kInversionTime);
    const Item* diffusion = group(i, kMrDiffusionSequence);
    set_number(frame, Key::b_value, diffusion ? diffusion : &data_, kDiffusionBValue);
    const Item* gradient = diffusion ? diffusion->first_item(kDiffusionGradientSequence) : nullptr;
    std::string direction;
    for (const double d : (gradient ? *gradient : data_).numbers(kDiffusionGradient)) {
      direction += fmt::format("{} ", d);
    }
    set(frame, Key::gradient, text_key(to_, direction));
    set_from_vector(frame, Key::energy_window, kEnergyWindowVector, i);
    set_from_vector(frame, Key::detector, kDetectorVector, i);
    set_from_vector(frame, Key::rr_interval, kRrIntervalVector, i);
    set_from_vector(frame, Key::time_slot, kTimeSlotVector, i);
    set_from_vector(frame, Key::time_slot, kTimeSliceVector, i);
    if (content) {
      const std::vector<double> indices = content->numbers(kDimensionIndexValues);
      constexpr auto kFirst = static_cast<size_t>(Key::dimension_1);
      for (size_t d = 0; d < std::min<size_t>(indices.size(), 5); ++d) {
        frame.keys[kFirst + d] = indices[d];
      }
      frame.stack = text_id(to_, content->text(kStackId));
      set(frame, Key::acquisition_time, seconds_of(content->text(kFrameAcquisitionDateTime)));
    }
    set_number(frame, Key::trigger_time, &data_, kTriggerTime);
    set_number(frame, Key::trigger_time, group(i, kCardiacSequence), kTriggerDelay);
    set_number(frame, Key::acquisition, &data_, kAcquisitionNumber);
    if (image_.frames == 1) {
      set(frame, Key::acquisition_time,
          seconds_of(data_.text(kAcquisitionDate), data_.text(kAcquisitionTime)));
      set(frame, Key::acquisition_time, seconds_of(data_.text(kAcquisitionDateTime)));
      set(frame, Key::content_time, seconds_of(data_.text(kContentDate), data_.text(kContentTime)));
      set_number(frame, Key::reference_time, &data_, kFrameReferenceTime);
    }
    const auto instance = data_.number(kInstanceNumber);
    if (instance || image_.frames > 1) {
      set(frame, Key::instance, instance.value_or(0) * kMaxFrames + static_cast<double>(i));
    }
  }

  Result<void> read_frame(size_t i, Frame& frame) {
    frame.image = static_cast<uint32_t>(to_.images.size());
    frame.index = static_cast<uint32_t>(i);
    frame.is_inverse = photometric_ == "MONOCHROME1";
    frame.is_localizer = data_.text(kImageType).find("LOCALIZER") != std::string_view::npos;
    frame.series = series_id();
    if (auto r = read_place(i, frame); !r) return r;
    read_spacing(i, frame);
    if (auto r = read_values(i, frame); !r) return r;
    read_keys(i, frame);
    return {};
  }

  uint32_t series_id() {
    const std::string uid(data_.text(kSeriesInstance));
    const std::string key = fmt::format("{} {}", data_.text(kStudyInstance), uid);
    const auto [found, is_new] =
        to_.series_ids.try_emplace(key, static_cast<uint32_t>(to_.series.size()));
    if (is_new) {
      to_.series.push_back({uid.empty() ? "(without a number)" : uid,
                            std::string(data_.text(kModality)),
                            std::string(data_.text(kSeriesDescription))});
    }
    return found->second;
  }

  /// Positions the frames of a file that has one position for all frames.
  Result<void> place_together(std::vector<Frame>& frames) {
    if (frames.size() < 2) return {};
    const auto placed = std::count_if(frames.begin(), frames.end(),
                                      [](const Frame& frame) { return frame.is_placed; });
    if (placed == static_cast<std::ptrdiff_t>(frames.size())) return {};
    if (placed > 0) return malformed("some of its frames have a position, others have none");

    const Item* first = &data_;
    if (const Item* detector = data_.first_item(kDetectorInformation);
        detector && detector->find(kImagePosition)) {
      first = detector;
      for (Frame& frame : frames) {
        if (auto r = read_orientation(*detector, kImageOrientation, frame); !r) return r;
      }
    }
    const auto position = vector_at(*first, kImagePosition, 0, 3, "position");
    if (!position) return tl::unexpected(position.error());
    const Vec3d origin = position->value_or(Vec3d{0, 0, 0});
    const bool has_offsets = data_.find(kGridFrameOffsets) != nullptr;
    const auto along = has_offsets ? dose_offsets(frames, origin) : even_offsets(frames);
    if (!along) return tl::unexpected(along.error());
    for (size_t i = 0; i < frames.size(); ++i) {
      frames[i].position = origin + (*along)[i];
      frames[i].is_placed = true;
    }
    if (!*position && image_.assumption.empty()) {
      image_.assumption = "the file has no position for its first frame: 0, 0, 0 is assumed";
    }
    return {};
  }

  /// Frame offsets of a dose grid relative to the first frame (PS3.3, C.8.8.3.2). If the first
  /// value is 0, the values are offsets along the normal; if it is the z of the position, they are
  /// z coordinates.
  Result<std::vector<Vec3d>> dose_offsets(const std::vector<Frame>& frames, Vec3d origin) const {
    const std::vector<double> offsets = data_.numbers(kGridFrameOffsets);
    if (offsets.size() != frames.size()) {
      return malformed(
          fmt::format("it has {} frames and {} offsets of frames", frames.size(), offsets.size()));
    }
    const Vec3d normal = cross(frames[0].row, frames[0].column);
    const bool is_relative = offsets[0] == 0;
    const bool is_z = std::abs(offsets[0] - origin.z) < 1e-3 && std::abs(normal.z) > 0.999;
    if (!is_relative && !is_z) {
      return malformed(
          fmt::format("its frame offsets begin with {}, which is neither 0 nor the z of "
                      "its position, {}",
                      offsets[0], origin.z));
    }
    std::vector<Vec3d> along;
    for (const double offset : offsets) {
      if (!std::isfinite(offset)) return malformed("its frame offsets are not numbers");
      along.push_back(is_relative ? normal * offset : Vec3d{0, 0, offset - offsets[0]});
    }
    return along;
  }

  /// Frame offsets relative to the first frame, with equal steps along the normal. A negative
  /// spacing goes against the normal (PS3.3, C.8.4.15).
  Result<std::vector<Vec3d>> even_offsets(const std::vector<Frame>& frames) {
    auto spacing = data_.number(kSpacingBetweenSlices);
    if (!spacing && shared_) {
      if (const Item* measures = shared_->first_item(kPixelMeasuresSequence)) {
        spacing = measures->number(kSpacingBetweenSlices);
      }
    }
    if (!spacing || *spacing == 0) {
      const auto thickness = data_.number(kSliceThickness);
      spacing = thickness && *thickness > 0 ? thickness : std::optional(1.0);
      image_.assumption = fmt::format(
          "the file has no distance between frames: {} mm is assumed, {}; --spacing sets "
          "another",
          *spacing,
          thickness && *thickness > 0 ? "the slice thickness"
                                      : "since the file has no slice thickness either");
    }
    const std::vector<double> slices = data_.numbers(kSliceVector);
    if (!slices.empty() && slices.size() != frames.size()) {
      return malformed(
          fmt::format("it has {} frames and {} numbers of slices", frames.size(), slices.size()));
    }
    std::vector<Vec3d> along;
    for (size_t i = 0; i < frames.size(); ++i) {
      const double step = slices.empty() ? static_cast<double>(i) : slices[i] - 1;
      if (!std::isfinite(step)) return malformed("its numbers of slices are not numbers");
      along.push_back(cross(frames[i].row, frames[i].column) * (*spacing * step));
    }
    return along;
  }

  const Elements& elements_;
  const Item& data_;
  const std::filesystem::path& path_;
  Collection& to_;
  const Item* shared_ = nullptr;
  const std::vector<Item>* per_frame_ = nullptr;
  std::string_view photometric_;
  Image image_;
};

}  // namespace

Result<FileContent> add_frames(const Elements& elements, const std::filesystem::path& path,
                               Collection& to) {
  return FileReader(elements, path, to).read();
}

}  // namespace isosplat::dicom
