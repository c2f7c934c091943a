#include "shared/import/dicom/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/dicom/fragments.h"
#include "shared/import/dicom/groups.h"

namespace isosplat::import::dicom {
namespace {

constexpr std::string_view kNativeSyntaxes[] = {
    "1.2.840.10008.1.2",   "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.1.99",
    "1.2.840.10008.1.2.2", "1.2.840.113619.5.2",
};

/// The codecs that GDCM decodes: JPEG baseline, extended and lossless, JPEG-LS, JPEG 2000, RLE.
constexpr std::string_view kCompressedSyntaxes[] = {
    "1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.57",
    "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81",
    "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91", "1.2.840.10008.1.2.5",
};

/// SOP classes of images whose frames are a time sequence.
constexpr std::string_view kFilmModalities[] = {"XA", "RF", "US", "XC", "ES", "GM",  "OP",
                                                "DX", "CR", "MG", "IO", "PX", "IVUS"};

constexpr std::string_view kSegmentationClass = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr std::string_view kLabelMapClass = "1.2.840.10008.5.1.4.1.1.66.7";

template <size_t N>
bool contains(const std::string_view (&names)[N], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

/// The meaning of a segment's codes, such as "Kidney, Right" (PS3.3, C.8.20.4); may be empty.
std::string coded_name(const Item& segment) {
  const Item* type = segment.first_item(kPropertyType);
  if (!type) return {};
  std::string name(type->text(kCodeMeaning));
  if (const Item* modifier = type->first_item(kPropertyModifier)) {
    const std::string_view text = modifier->text(kCodeMeaning);
    if (!text.empty()) name.append(", ").append(text);
  }
  return name;
}

/// The meaning of a file's pixels; kind `none` if it is not a segmentation.
Segmentation read_segmentation(const Item& data) {
  using Kind = Segmentation::Kind;
  Segmentation out;
  const std::string_view uid = sop_class(data), type = data.text(kSegmentationType);
  if (uid != kSegmentationClass && uid != kLabelMapClass && type.empty()) return out;
  out.kind = type == "LABELMAP" || uid == kLabelMapClass ? Kind::labels
             : type == "FRACTIONAL"                      ? Kind::fractional
                                                         : Kind::binary;
  if (const Element* segments = data.find(kSegments)) {
    for (const Item& item : segments->items) {
      if (const auto number = item.number(kSegmentNumber)) {
        out.segments.push_back({static_cast<int>(std::clamp(*number, 0.0, 65535.0)),
                                std::string(item.text(kSegmentLabel)), coded_name(item),
                                item.numbers(kSegmentColour)});
      }
    }
  }
  out.max_fraction =
      static_cast<int>(std::clamp(data.number(kMaximumFraction).value_or(255), 0.0, 65535.0));
  out.fraction_type = data.text(kFractionType);
  if (out.kind == Kind::labels) out.background = data.number(kPixelPadding).value_or(0);
  return out;
}

class ImageReader {
 public:
  ImageReader(const Elements& elements, const std::filesystem::path& path)
      : elements_(elements), data_(elements.data), groups_(elements.data), path_(path) {}

  Result<Image> read() {
    if (auto r = read_pixels(); !r) return tl::unexpected(r.error());
    if (auto r = check_extent(); !r) return tl::unexpected(r.error());
    find_obstacles();
    return std::move(image_);
  }

 private:
  tl::unexpected<Error> malformed(std::string_view why) const { return contradiction(path_, why); }

  void refuse(Status status, std::string why) { refuse_image(image_, status, std::move(why)); }

  /// A whole number of the header, in a range. Errors: malformed_volume.
  Result<int> whole_number(Tag tag, const char* name, double min, double max,
                           std::optional<int> otherwise = std::nullopt) const {
    if (otherwise && !data_.find(tag)) return *otherwise;
    const auto number = data_.number(tag);
    if (!number || *number < min || *number > max || *number != std::floor(*number)) {
      return malformed(fmt::format("expected {} from {} to {}, found {}", name, min, max,
                                   number ? fmt::format("{}", *number) : "none"));
    }
    return static_cast<int>(*number);
  }

  /// A stored value whose sign follows the pixels' signedness.
  std::optional<double> padding_at(Tag tag) const {
    const auto number = data_.number(tag);
    if (!number || !image_.is_signed || *number < 32768) return number;
    return *number - 65536;
  }

  Result<void> read_pixels() {
    image_.file = path_.string();
    image_.transfer_syntax = elements_.transfer_syntax;
    image_.pixels = elements_.pixels;
    image_.deflated = elements_.deflated;
    image_.deflated_start = elements_.deflated_start;
    image_.sop_class = sop_class(data_);
    image_.instance_uid = data_.text(kSopInstance);
    image_.frame_of_reference = data_.text(kFrameOfReference);
    image_.stated_slice_spacing =
        std::abs(groups_.number(0, kPixelMeasuresSequence, kSpacingBetweenSlices).value_or(0));
    image_.slice_thickness = groups_.number(0, kPixelMeasuresSequence, kSliceThickness).value_or(0);
    image_.segmentation = read_segmentation(data_);
    image_.concatenation = {std::string(data_.text(kConcatenation)),
                            part_number(kConcatenationNumber), part_number(kConcatenationTotal)};
    image_.is_encapsulated = image_.pixels.bytes == PixelPlace::kUndefined;
    const auto rows = whole_number(kRows, "rows", 1, 65535);
    if (!rows) return tl::unexpected(rows.error());
    const auto columns = whole_number(kColumns, "columns", 1, 65535);
    if (!columns) return tl::unexpected(columns.error());
    const auto frames = whole_number(kNumberOfFrames, "frames", 0, kMaxFrames, 1);
    if (!frames) return tl::unexpected(frames.error());
    image_.rows = image_.stored_rows = *rows;
    image_.columns = image_.stored_columns = *columns;
    image_.frames = std::max(*frames, 1);
    image_.is_float = image_.pixels.tag != kPixels;
    if (image_.is_float) {
      image_.allocated = image_.stored = image_.pixels.tag == kFloatPixels ? 32 : 64;
      image_.high_bit = image_.stored - 1;
      const bool is_double = image_.stored == 64;
      image_.padding = data_.number(is_double ? kDoublePadding : kFloatPadding);
      image_.padding_limit = data_.number(is_double ? kDoublePaddingLimit : kFloatPaddingLimit);
      return {};
    }
    const auto allocated = whole_number(kBitsAllocated, "bits allocated", 1, 64);
    if (!allocated) return tl::unexpected(allocated.error());
    const auto stored = whole_number(kBitsStored, "bits stored", 1, *allocated, *allocated);
    if (!stored) return tl::unexpected(stored.error());
    const auto high = whole_number(kHighBit, "high bit", *stored - 1, *allocated - 1, *stored - 1);
    if (!high) return tl::unexpected(high.error());
    image_.allocated = *allocated;
    image_.stored = *stored;
    image_.high_bit = *high;
    image_.is_signed = data_.number(kPixelRepresentation).value_or(0) == 1;
    // The padding of a segmentation is its background, which is an ordinary value.
    if (image_.segmentation.kind == Segmentation::Kind::none) {
      image_.padding = padding_at(kPixelPadding);
      image_.padding_limit = padding_at(kPixelPaddingLimit);
    }
    return {};
  }

  int part_number(Tag tag) const {
    return static_cast<int>(std::clamp(data_.number(tag).value_or(0), 0.0, 65535.0));
  }

  /// Checks whether the file has all its pixels.
  Result<void> check_extent() {
    const bool is_native = contains(kNativeSyntaxes, image_.transfer_syntax);
    if (!is_native && !contains(kCompressedSyntaxes, image_.transfer_syntax)) {
      refuse(Status::unsupported_format,
             fmt::format("expected native, deflated, RLE, JPEG, JPEG-LS or JPEG 2000 pixels, found "
                         "the transfer syntax {}: export it uncompressed",
                         image_.transfer_syntax));
      return {};
    }
    const bool is_bit = image_.allocated == 1 && is_native;
    if (!is_bit && image_.allocated != 8 && image_.allocated != 16 && image_.allocated != 32 &&
        !(image_.is_float && image_.allocated == 64)) {
      refuse(
          Status::unsupported_type,
          fmt::format("expected pixels of 8, 16 or 32 bits, or uncompressed ones of 1 bit, found "
                      "{} bits: export it with 16",
                      image_.allocated));
      return {};
    }
    auto file = image_.deflated ? open_deflated(path_, image_.deflated_start, Deflate::raw)
                                : open_plain(path_);
    if (!file) return tl::unexpected(file.error());
    if (!is_native && image_.is_encapsulated) {
      const auto fragments = find_fragments(**file, image_);
      if (fragments) return {};
      if (fragments.error().status != Status::truncated) return tl::unexpected(fragments.error());
      image_.cut_off = true;
      return {};
    }
    if (image_.is_encapsulated != !is_native) {
      return malformed("its transfer syntax and the form of its pixels do not agree");
    }
    // Padding is shorter than a row, or one byte. A longer surplus means that rows, columns or the
    // number of frames are wrong, so that the pixels would be read at wrong positions.
    const auto bytes_of = [&](uint64_t pixels) {
      return (pixels * static_cast<uint64_t>(image_.allocated) + 7) / 8;
    };
    const auto columns = static_cast<uint64_t>(image_.stored_columns);
    const uint64_t row_bytes = std::max<uint64_t>(bytes_of(columns), is_bit ? 2 : 1);
    const uint64_t needed = bytes_of(columns * static_cast<uint64_t>(image_.stored_rows) *
                                     static_cast<uint64_t>(image_.frames));
    // The size of a deflated data set is known only after inflating it. Inflates only as much as
    // needed.
    const auto after = (*file)->count_after(image_.pixels.offset, needed + row_bytes);
    const uint64_t there = after ? 0 : (*file)->available_bytes();
    const uint64_t left = after ? *after : there - std::min(there, image_.pixels.offset);
    image_.pixels.bytes = std::min(left, image_.pixels.bytes);
    image_.cut_off = image_.pixels.bytes < needed;
    image_.has_surplus = image_.pixels.bytes >= needed + row_bytes;
    return {};
  }

  /// Refuses images that can be read but are not volumes.
  void find_obstacles() {
    const std::string_view type = data_.text(kImageType), modality = data_.text(kModality);
    const bool has_positions = !groups_.items(0, kPlanePositionSequence).empty() ||
                               !groups_.items(0, kPlanePositionVolumeSequence).empty();
    if (image_.frames == 1 || has_positions || data_.find(kGridFrameOffsets)) return;
    if (modality == "NM" && type.find("RECON") == type.npos) {
      refuse(Status::unsupported_format,
             "expected reconstructed slices, found projections, views or a dynamic study: give a "
             "reconstruction");
    }
    const bool has_spacing = data_.find(kSpacingBetweenSlices) || data_.find(kSliceVector) ||
                             data_.find(kSliceLocationVector);
    if (!has_spacing && (contains(kFilmModalities, modality) || data_.find(kFrameTime) ||
                         data_.find(kFrameTimeVector))) {
      refuse(Status::unsupported_format,
             "expected slices of a volume, found the frames of a film: give a volume");
    }
  }

  const Elements& elements_;
  const Item& data_;
  FrameGroups groups_;
  const std::filesystem::path& path_;
  Image image_;
};

}  // namespace

std::string_view sop_class(const Item& data) {
  const std::string_view uid = data.text(kSopClass);
  return uid.empty() ? data.text(kMediaSopClass) : uid;
}

tl::unexpected<Error> contradiction(const std::filesystem::path& path, std::string_view why) {
  return fail(Status::malformed_volume,
              fmt::format("{}: its DICOM header contradicts itself or is incomplete: {}: export "
                          "the file again",
                          path.string(), why));
}

void refuse_image(Image& image, Status status, std::string why) {
  if (!image.obstacle.empty()) return;
  image.refusal = status;
  image.obstacle = std::move(why);
}

void add_note(Image& image, std::string note) {
  constexpr size_t kMaxNotes = 32;  // one for each kind of assumption, and for differing names
  const auto found = std::find(image.notes.begin(), image.notes.end(), note);
  if (found == image.notes.end() && image.notes.size() < kMaxNotes)
    image.notes.push_back(std::move(note));
}

Result<Image> read_image(const Elements& elements, const std::filesystem::path& path) {
  return ImageReader(elements, path).read();
}

}  // namespace isosplat::import::dicom
