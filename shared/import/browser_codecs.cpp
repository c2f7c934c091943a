#include <fmt/format.h>

#include "shared/import/dicom_codec.h"

// What is decoded by libraries that exist for native programs only: errors that name the program.
namespace isosplat::dicom {

Result<void> decompress(std::span<const EncodedFrame> frames, bool, uint64_t, std::span<std::byte>,
                        std::vector<bool>&) {
  const Image& image = *frames.front().image;
  return fail(Status::unsupported_format,
              fmt::format("{}: the browser does not decompress DICOM pixels (transfer syntax {}): "
                          "build the store with the program (isosplat build), and open that",
                          image.file, image.transfer_syntax));
}

}  // namespace isosplat::dicom
