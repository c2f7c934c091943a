#include "shared/import/dicom_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/dicom_fragments.h"

namespace isosplat::dicom {
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

template <size_t N>
bool contains(const std::string_view (&names)[N], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

class ImageReader {
 public:
  ImageReader(const Elements& elements, const std::filesystem::path& path)
      : elements_(elements), data_(elements.data), path_(path) {}

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
    image_.stated_slice_spacing = std::abs(data_.number(kSpacingBetweenSlices).value_or(0));
    image_.is_encapsulated = image_.pixels.bytes == PixelPlace::kUndefined;
    const auto rows = whole_number(kRows, "rows", 1, 65535);
    if (!rows) return tl::unexpected(rows.error());
    const auto columns = whole_number(kColumns, "columns", 1, 65535);
    if (!columns) return tl::unexpected(columns.error());
    const auto frames = whole_number(kNumberOfFrames, "frames", 0, kMaxFrames, 1);
    if (!frames) return tl::unexpected(frames.error());
    image_.rows = *rows;
    image_.columns = *columns;
    image_.frames = std::max(*frames, 1);
    image_.is_float = image_.pixels.tag != kPixels;
    if (image_.is_float) {
      image_.allocated = image_.stored = image_.pixels.tag == kFloatPixels ? 32 : 64;
      image_.high_bit = image_.stored - 1;
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
    image_.padding = padding_at(kPixelPadding);
    image_.padding_limit = padding_at(kPixelPaddingLimit);
    return {};
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
    if (image_.allocated != 8 && image_.allocated != 16 && image_.allocated != 32 &&
        !(image_.is_float && image_.allocated == 64)) {
      refuse(Status::unsupported_type,
             fmt::format("expected pixels of 8, 16 or 32 bits, found {}: export it with 16",
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
    // Padding is shorter than a row. A longer surplus means that rows, columns or the number of
    // frames are wrong, so that the pixels would be read at wrong positions.
    const uint64_t row_bytes =
        static_cast<uint64_t>(image_.columns) * static_cast<uint64_t>(image_.allocated / 8);
    const uint64_t needed =
        row_bytes * static_cast<uint64_t>(image_.rows) * static_cast<uint64_t>(image_.frames);
    // The size of a deflated data set is known only after inflating it; inflates no more than
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
    if (type.find("MOSAIC") != type.npos) {
      refuse(Status::unsupported_format,
             "expected a slice per frame, found a Siemens mosaic of all slices: convert it with "
             "dcm2niix, or export it as enhanced DICOM");
    }
    const Element* groups = data_.find(kPerFrameGroups);
    const bool has_groups = groups && !groups->items.empty();
    if (image_.frames == 1 || has_groups || data_.find(kGridFrameOffsets)) return;
    if (modality == "NM" && type.find("RECON") == type.npos) {
      refuse(Status::unsupported_format,
             "expected reconstructed slices, found projections, views or a dynamic study: give a "
             "reconstruction");
    }
    const bool has_spacing = data_.find(kSpacingBetweenSlices) || data_.find(kSliceVector);
    if (!has_spacing && (contains(kFilmModalities, modality) || data_.find(kFrameTime) ||
                         data_.find(kFrameTimeVector))) {
      refuse(Status::unsupported_format,
             "expected slices of a volume, found the frames of a film: give a volume");
    }
  }

  const Elements& elements_;
  const Item& data_;
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

Result<Image> read_image(const Elements& elements, const std::filesystem::path& path) {
  return ImageReader(elements, path).read();
}

}  // namespace isosplat::dicom
