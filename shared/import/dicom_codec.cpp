#include "shared/import/dicom_codec.h"

#include <fmt/format.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>

#include "shared/import/dicom_fragments.h"
#include "shared/import/dicom_pixels.h"
#include "shared/import/isolated.h"

namespace isosplat::dicom {
namespace {

tl::unexpected<Error> decompression_error(const Image& image, uint32_t index) {
  return fail(
      Status::malformed_volume,
      fmt::format("{}: frame {} cannot be decompressed (transfer syntax {}): the file is damaged, "
                  "or its header is wrong; export it again, for example uncompressed",
                  image.file, index + 1, image.transfer_syntax));
}

gdcm::Image describe(const Image& image) {
  gdcm::Image out;
  out.SetNumberOfDimensions(2);
  out.SetDimension(0, static_cast<unsigned>(image.columns));
  out.SetDimension(1, static_cast<unsigned>(image.rows));
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
Result<void> decompress_frame(ByteReader& file, const Image& image, uint32_t index,
                              const std::vector<Fragment>& fragments, std::span<std::byte> out) {
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
      picture.GetDimension(0) != static_cast<unsigned>(image.columns) ||
      picture.GetDimension(1) != static_cast<unsigned>(image.rows)) {
    return decompression_error(image, index);
  }
  return {};
}

/// `absent`: one byte per frame, 1 if the frame is absent.
Result<std::string> decompress_all(std::span<const EncodedFrame> frames, bool fill_missing,
                                   std::span<std::byte> out, std::span<std::byte> absent) {
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
    if (fragments[frame.index].empty() && can_be_missing) {
      absent[i] = std::byte{1};
      continue;
    }
    if (auto r = decompress_frame(*file, image, frame.index, fragments[frame.index], to); !r) {
      if (!can_be_missing) return tl::unexpected(r.error());
      absent[i] = std::byte{1};
    }
  }
  return std::string();
}

}  // namespace

Result<void> decompress(std::span<const EncodedFrame> frames, bool fill_missing,
                        uint64_t memory_bytes, std::span<std::byte> out,
                        std::vector<bool>& is_absent) {
  auto shared = SharedBytes::allocate(out.size() + frames.size());
  if (!shared) return tl::unexpected(shared.error());
  const auto pixels = shared->bytes().first(out.size());
  const auto absent = shared->bytes().last(frames.size());
  const auto done =
      run_isolated(frames.front().image->file, memory_bytes, [&]() -> Result<std::string> {
        try {
          return decompress_all(frames, fill_missing, pixels, absent);
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

}  // namespace isosplat::dicom
