#include "shared/import/volume/refusals.h"

#include <fmt/format.h>

namespace isosplat::import {

tl::unexpected<Error> not_scalar(const std::filesystem::path& path, int components) {
  return fail(Status::unsupported_type,
              fmt::format("{}: expected one number per voxel, found {} (colours or vectors): save "
                          "one channel, or the magnitude, as a separate volume",
                          path.string(), components));
}

tl::unexpected<Error> unknown_type(const std::filesystem::path& path, std::string_view type) {
  return fail(Status::unsupported_type,
              fmt::format("{}: expected voxels of type u8, i8, u16, i16, u32, i32, u64, i64, f32 "
                          "or f64, found {}: convert the volume to one of them",
                          path.string(), type));
}

}  // namespace isosplat::import
