#include "shared/import/dicom_pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "shared/import/absent_voxels.h"
#include "shared/import/dicom_codec.h"

namespace isosplat::dicom {
namespace {

bool is_big_endian(const Image& image) {
  return image.transfer_syntax == "1.2.840.10008.1.2.2" ||
         image.transfer_syntax == "1.2.840.113619.5.2";
}

/// Reads the stored pixels of native and deflated frames, and converts them to native byte order.
class NativeReader {
 public:
  explicit NativeReader(bool fill_missing) : fill_missing_(fill_missing) {}

  /// Number of pixels that were read: all, unless a truncated file lacks some and fill_missing is
  /// set.
  Result<size_t> read(const Image& image, uint32_t index, std::span<std::byte> out) {
    const size_t pixel = static_cast<size_t>(image.allocated) / 8;
    auto whole = out.size();
    if (opened_ != &image) {
      auto file = image.deflated ? open_deflated(image.file, image.deflated_start, Deflate::raw)
                                 : open_plain(image.file);
      if (!file) return tl::unexpected(file.error());
      file_ = std::move(*file);
      opened_ = &image;
    }
    const uint64_t start = image.pixels.offset + index * uint64_t{out.size()};
    if (fill_missing_ && image.cut_off) {
      const uint64_t end = image.pixels.offset + image.pixels.bytes;
      const uint64_t there = start < end ? std::min<uint64_t>(out.size(), end - start) : 0;
      whole = static_cast<size_t>(there) / pixel * pixel;
    }
    if (whole > 0) {
      auto r = file_->read(start, out.first(whole));
      if (!r) return tl::unexpected(r.error());
    }
    swap_bytes(image, out.first(whole));
    return whole / pixel;
  }

 private:
  static void swap_bytes(const Image& image, std::span<std::byte> out) {
    if (!is_big_endian(image)) return;
    const size_t pixel = static_cast<size_t>(image.allocated) / 8;
    const size_t unit = pixel == 1 && image.pixels.in_words ? 2 : pixel;
    for (size_t i = 0; unit > 1 && i + unit <= out.size(); i += unit) {
      std::reverse(out.begin() + static_cast<std::ptrdiff_t>(i),
                   out.begin() + static_cast<std::ptrdiff_t>(i + unit));
    }
  }

  bool fill_missing_;
  const Image* opened_ = nullptr;
  std::unique_ptr<ByteReader> file_;
};

/// The stored bits of a pixel. The bits above and below belong to overlays, or are unused.
///
///   | allocated − high bit − 1: ignored | stored | high bit + 1 − stored: ignored |
struct Bits {
  int below = 0;      ///< number of bits to shift out
  uint32_t mask = 0;  ///< mask of the stored bits, after the shift
  uint32_t sign = 0;  ///< the sign bit, after the shift; 0: unsigned

  explicit Bits(const Image& image)
      : below(image.high_bit + 1 - image.stored),
        mask(image.stored == 32 ? ~uint32_t{0} : (uint32_t{1} << image.stored) - 1),
        sign(image.is_signed ? uint32_t{1} << (image.stored - 1) : 0) {}

  int64_t number(uint32_t word) const {
    const uint32_t code = word >> below & mask;
    return static_cast<int64_t>(code ^ sign) - static_cast<int64_t>(sign);
  }
};

template <class Word, class To>
void convert(const FramePixels& frame, std::span<const std::byte> stored,
             std::span<std::byte> out) {
  const size_t count = stored.size() / sizeof(Word);
  const double slope = frame.slope, intercept = frame.intercept;
  const bool is_plain = slope == 1 && intercept == 0;
  [[maybe_unused]] const Bits bits(*frame.image);
  for (size_t i = 0; i < count; ++i) {
    Word word;
    std::memcpy(&word, stored.data() + i * sizeof(Word), sizeof(Word));
    To value;
    if constexpr (std::is_floating_point_v<Word>) {
      value = static_cast<To>(intercept + slope * static_cast<double>(word));
    } else {
      const int64_t number = bits.number(word);
      value = is_plain ? static_cast<To>(number)
                       : static_cast<To>(intercept + slope * static_cast<double>(number));
    }
    std::memcpy(out.data() + i * sizeof(To), &value, sizeof(To));
  }
}

template <class Word>
void convert_from(const FramePixels& frame, std::span<const std::byte> stored, VoxelType to,
                  std::span<std::byte> out) {
  with_voxel_type(to, [&]<class To>(To) { convert<Word, To>(frame, stored, out); });
}

void convert(const FramePixels& frame, std::span<const std::byte> stored, VoxelType to,
             std::span<std::byte> out) {
  const Image& image = *frame.image;
  if (image.is_float && image.allocated == 32) return convert_from<float>(frame, stored, to, out);
  if (image.is_float) return convert_from<double>(frame, stored, to, out);
  if (image.allocated == 8) return convert_from<uint8_t>(frame, stored, to, out);
  if (image.allocated == 16) return convert_from<uint16_t>(frame, stored, to, out);
  return convert_from<uint32_t>(frame, stored, to, out);
}

}  // namespace

uint64_t stored_frame_bytes(const Image& image) {
  return static_cast<uint64_t>(image.columns) * static_cast<uint64_t>(image.rows) *
         static_cast<uint64_t>(image.allocated / 8);
}

std::pair<double, double> stored_range(const Image& image) {
  const double codes = std::ldexp(1.0, image.stored);
  return image.is_signed ? std::pair(-codes / 2, codes / 2 - 1) : std::pair(0.0, codes - 1);
}

Result<void> read_frames(std::span<const FramePixels> frames, VoxelType to, bool fill_missing,
                         uint64_t memory_bytes, std::span<std::byte> out) {
  // Frames of a file are read in file order.
  std::vector<size_t> order(frames.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    const auto place = [](const FramePixels& f) {
      return std::tuple(std::string_view(f.image->file), f.index);
    };
    return place(frames[a]) < place(frames[b]);
  });
  const size_t frame_bytes = out.size() / frames.size();
  const auto target = [&](size_t i) { return out.subspan(i * frame_bytes, frame_bytes); };
  NativeReader native(fill_missing);
  std::vector<EncodedFrame> encoded;
  std::vector<size_t> encoded_at;
  uint64_t encoded_bytes = 0;
  std::vector<std::byte> stored;
  for (const size_t i : order) {
    const Image& image = *frames[i].image;
    if (image.is_encapsulated) {
      encoded.push_back({&image, frames[i].index});
      encoded_at.push_back(i);
      encoded_bytes += stored_frame_bytes(image);
      continue;
    }
    stored.resize(static_cast<size_t>(stored_frame_bytes(image)));
    const auto pixels = native.read(image, frames[i].index, stored);
    if (!pixels) return tl::unexpected(pixels.error());
    convert(frames[i], stored, to, target(i));
    const size_t there = *pixels * voxel_bytes(to);
    if (there < frame_bytes) make_absent(to, target(i).subspan(there));
  }
  if (encoded.empty()) return {};
  stored.resize(static_cast<size_t>(encoded_bytes));
  std::vector<bool> is_absent;
  if (auto r = decompress(encoded, fill_missing, memory_bytes, stored, is_absent); !r) return r;
  size_t at = 0;
  for (size_t k = 0; k < encoded_at.size(); ++k) {
    const size_t i = encoded_at[k];
    const auto bytes = static_cast<size_t>(stored_frame_bytes(*frames[i].image));
    const auto pixels = std::span(stored).subspan(at, bytes);
    at += bytes;
    convert(frames[i], pixels, to, target(i));
    if (is_absent[k]) make_absent(to, target(i));
  }
  return {};
}

}  // namespace isosplat::dicom
