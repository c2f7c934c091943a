#include "shared/import/dicom/codec.h"

#include <fmt/format.h>

#include "shared/import/dicom/pixels.h"

namespace isosplat::import::dicom {

tl::unexpected<Error> decompression_error(const EncodedFrame& frame) {
  return fail(
      Status::malformed_volume,
      fmt::format("{}: frame {} cannot be decompressed (transfer syntax {}): the file is damaged, "
                  "or its header is wrong; export it again, for example uncompressed",
                  frame.image->file, frame.index + 1, frame.image->transfer_syntax));
}

Result<void> decompress(std::span<const EncodedFrame> frames, bool fill_missing,
                        [[maybe_unused]] uint64_t memory_bytes, std::span<std::byte> out,
                        std::vector<bool>& is_absent) {
#ifdef __EMSCRIPTEN__
  return decompress_plainly(frames, fill_missing, out, is_absent);
#else
  return decompress_with_gdcm(frames, fill_missing, memory_bytes, out, is_absent);
#endif
}

Result<void> decode_each(std::span<const EncodedFrame> frames, bool fill_missing,
                         const DecodeFrame& decode, std::span<std::byte> out,
                         std::span<std::byte> absent) {
  std::unique_ptr<ByteReader> file;
  std::vector<std::vector<Fragment>> fragments;
  const Image* opened = nullptr;
  size_t at = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const EncodedFrame& frame = frames[i];
    const Image& image = *frame.image;
    const auto to = out.subspan(at, static_cast<size_t>(stored_frame_bytes(image)));
    at += to.size();
    const bool can_be_missing = fill_missing && image.cut_off;
    if (opened != &image) {
      auto plain = open_plain(image.file);
      if (!plain) return tl::unexpected(plain.error());
      file = std::move(*plain);
      auto found = find_fragments(*file, image, can_be_missing);
      if (!found) return tl::unexpected(found.error());
      fragments = std::move(*found);
      opened = &image;
    }
    const std::vector<Fragment>& parts = fragments[frame.index];
    const auto decoded = parts.empty() && can_be_missing ? decompression_error(frame)
                                                         : decode(*file, frame, parts, to);
    if (decoded) continue;
    if (!can_be_missing) return decoded;
    absent[i] = std::byte{1};
  }
  return {};
}

}  // namespace isosplat::import::dicom
