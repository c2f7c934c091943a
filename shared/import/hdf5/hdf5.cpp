#include "shared/import/hdf5/hdf5.h"

#include <fmt/format.h>

#include "shared/import/axes/packed_values.h"
#include "shared/import/axes/volume_axes.h"
#include "shared/import/hdf5/array.h"
#include "shared/import/hdf5/attributes.h"
#include "shared/import/hdf5/description.h"
#include "shared/import/hdf5/volumes.h"
#include "shared/import/text/header_text.h"
#include "shared/import/voxels/array_source.h"

// Reads volumes of HDF5 files. Without HDF5's library, so that it is the same natively and in a
// browser, and so that hostile files are read by checked code
// (docs/decisions/014-hdf5-without-its-library.md).
namespace isosplat::import {
namespace {

/// Whether a part has all elements of its array.
bool is_whole(const ArrayPart& part, const Hdf5Layout& layout) {
  uint64_t all = 1;
  for (const uint64_t size : layout.sizes) all *= size;
  return part.sizes[0] * part.sizes[1] * part.sizes[2] == all;
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
  ImportOptions rest = options;
  const auto volume = choose_hdf5_volume(*file, rest);
  if (!volume) return tl::unexpected(volume.error());
  auto description = describe_hdf5(file, *volume);
  if (!description) return tl::unexpected(description.error());
  const bool is_unsigned = description->is_unsigned;
  auto axes = volume_axes(
      {path, "HDF5", volume->path, volume->object.has_other_attributes, hdf5_advice(path, *volume)},
      std::move(*description), rest);
  if (!axes) return tl::unexpected(axes.error());
  auto layout = read_hdf5_layout(*file, volume->object, volume->sizes, volume->type.bytes);
  if (!layout) return tl::unexpected(layout.error());
  if (layout->address == kHdf5Undefined) {
    return file->malformed(fmt::format("expected an array with elements in {}, found none written",
                                       printable(volume->path)));
  }
  const auto size = [&](size_t axis) { return static_cast<int64_t>(axes->part.sizes[axis]); };
  ArrayVolume array =
      make_array("HDF5", path, {size(2), size(1), size(0)}, axes->geometry, options);
  array.geometry = axes->geometry;  // options.spacing is along x, y and z
  array.stored = volume->type.stored;
  const MissingNumbers missing =
      packed_values(Hdf5Attributes(*file, volume->object), is_unsigned, array.stored);
  std::unique_ptr<ByteReader> reader;
  if (layout->index == Hdf5Layout::Index::none && is_whole(axes->part, *layout)) {
    // An address beyond the end: open_array says that the file is incomplete.
    array.offset = file->base() + std::min(layout->address, file->bytes());
    array.ends_with_file = false;
    auto plain = open_plain(path);
    if (!plain) return tl::unexpected(plain.error());
    reader = std::move(*plain);
  } else {
    auto part = open_hdf5_array(file, std::move(*layout), std::move(axes->part));
    if (!part) return tl::unexpected(part.error());
    reader = std::move(*part);
  }
  auto result = open_array(std::move(array), std::move(reader), std::move(axes->notes));
  if (result && !options.missing_value && options.finds_missing_values) {
    remove_missing(missing, *result);
  }
  return result;
}

}  // namespace isosplat::import
