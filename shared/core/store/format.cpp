#include "shared/core/store/format.h"

#include <algorithm>

namespace isosplat {
namespace {

std::string dimensions(Index3 voxels) {
  return std::to_string(voxels.x) + " x " + std::to_string(voxels.y) + " x " +
         std::to_string(voxels.z);
}

}  // namespace

Result<void> check_dimensions(Index3 voxels) {
  const auto [min, max] = std::minmax({voxels.x, voxels.y, voxels.z});
  if (min < 2) {
    return fail(Status::no_cells, "expected at least 2 voxels along each axis, found " +
                                      dimensions(voxels) + ": such a volume has no isosurface");
  }
  if (max > kMaxVoxelsPerAxis) {
    return fail(Status::volume_too_large, "expected at most " + std::to_string(kMaxVoxelsPerAxis) +
                                              " voxels along each axis, found " +
                                              dimensions(voxels) + ": cut the volume into parts");
  }
  return {};
}

uint64_t total_pages(Index3 voxels, uint32_t page_log2) {
  uint64_t pages = 0;
  for (uint32_t level = 0; level < level_count(voxels); ++level) {
    const Index3 box = pages_of_level(level_grid(voxels, level).blocks, page_log2);
    pages +=
        static_cast<uint64_t>(box.x) * static_cast<uint64_t>(box.y) * static_cast<uint64_t>(box.z);
  }
  return pages;
}

Result<uint32_t> choose_page_log2(Index3 voxels) {
  if (auto checked = check_dimensions(voxels); !checked) return tl::unexpected(checked.error());
  for (uint32_t log2 = kMinPageLog2; log2 <= kMaxPageLog2; ++log2) {
    if (total_pages(voxels, log2) <= kMaxPages) return log2;
  }
  return fail(Status::volume_too_large,
              "expected at most " + std::to_string(kMaxPages) + " directory pages, found " +
                  std::to_string(total_pages(voxels, kMaxPageLog2)) + " for " + dimensions(voxels) +
                  " voxels: cut the volume into parts");
}

}  // namespace isosplat
