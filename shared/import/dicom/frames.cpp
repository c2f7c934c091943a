#include "shared/import/dicom/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "shared/import/dicom/image.h"
#include "shared/import/dicom/mapping.h"
#include "shared/import/dicom/mosaic.h"
#include "shared/import/dicom/places.h"

namespace isosplat::import::dicom {
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

/// A description of the tiles of a whole-slide image (PS3.3, C.8.12.4); empty for other images. The
/// tiles of a plane are adjacent, so they are not slices.
std::string describe_tiles(const Item& data, double frames) {
  constexpr std::string_view kWholeSlide = "1.2.840.10008.5.1.4.1.1.77.1.6";
  const double columns = data.number(kTotalMatrixColumns).value_or(0);
  const double rows = data.number(kTotalMatrixRows).value_or(0);
  const bool is_tiled = data.text(kDimensionOrganization).starts_with("TILED");
  if (sop_class(data) != kWholeSlide && !is_tiled && columns == 0) return {};
  std::string text = fmt::format("{} tiles of {} × {} pixels of a whole-slide image", frames,
                                 data.number(kColumns).value_or(0), data.number(kRows).value_or(0));
  if (columns > 0) text += fmt::format(" of {} × {} pixels", columns, rows);
  const double planes = data.number(kFocalPlanes).value_or(1);
  const double paths = data.number(kOpticalPaths).value_or(1);
  if (planes > 1) text += fmt::format(", in {} focal planes", planes);
  if (paths > 1) text += fmt::format(", of {} optical paths", paths);
  return text;
}

/// Reads the frames of one file into the collection.
class FileReader {
 public:
  FileReader(const Elements& elements, const std::filesystem::path& path, Collection& to)
      : elements_(elements), data_(elements.data), groups_(elements.data), path_(path), to_(to) {}

  Result<FileContent> read() {
    if (elements_.pixels.tag == 0) {
      to_.without_pixels.push_back({path_.string(), std::string(sop_class(data_))});
      return FileContent::no_pixels;
    }
    if (auto tiles = describe_tiles(data_, data_.number(kNumberOfFrames).value_or(1));
        !tiles.empty()) {
      to_.slides.push_back(std::move(tiles));
      return FileContent::tiles;
    }
    photometric_ = data_.text(kPhotometric);
    // The palette of a segmentation is how its labels are displayed.
    const bool is_grey = photometric_.empty() || photometric_ == "MONOCHROME1" ||
                         photometric_ == "MONOCHROME2" ||
                         (photometric_ == "PALETTE COLOR" && data_.find(kSegmentationType));
    if (!is_grey || data_.number(kSamplesPerPixel).value_or(1) != 1) return FileContent::colour;
    auto image = read_image(elements_, path_);
    if (!image) return tl::unexpected(image.error());
    image_ = std::move(*image);

    const auto frames = static_cast<size_t>(image_.frames);
    if (groups_.described() > 0 && groups_.described() != frames) {
      return malformed(fmt::format("it has {} frames and {} items that describe them", frames,
                                   groups_.described()));
    }
    std::vector<Frame> made(frames);
    if (auto r = read_places(groups_, path_, image_, made); !r) return tl::unexpected(r.error());
    for (size_t i = 0; i < frames; ++i) {
      if (auto r = read_frame(i, made[i]); !r) return tl::unexpected(r.error());
    }
    const bool is_tiled = is_mosaic(data_) && (frames == 1 || !made.front().is_placed);
    const auto placed = is_tiled ? place_tiles(groups_, path_, image_, made)
                                 : place_together(groups_, path_, image_, made);
    if (!placed) return tl::unexpected(placed.error());
    for (size_t i = 0; i < made.size(); ++i) set_instance(made[i], i);
    to_.images.push_back(std::move(image_));
    to_.frames.insert(to_.frames.end(), made.begin(), made.end());
    return FileContent::frames;
  }

 private:
  tl::unexpected<Error> malformed(std::string_view why) const { return contradiction(path_, why); }

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
    const Item* content = groups_.find(i, kFrameContentSequence);
    set_number(frame, Key::temporal_position, &data_, kTemporalPosition);
    set_number(frame, Key::temporal_position, content, kTemporalPositionIndex);
    set(frame, Key::frame_type, text_key(to_, data_.text(kImageType)));
    for (const Tag tag : {kMrFrameTypeSequence, kCtFrameTypeSequence, kPetFrameTypeSequence}) {
      if (const Item* type = groups_.find(i, tag)) {
        set(frame, Key::frame_type, text_key(to_, type->text(kFrameType)));
      }
    }
    set_number(frame, Key::echo, &data_, kEchoTime);
    set_number(frame, Key::echo, &data_, kEchoNumber);
    set_number(frame, Key::echo, groups_.find(i, kMrEchoSequence), kEffectiveEchoTime);
    set_number(frame, Key::inversion_time, &data_, kInversionTime);
    const Item* diffusion = groups_.find(i, kMrDiffusionSequence);
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
    set_number(frame, Key::trigger_time, groups_.find(i, kCardiacSequence), kTriggerDelay);
    set_number(frame, Key::acquisition, &data_, kAcquisitionNumber);
    if (image_.frames == 1) {
      set(frame, Key::acquisition_time,
          seconds_of(data_.text(kAcquisitionDate), data_.text(kAcquisitionTime)));
      set(frame, Key::acquisition_time, seconds_of(data_.text(kAcquisitionDateTime)));
      set(frame, Key::content_time, seconds_of(data_.text(kContentDate), data_.text(kContentTime)));
      set_number(frame, Key::reference_time, &data_, kFrameReferenceTime);
    }
  }

  void set_instance(Frame& frame, size_t i) {
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
    frame.location = data_.number(kSliceLocation).value_or(std::nan(""));
    frame.segment = segment_of(i);
    std::string quantity;
    if (auto r = read_mapping(groups_, i, path_, image_, frame, quantity); !r) return r;
    read_keys(i, frame);
    set(frame, Key::quantity, text_key(to_, quantity));
    return {};
  }

  /// The number of a frame's segment; 0 if it has none, as in label maps.
  int segment_of(size_t i) const {
    const Segmentation& segmentation = image_.segmentation;
    if (segmentation.kind == Segmentation::Kind::none) return 0;
    const Item* segment = groups_.find(i, kSegmentIdentification);
    const auto number = segment ? segment->number(kReferencedSegment) : std::nullopt;
    if (number) return static_cast<int>(std::clamp(*number, 0.0, 65535.0));
    const bool is_only = segmentation.segments.size() == 1;
    return is_only ? segmentation.segments.front().number : 0;
  }

  uint32_t series_id() {
    const std::string uid(data_.text(kSeriesInstance));
    const std::string key = fmt::format("{} {}", data_.text(kStudyInstance), uid);
    const auto [found, is_new] =
        to_.series_ids.try_emplace(key, static_cast<uint32_t>(to_.series.size()));
    if (is_new) {
      to_.series.push_back(
          {uid.empty() ? "(without a number)" : uid, std::string(data_.text(kModality)),
           std::string(data_.text(kSeriesDescription)), std::string(data_.text(kSeriesDate))});
    }
    return found->second;
  }

  const Elements& elements_;
  const Item& data_;
  FrameGroups groups_;
  const std::filesystem::path& path_;
  Collection& to_;
  std::string_view photometric_;
  Image image_;
};

}  // namespace

Result<FileContent> add_frames(const Elements& elements, const std::filesystem::path& path,
                               Collection& to) {
  return FileReader(elements, path, to).read();
}

}  // namespace isosplat::import::dicom
