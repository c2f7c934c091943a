#include "shared/import/zarr/zarr.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/zarr/array.h"
#include "shared/import/zarr/image.h"

namespace isosplat::import {
namespace {

using zarr::Axis;
using zarr::Image;
using zarr::Node;
using zarr::Scale;

/// The scale that the options or the path choose; else the finest.
Result<size_t> chosen_scale(const Image& image, const std::filesystem::path& path,
                            const ImportOptions& options) {
  if (options.dataset.empty()) return image.chosen.value_or(0);
  std::vector<std::string> paths;
  for (const Scale& scale : image.scales) paths.push_back(scale.path);
  const auto found = std::find(paths.begin(), paths.end(), options.dataset);
  if (found != paths.end()) return static_cast<size_t>(found - paths.begin());
  return fail(Status::invalid_argument,
              fmt::format("{}: expected one of its scales as --dataset, {}, found {}",
                          path.string(), fmt::join(paths, ", "), options.dataset));
}

/// The index along an axis beside x, y and z.
Result<uint64_t> index_along(const Axis& axis, size_t number, uint64_t size, const Image& image,
                             const Scale& scale, const ImportOptions& options,
                             std::vector<std::string>& notes) {
  const std::string name = lower_case(axis.name);
  if (name == "c" || name == "channel") {
    return choose_channel(image.folder, size, options, image.channels);
  }
  if (name == "t" || name == "time") {
    const TimeAxis times = TimeAxis::regular(scale.translation[number], scale.scale[number],
                                             static_cast<int64_t>(size), axis.unit);
    return choose_step(image.folder, static_cast<int64_t>(size), options, times);
  }
  if (size > 1) {
    const std::string shown = axis.name.empty() ? fmt::format("axis {}", number + 1) : axis.name;
    notes.push_back(fmt::format("{}: 0 of 0 to {} is read", shown, size - 1));
  }
  return uint64_t{0};
}

}  // namespace

bool is_zarr(const std::filesystem::path& folder) {
  return zarr::is_node(folder);
}

Result<OpenVolume> open_zarr(const std::filesystem::path& folder, const ImportOptions& options) {
  const auto image = zarr::read_image(folder);
  if (!image) return tl::unexpected(image.error());
  const auto chosen = chosen_scale(*image, folder, options);
  if (!chosen) return tl::unexpected(chosen.error());
  const Scale& scale = image->scales[*chosen];
  const auto node =
      zarr::read_node(scale.path.empty() ? image->folder : image->folder / scale.path);
  if (!node) return tl::unexpected(node.error());
  const ChunkGrid& grid = node->array->grid;
  const auto spatial = zarr::spatial_axes(image->axes, image->folder);
  if (!spatial) return tl::unexpected(spatial.error());
  const auto [x, y, z] = *spatial;

  std::vector<std::string> notes;
  ArrayPart part{{z, y, x}, {grid.sizes[z], grid.sizes[y], grid.sizes[x]}, {}};
  part.at.resize(grid.sizes.size());
  for (size_t i = 0; i < grid.sizes.size(); ++i) {
    if (i == x || i == y || i == z) continue;
    const auto at = index_along(image->axes[i], i, grid.sizes[i], *image, scale, options, notes);
    if (!at) return tl::unexpected(at.error());
    part.at[i] = *at;
  }
  const HeaderGeometry geometry = zarr::geometry_of(scale, image->axes, *spatial, notes);
  const auto size = [&](size_t axis) { return static_cast<int64_t>(grid.sizes[axis]); };
  ArrayVolume array = make_array(image->is_ome ? "OME-Zarr" : "Zarr", folder,
                                 {size(x), size(y), size(z)}, geometry, options);
  array.name = zarr::name_of(folder);
  array.stored = node->array->stored;
  auto reader = zarr::open_array(*node, part, notes);
  return import::open_array(std::move(array), std::move(reader), std::move(notes));
}

}  // namespace isosplat::import
