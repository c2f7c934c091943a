#include <fmt/format.h>

#include "shared/import/dicom_codec.h"
#include "shared/import/formats.h"

// What is decoded by libraries that exist for native programs only: errors that name the program.
namespace isosplat {

Result<OpenVolume> open_tiff_file(const std::filesystem::path& path, const ImportOptions&) {
  return fail(Status::unsupported_format,
              fmt::format("{}: the browser does not read TIFF stacks: build the store with the "
                          "program (isosplat build {}), and open that",
                          path.string(), path.string()));
}

Result<OpenVolume> open_tiff_folder(const std::filesystem::path& path,
                                    const ImportOptions& options) {
  return open_tiff_file(path, options);
}

namespace dicom {

Result<void> decompress(std::span<const EncodedFrame> frames, bool, uint64_t, std::span<std::byte>,
                        std::vector<bool>&) {
  const Image& image = *frames.front().image;
  return fail(Status::unsupported_format,
              fmt::format("{}: the browser does not decompress DICOM pixels (transfer syntax {}): "
                          "build the store with the program (isosplat build), and open that",
                          image.file, image.transfer_syntax));
}

}  // namespace dicom
}  // namespace isosplat
