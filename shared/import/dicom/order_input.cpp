#include "shared/import/dicom/order_input.h"

#include <fmt/format.h>

namespace isosplat::import::dicom {

std::string OrderInput::name_of(uint32_t frame) const {
  const Image& image = image_of(frame);
  const std::string name = std::filesystem::path(image.file).filename().string();
  return image.frames == 1 ? name : fmt::format("frame {} of {}", frame_of(frame).index + 1, name);
}

tl::unexpected<Error> OrderInput::malformed(const std::string& text) const {
  return fail(Status::malformed_volume, fmt::format("{}: {}", path.string(), text));
}

}  // namespace isosplat::import::dicom
