#include <fmt/format.h>

#include <cmath>

#include "shared/import/array_source.h"
#include "shared/import/formats.h"
#include "shared/import/hdf5_array.h"
#include "shared/import/hdf5_attributes.h"
#include "shared/import/hdf5_axes.h"
#include "shared/import/hdf5_volumes.h"
#include "shared/import/header_text.h"

// Reads volumes of HDF5 files. Without HDF5's library, so that it is the same natively and in a
// browser, and so that hostile files are read by checked code
// (docs/decisions/014-hdf5-without-its-library.md).
namespace isosplat {
namespace {

/// Slope, intercept and fill value of netCDF's conventions (CF).
void take_values(const Hdf5File& file, const Hdf5Volume& volume, StoredVoxels& stored,
                 std::optional<FillValue>& fill) {
  const auto number = [&](const char* name) -> std::optional<double> {
    const auto numbers = hdf5_numbers(file, volume.object, name);
    if (!numbers || numbers->size() != 1 || !std::isfinite(numbers->front())) return std::nullopt;
    return numbers->front();
  };
  if (const auto slope = number("scale_factor"); slope && *slope != 0) stored.slope = *slope;
  if (const auto intercept = number("add_offset")) stored.intercept = *intercept;
  if (const auto value = number("_FillValue")) {
    const double real = stored.intercept + stored.slope * *value;
    if (std::isfinite(real)) fill = FillValue{real, real};
  }
}

}  // namespace

bool is_hdf5(std::string_view beginning) {
  for (const uint64_t place : kHdf5SuperblockPlaces) {
    if (place < beginning.size() &&
        beginning.substr(static_cast<size_t>(place)).starts_with(kHdf5Signature)) {
      return true;
    }
  }
  return false;
}

Result<std::vector<std::string>> hdf5_datasets(const std::filesystem::path& path) {
  auto file = Hdf5File::open(path);
  if (!file) return tl::unexpected(file.error());
  const auto volumes = hdf5_volumes(*file);
  if (!volumes) return tl::unexpected(volumes.error());
  std::vector<std::string> paths;
  for (const Hdf5Volume& volume : *volumes) paths.push_back(volume.path);
  return paths;
}

Result<OpenVolume> open_hdf5(const std::filesystem::path& path, const ImportOptions& options) {
  auto opened = Hdf5File::open(path);
  if (!opened) return tl::unexpected(opened.error());
  const auto file = std::make_shared<Hdf5File>(std::move(*opened));
  if (const auto minc = hdf5_object_at(*file, "minc-2.0"); !minc) {
    return tl::unexpected(minc.error());
  } else if (*minc) {
    return fail(
        Status::unsupported_format,
        fmt::format("{}: expected a volume whose values are stored, found MINC, which scales "
                    "each slice: convert it to NIfTI with mnc2nii",
                    path.string()));
  }
  const auto volume = choose_hdf5_volume(*file, options.dataset);
  if (!volume) return tl::unexpected(volume.error());
  if (const auto step = choose_step(path, 1, options); !step) return tl::unexpected(step.error());
  auto axes = hdf5_axes(file, *volume, options);
  if (!axes) return tl::unexpected(axes.error());
  auto layout = read_hdf5_layout(*file, volume->object, volume->sizes, volume->type.bytes);
  if (!layout) return tl::unexpected(layout.error());
  if (layout->address == kHdf5Undefined) {
    return file->malformed(fmt::format("expected an array with elements in {}, found none written",
                                       hdf5_printable(volume->path)));
  }
  const auto size = [&](size_t axis) { return static_cast<int64_t>(axes->sizes[axis]); };
  ArrayVolume array =
      make_array("HDF5", path, {size(2), size(1), size(0)}, axes->geometry, options);
  array.geometry = axes->geometry;  // options.spacing is along x, y and z
  array.stored = volume->type.stored;
  std::optional<FillValue> fill;
  take_values(*file, *volume, array.stored, fill);
  std::unique_ptr<ByteReader> reader;
  if (layout->index == Hdf5Layout::Index::none) {
    // An address beyond the end: open_array says that the file is incomplete.
    array.offset = file->base() + std::min(layout->address, file->bytes());
    array.ends_with_file = false;
    auto plain = open_plain(path);
    if (!plain) return tl::unexpected(plain.error());
    reader = std::move(*plain);
  } else {
    auto chunked = open_hdf5_array(file, std::move(*layout));
    if (!chunked) return tl::unexpected(chunked.error());
    reader = std::move(*chunked);
  }
  auto result = open_array(std::move(array), std::move(reader), std::move(axes->notes));
  if (result) result->fill_value = fill;
  return result;
}

}  // namespace isosplat
