#include "shared/import/dicom/pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/dicom/codec.h"
#include "shared/import/voxels/absent_voxels.h"

namespace isosplat::import::dicom {
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
  /// set. Pixels of 1 bit are unpacked to bytes.
  Result<size_t> read(const Image& image, uint32_t index, std::span<std::byte> out) {
    if (opened_ != &image) {
      auto file = image.deflated ? open_deflated(image.file, image.deflated_start, Deflate::raw)
                                 : open_plain(image.file);
      if (!file) return tl::unexpected(file.error());
      file_ = std::move(*file);
      opened_ = &image;
    }
    if (image.allocated == 1) return read_bits(image, index * uint64_t{out.size()}, out);
    const size_t pixel = static_cast<size_t>(image.allocated) / 8;
    const uint64_t start = index * uint64_t{out.size()};
    const auto whole = static_cast<size_t>(there(image, start, out.size())) / pixel * pixel;
    if (whole > 0) {
      auto r = file_->read(image.pixels.offset + start, out.first(whole));
      if (!r) return tl::unexpected(r.error());
    }
    swap_bytes(image, out.first(whole));
    return whole / pixel;
  }

 private:
  /// How many of `count` bytes, from byte `start` of the pixels on, exist in the file.
  uint64_t there(const Image& image, uint64_t start, uint64_t count) const {
    if (!fill_missing_ || !image.cut_off) return count;
    return start < image.pixels.bytes ? std::min(count, image.pixels.bytes - start) : 0;
  }

  /// Unpacks pixels from bit `first` on (PS3.5, 8.1.1). The lowest bit of a byte is the first
  /// pixel; frames and rows follow each other without gaps.
  Result<size_t> read_bits(const Image& image, uint64_t first, std::span<std::byte> out) {
    const uint64_t begin = first / 16 * 2;  // 16-bit words, since big-endian files swap their bytes
    const uint64_t end =
        std::max(begin, std::min((first + out.size() + 15) / 16 * 2, image.pixels.bytes));
    const uint64_t bytes = there(image, begin, end - begin);
    packed_.resize(static_cast<size_t>(bytes));
    if (bytes > 0) {
      auto r = file_->read(image.pixels.offset + begin, packed_);
      if (!r) return tl::unexpected(r.error());
    }
    if (is_big_endian(image) && image.pixels.in_words) {
      for (size_t i = 0; i + 2 <= packed_.size(); i += 2) std::swap(packed_[i], packed_[i + 1]);
    }
    const uint64_t skipped = first - 8 * begin;
    const auto pixels = static_cast<size_t>(
        std::min<uint64_t>(out.size(), 8 * bytes - std::min(8 * bytes, skipped)));
    for (size_t i = 0; i < pixels; ++i) {
      const uint64_t bit = skipped + i;
      out[i] = packed_[static_cast<size_t>(bit / 8)] >> (bit % 8) & std::byte{1};
    }
    return pixels;
  }

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
  std::vector<std::byte> packed_;
};

/// The stored bits of an integer pixel. The bits above and below belong to overlays, or are unused.
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

/// Calls value_of(word) for each stored pixel, and writes the results.
template <class Word, class To, class ValueOf>
void convert_each(std::span<const std::byte> stored, std::span<std::byte> out,
                  const ValueOf& value_of) {
  const size_t count = stored.size() / sizeof(Word);
  for (size_t i = 0; i < count; ++i) {
    Word word;
    std::memcpy(&word, stored.data() + i * sizeof(Word), sizeof(Word));
    const To value = value_of(word);
    std::memcpy(out.data() + i * sizeof(To), &value, sizeof(To));
  }
}

template <class Word, class To>
void convert(const FramePixels& frame, std::span<const std::byte> stored,
             std::span<std::byte> out) {
  const double slope = frame.slope, intercept = frame.intercept;
  const bool is_plain = slope == 1 && intercept == 0;
  if constexpr (std::is_floating_point_v<Word>) {
    convert_each<Word, To>(stored, out, [&](Word word) {
      return static_cast<To>(intercept + slope * static_cast<double>(word));
    });
  } else {
    const Bits bits(*frame.image);
    convert_each<Word, To>(stored, out, [&](Word word) {
      const int64_t number = bits.number(word);
      return frame.label ? static_cast<To>(number == *frame.label)
             : is_plain  ? static_cast<To>(number)
                         : static_cast<To>(intercept + slope * static_cast<double>(number));
    });
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
  if (image.allocated <= 8) return convert_from<uint8_t>(frame, stored, to, out);
  if (image.allocated == 16) return convert_from<uint16_t>(frame, stored, to, out);
  return convert_from<uint32_t>(frame, stored, to, out);
}

size_t stored_pixel_bytes(const Image& image) {
  return static_cast<size_t>(std::max(image.allocated / 8, 1));
}

/// Converts a slice of a stored frame: the whole frame, or one tile of it. The first `pixels`
/// pixels of `stored` exist; the others become absent.
void convert_slice(const FramePixels& frame, std::span<const std::byte> stored, size_t pixels,
                   VoxelType to, std::span<std::byte> out) {
  const Image& image = *frame.image;
  const size_t pixel = stored_pixel_bytes(image), voxel = voxel_bytes(to);
  const auto columns = static_cast<size_t>(image.columns), rows = static_cast<size_t>(image.rows);
  const auto stride = static_cast<size_t>(image.stored_columns);
  const auto across = static_cast<uint32_t>(image.slices_across());
  const bool is_whole = image.columns == image.stored_columns && image.rows == image.stored_rows;
  const size_t run = is_whole ? columns * rows : columns;  // pixels that follow each other
  const size_t first = frame.tile / across * rows * stride + frame.tile % across * columns;
  for (size_t at = 0, from = first; at < columns * rows; at += run, from += stride) {
    const size_t here = std::min(run, pixels - std::min(pixels, from));
    convert(frame, stored.subspan(from * pixel, here * pixel), to,
            out.subspan(at * voxel, here * voxel));
    if (here < run) make_absent(to, out.subspan((at + here) * voxel, (run - here) * voxel));
  }
}

}  // namespace

uint64_t stored_frame_bytes(const Image& image) {
  return static_cast<uint64_t>(image.stored_columns) * static_cast<uint64_t>(image.stored_rows) *
         stored_pixel_bytes(image);
}

std::pair<double, double> stored_range(const Image& image) {
  const double codes = std::ldexp(1.0, image.stored);
  return image.is_signed ? std::pair(-codes / 2, codes / 2 - 1) : std::pair(0.0, codes - 1);
}

Result<void> read_frames(std::span<const FramePixels> frames, VoxelType to, bool fill_missing,
                         uint64_t memory_bytes, std::span<std::byte> out) {
  // Frames of a file are read in file order, and those of a mosaic once.
  std::vector<size_t> order(frames.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    const auto place = [](const FramePixels& f) {
      return std::tuple(std::string_view(f.image->file), f.index);
    };
    return place(frames[a]) < place(frames[b]);
  });
  const size_t slice_bytes = out.size() / frames.size();
  const auto target = [&](size_t i) { return out.subspan(i * slice_bytes, slice_bytes); };
  NativeReader native(fill_missing);
  std::vector<EncodedFrame> encoded;
  std::vector<std::pair<size_t, size_t>> slices_of_encoded;  // slice, and its number in `encoded`
  uint64_t encoded_bytes = 0;
  std::vector<std::byte> stored;
  const FramePixels* last = nullptr;
  size_t pixels = 0;
  for (const size_t i : order) {
    const Image& image = *frames[i].image;
    const bool is_same = last && last->image == frames[i].image && last->index == frames[i].index;
    last = &frames[i];
    if (image.is_encapsulated) {
      if (!is_same) {
        encoded.push_back({&image, frames[i].index});
        encoded_bytes += stored_frame_bytes(image);
      }
      slices_of_encoded.emplace_back(i, encoded.size() - 1);
      continue;
    }
    if (!is_same) {
      stored.resize(static_cast<size_t>(stored_frame_bytes(image)));
      const auto read = native.read(image, frames[i].index, stored);
      if (!read) return tl::unexpected(read.error());
      pixels = *read;
    }
    convert_slice(frames[i], stored, pixels, to, target(i));
  }
  if (encoded.empty()) return {};
  stored.resize(static_cast<size_t>(encoded_bytes));
  std::vector<bool> is_absent;
  if (auto r = decompress(encoded, fill_missing, memory_bytes, stored, is_absent); !r) return r;
  size_t begin = 0, current = 0;
  for (const auto& [i, number] : slices_of_encoded) {
    for (; current < number; ++current) {
      begin += static_cast<size_t>(stored_frame_bytes(*encoded[current].image));
    }
    const Image& image = *frames[i].image;
    const auto frame_bytes = static_cast<size_t>(stored_frame_bytes(image));
    const size_t there = is_absent[number] ? 0 : frame_bytes / stored_pixel_bytes(image);
    convert_slice(frames[i], std::span(stored).subspan(begin, frame_bytes), there, to, target(i));
  }
  return {};
}

}  // namespace isosplat::import::dicom
