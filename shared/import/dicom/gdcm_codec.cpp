#include <fmt/format.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>

#include "shared/import/codecs/isolated.h"
#include "shared/import/dicom/codec.h"

namespace isosplat::import::dicom {
namespace {

gdcm::Image describe(const Image& image) {
  gdcm::Image out;
  out.SetNumberOfDimensions(2);
  out.SetDimension(0, static_cast<unsigned>(image.stored_columns));
  out.SetDimension(1, static_cast<unsigned>(image.stored_rows));
  // GDCM aborts if the stored bits do not start with the lowest bit. Therefore it gets all bits
  // below the high bit as stored bits; the caller shifts the pixels.
  out.SetPixelFormat(gdcm::PixelFormat(1, static_cast<unsigned short>(image.allocated),
                                       static_cast<unsigned short>(image.high_bit + 1),
                                       static_cast<unsigned short>(image.high_bit),
                                       image.is_signed ? 1 : 0));
  out.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  out.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(image.transfer_syntax.c_str()));
  return out;
}

/// Decompresses one frame. Runs in the child process.
Result<void> decompress_frame(ByteReader& file, const EncodedFrame& frame,
                              std::span<const Fragment> fragments, std::span<std::byte> out) {
  const Image& image = *frame.image;
  const gdcm::SmartPointer<gdcm::SequenceOfFragments> sequence = new gdcm::SequenceOfFragments;
  std::vector<char> bytes;
  for (const Fragment& fragment : fragments) {
    bytes.resize(fragment.bytes);
    auto read = file.read(fragment.offset, std::as_writable_bytes(std::span(bytes)));
    if (!read) return read;
    gdcm::Fragment item;
    item.SetByteValue(bytes.data(), fragment.bytes);
    sequence->AddFragment(item);
  }
  gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
  pixels.SetVR(gdcm::VR::OB);
  pixels.SetValue(*sequence);
  gdcm::Image picture = describe(image);
  picture.SetDataElement(pixels);
  if (picture.GetBufferLength() != out.size() ||
      !picture.GetBuffer(reinterpret_cast<char*>(out.data())) ||
      picture.GetPixelFormat().GetBitsAllocated() != image.allocated ||
      picture.GetDimension(0) != static_cast<unsigned>(image.stored_columns) ||
      picture.GetDimension(1) != static_cast<unsigned>(image.stored_rows)) {
    return decompression_error(frame);
  }
  return {};
}

}  // namespace

Result<void> decompress_with_gdcm(std::span<const EncodedFrame> frames, bool fill_missing,
                                  uint64_t memory_bytes, std::span<std::byte> out,
                                  std::vector<bool>& is_absent) {
  auto shared = SharedBytes::allocate(out.size() + frames.size());
  if (!shared) return tl::unexpected(shared.error());
  const auto pixels = shared->bytes().first(out.size());
  const auto absent = shared->bytes().last(frames.size());
  const auto done =
      run_isolated(frames.front().image->file, memory_bytes, [&]() -> Result<std::string> {
        try {
          const auto decoded = decode_each(frames, fill_missing, decompress_frame, pixels, absent);
          if (!decoded) return tl::unexpected(decoded.error());
          return std::string();
        } catch (const std::bad_alloc&) {
          return fail(
              Status::out_of_memory,
              fmt::format(
                  "{}: decompression needs more memory than the limit: increase it with --memory",
                  frames.front().image->file));
        } catch (const std::exception& e) {
          return fail(Status::malformed_volume,
                      fmt::format("{}: its pixels cannot be decompressed: {}: the file is damaged; "
                                  "copy or export it again",
                                  frames.front().image->file, e.what()));
        }
      });
  if (!done) return tl::unexpected(done.error());
  std::copy(pixels.begin(), pixels.end(), out.begin());
  is_absent.clear();
  for (const std::byte b : absent) is_absent.push_back(b != std::byte{0});
  return {};
}

}  // namespace isosplat::import::dicom
