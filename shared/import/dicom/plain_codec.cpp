#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "shared/import/codecs/pack_bits.h"
#include "shared/import/dicom/codec.h"
#include "shared/import/dicom/lossless_jpeg.h"

namespace isosplat::import::dicom {
namespace {

bool is_run_lengths(const Image& image) {
  return image.transfer_syntax == "1.2.840.10008.1.2.5";
}

bool is_lossless_jpeg(const Image& image) {
  return image.transfer_syntax == "1.2.840.10008.1.2.4.57" ||
         image.transfer_syntax == "1.2.840.10008.1.2.4.70";
}

uint32_t u32_at(std::span<const uint8_t> bytes, size_t at) {
  return bytes[at] | bytes[at + 1] << 8 | bytes[at + 2] << 16 | uint32_t{bytes[at + 3]} << 24;
}

/// Run lengths (PS3.5, annex G): the number of segments and 15 offsets; then the segments. The
/// first segment has the highest bytes of all pixels.
bool expand_run_lengths(std::span<const uint8_t> in, size_t pixel, std::span<std::byte> out) {
  constexpr size_t kHeader = 64;
  if (in.size() < kHeader || u32_at(in, 0) != pixel) return false;
  std::vector<uint8_t> plane(out.size() / pixel);
  for (size_t segment = 0; segment < pixel; ++segment) {
    const size_t begin = u32_at(in, 4 + 4 * segment);
    const size_t end = segment + 1 < pixel ? u32_at(in, 8 + 4 * segment) : in.size();
    if (begin < kHeader || begin > end || end > in.size()) return false;
    if (!expand_pack_bits(in.subspan(begin, end - begin), plane)) return false;
    for (size_t i = 0, to = pixel - 1 - segment; i < plane.size(); ++i, to += pixel) {
      out[to] = static_cast<std::byte>(plane[i]);
    }
  }
  return true;
}

bool expand_lossless_jpeg(std::span<const uint8_t> in, const Image& image,
                          std::span<std::byte> out) {
  const size_t pixel = static_cast<size_t>(image.allocated) / 8;
  if (pixel > 2) return false;
  std::vector<uint16_t> samples(out.size() / pixel);
  const int bits = decode_lossless_jpeg(in, static_cast<size_t>(image.stored_columns), samples);
  if (bits == 0 || bits > image.allocated) return false;
  for (size_t i = 0; i < samples.size(); ++i) std::memcpy(&out[i * pixel], &samples[i], pixel);
  return true;
}

Result<void> decode(ByteReader& file, const EncodedFrame& frame,
                    std::span<const Fragment> fragments, std::span<std::byte> out) {
  const Image& image = *frame.image;
  if (!is_run_lengths(image) && !is_lossless_jpeg(image)) {
    return fail(Status::unsupported_format,
                fmt::format("{}: the browser does not decompress DICOM pixels of transfer syntax "
                            "{}: build the store with the program (isosplat build), and open that",
                            image.file, image.transfer_syntax));
  }
  // Lossless codes are hardly longer than the pixels they encode.
  size_t room = 4 * out.size() + 65536;
  std::vector<uint8_t> bytes;
  for (const Fragment& fragment : fragments) {
    const size_t count = std::min<size_t>(fragment.bytes, room - bytes.size());
    const size_t at = bytes.size();
    bytes.resize(at + count);
    auto read = file.read(fragment.offset, std::as_writable_bytes(std::span(bytes).subspan(at)));
    if (!read) return read;
  }
  const bool done = is_run_lengths(image)
                        ? expand_run_lengths(bytes, static_cast<size_t>(image.allocated) / 8, out)
                        : expand_lossless_jpeg(bytes, image, out);
  if (!done) return decompression_error(frame);
  return {};
}

}  // namespace

Result<void> decompress_plainly(std::span<const EncodedFrame> frames, bool fill_missing,
                                std::span<std::byte> out, std::vector<bool>& is_absent) {
  std::vector<std::byte> absent(frames.size());
  auto decoded = decode_each(frames, fill_missing, decode, out, absent);
  if (!decoded) return decoded;
  is_absent.clear();
  for (const std::byte b : absent) is_absent.push_back(b != std::byte{0});
  return {};
}

}  // namespace isosplat::import::dicom
