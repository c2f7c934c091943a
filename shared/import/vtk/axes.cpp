#include "shared/import/vtk/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/geometry/even_axis.h"
#include "shared/import/voxels/text_voxels.h"

namespace isosplat::import {
namespace {

Result<std::vector<double>> read_numbers(const std::filesystem::path& path, const VtkFile& file,
                                         const VtkArray& array) {
  auto reader = file.is_binary ? open_plain(path)
                               : open_text_voxels(path, array.offset, *array.type, array.end);
  if (!reader) return tl::unexpected(reader.error());
  StoredVoxels stored;
  stored.type = *array.type;
  stored.big_endian = file.is_binary || std::endian::native == std::endian::big;
  const auto count = static_cast<size_t>(array.values);
  std::vector<std::byte> bytes(count * voxel_bytes(stored.type));
  if (auto read = (*reader)->read(file.is_binary ? array.offset : 0, bytes); !read) {
    return tl::unexpected(read.error());
  }
  to_native_order(stored, bytes);
  std::vector<double> numbers(count);
  with_voxel_type(stored.type, [&]<class T>(T) {
    for (size_t i = 0; i < count; ++i) {
      T value;
      std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
      numbers[i] = static_cast<double>(value);
    }
  });
  return numbers;
}

}  // namespace

Result<char> place_vtk_axes(const std::filesystem::path& path, VtkFile& file) {
  const int64_t sizes[] = {file.dimensions.x, file.dimensions.y, file.dimensions.z};
  double* const origins[] = {&file.origin.x, &file.origin.y, &file.origin.z};
  double* const spacings[] = {&file.spacing.x, &file.spacing.y, &file.spacing.z};
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::string name = fmt::format("{}_coordinates", "xyz"[axis]);
    const auto array = std::find_if(file.geometry.begin(), file.geometry.end(),
                                    [&](const VtkArray& each) { return each.name == name; });
    if (array == file.geometry.end() || !array->type ||
        static_cast<int64_t>(array->values) != sizes[axis] || sizes[axis] > kMaxVoxelsPerAxis) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected {} {} of numbers, found others: the VTK file is "
                              "damaged; export the volume again",
                              path.string(), sizes[axis], name));
    }
    const auto positions = read_numbers(path, file, *array);
    if (!positions) return tl::unexpected(positions.error());
    if (sizes[axis] < 2) continue;  // no cells, which is checked later
    const auto even = even_axis(*positions);
    if (!even) return "xyz"[axis];
    *origins[axis] = even->origin;
    *spacings[axis] = even->spacing;
  }
  file.has_no_spacing = false;
  return '\0';
}

bool is_uneven_vtk_legacy(const std::filesystem::path& path) {
  auto file = read_vtk_sections(path, {"rectilinear_grid"});
  if (!file) return false;
  for (const int64_t each : {file->dimensions.x, file->dimensions.y, file->dimensions.z}) {
    if (each < 2) return false;
  }
  const auto uneven = place_vtk_axes(path, *file);
  return uneven && *uneven != 0;
}

}  // namespace isosplat::import
