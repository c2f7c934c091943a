#include <fmt/format.h>

#include "shared/import/hdf5/array.h"
#include "shared/import/hdf5/attributes.h"
#include "shared/import/hdf5/description.h"
#include "shared/import/text/header_text.h"

// Arrays of electron microscopy, MATLAB and openPMD.
//
// EMD (Berkeley, py4DSTEM)   a group with the attribute emd_group_type: data; dim1, dim2, …
//                            (or from dim0): positions along the axes, or the first two;
//                            attributes name, units
// EMD (Velox)                /Data/Image/ID: Data: y, x, images; Metadata: JSON text, a column
//                            for each image
// MATLAB 7.3                 attribute MATLAB_class; the axes are those of MATLAB in reverse order
// openPMD                    attributes of a mesh: axisLabels, gridSpacing, gridGlobalOffset,
//                            gridUnitSI (metres); position of the array in a cell
namespace isosplat::import {
namespace {

/// "[n_m]" → "nm".
std::string emd_unit(std::string unit) {
  std::erase_if(unit, [](char c) { return c == '[' || c == ']' || c == '_'; });
  return unit;
}

/// The value of a key in JSON text, if it is a string. Searches from `at` on.
std::string json_text(std::string_view json, std::string_view key, size_t at) {
  const std::string quoted = fmt::format("\"{}\"", key);
  at = json.find(quoted, std::min(at, json.size()));
  if (at == json.npos) return {};
  at = json.find_first_not_of(": \t\n\r", at + quoted.size());
  if (at == json.npos || json[at] != '"') return {};
  const size_t end = json.find('"', at + 1);
  return end == json.npos ? std::string() : std::string(json.substr(at + 1, end - at - 1));
}

Result<bool> describe_velox(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                            ArrayDescription& description) {
  if (!volume.parent.starts_with("/Data/Image/") || description.axes.size() != 3) return false;
  const auto metadata = hdf5_object_at(*file, volume.parent + "/Metadata");
  if (!metadata) return tl::unexpected(metadata.error());
  if (!*metadata) return false;
  auto& axes = description.axes;
  for (size_t i = 0; i < 3; ++i) axes[i].letter = "yxz"[i];
  description.knows_axes = true;
  description.notes.push_back(
      "the images of the EMD file are read as slices: their distance is not known");
  std::vector<uint64_t> sizes;
  const auto bytes = hdf5_small_array(file, **metadata, sizes);
  if (!bytes) return tl::unexpected(bytes.error());
  if (!*bytes || sizes.size() != 2) return true;
  std::string json;
  for (size_t i = 0; i < (*bytes)->size(); i += static_cast<size_t>(sizes[1])) {
    json += static_cast<char>((**bytes)[i]);
  }
  const size_t at = json.find("\"PixelSize\"");
  if (at == json.npos) return true;
  const auto width = number_in(json_text(json, "width", at)),
             height = number_in(json_text(json, "height", at));
  const std::string unit = json_text(json, "PixelUnitX", 0);
  if (!width || !height || !(*width > 0) || !(*height > 0)) return true;
  const double millimetres =
      axis_millimetres(unit.empty() ? "m" : unit, "an image", description.notes);
  axes[0].step = *height * millimetres;
  axes[1].step = *width * millimetres;
  return true;
}

}  // namespace

Result<bool> describe_emd(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                          ArrayDescription& description) {
  if (auto velox = describe_velox(file, volume, description); !velox || *velox) return velox;
  const auto group = hdf5_object_at(*file, volume.parent);
  if (!group) return tl::unexpected(group.error());
  const bool is_emd = *group && (hdf5_numbers(*file, **group, "emd_group_type") ||
                                 !hdf5_text(*file, **group, "emd_group_type").empty());
  if (!is_emd || !volume.path.ends_with("/data")) return false;
  const auto from_0 = hdf5_object_at(*file, volume.parent + "/dim0");
  if (!from_0) return tl::unexpected(from_0.error());
  bool has_any = false;
  for (size_t i = 0; i < description.axes.size(); ++i) {
    ArrayAxis& axis = description.axes[i];
    const std::string name = fmt::format("dim{}", *from_0 ? i : i + 1);
    const auto dim = hdf5_object_at(*file, volume.parent + "/" + name);
    if (!dim) return tl::unexpected(dim.error());
    if (!*dim) continue;
    has_any = true;
    axis.name = hdf5_text(*file, **dim, "name");
    axis.letter = axis_letter(axis.name);
    std::vector<uint64_t> sizes;
    auto positions = hdf5_small_array(file, **dim, sizes);
    if (!positions) return tl::unexpected(positions.error());
    if (!*positions || axis.size < 2 || sizes.size() != 1 || axis.letter == 'c' ||
        axis.letter == 't') {
      continue;
    }
    const bool has_two = sizes[0] == 2;  // the first ones of evenly spaced positions
    if (!has_two && sizes[0] != axis.size) continue;
    const std::string unit = emd_unit(hdf5_text(*file, **dim, "units"));
    if (unit == "px" || unit == "pixels" || unit == "pixel") continue;
    const double millimetres = axis_millimetres(unit, "the axis " + name, description.notes);
    if (!place_axis(axis, **positions, millimetres)) {
      return file->malformed(fmt::format("expected evenly spaced positions in {}", name));
    }
  }
  return has_any;
}

Result<bool> describe_matlab(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                             ArrayDescription& description) {
  auto& axes = description.axes;
  if (axes.size() < 3 || axes.size() > 5 ||
      hdf5_text(*file, volume.object, "MATLAB_class").empty()) {
    return false;
  }
  const size_t before = axes.size() - 3;
  for (size_t i = 0; i < 3; ++i) axes[before + i].letter = "zxy"[i];
  if (before > 0) axes[before - 1].letter = 't';
  if (before > 1) axes[0].letter = 'c';
  description.knows_axes = true;
  description.notes.push_back(
      "a MATLAB array does not say what its axes are: V(row, column, slice) is read with rows "
      "along "
      "y and columns along x, as MATLAB shows images; an array that was made as V(x, y, z) is "
      "mirrored by this (permute(V, [2 1 3]) in MATLAB exchanges them)");
  return true;
}

Result<bool> describe_open_pmd(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                               ArrayDescription& description) {
  const auto parent = hdf5_object_at(*file, volume.parent);
  if (!parent) return tl::unexpected(parent.error());
  // A mesh of scalars is the array; of vectors, the group of its components.
  for (const Hdf5Object* mesh : {&volume.object, *parent ? &**parent : nullptr}) {
    if (!mesh) continue;
    auto names = hdf5_texts(*file, *mesh, "axisLabels");
    const auto spacing = hdf5_numbers(*file, *mesh, "gridSpacing");
    auto& axes = description.axes;
    if (!names || !spacing || names->size() != axes.size() || spacing->size() != axes.size())
      continue;
    const auto offset = hdf5_numbers(*file, *mesh, "gridGlobalOffset");
    const auto unit = hdf5_numbers(*file, *mesh, "gridUnitSI");
    const auto position = hdf5_numbers(*file, volume.object, "position");
    const double millimetres = 1000 * (unit && unit->size() == 1 ? unit->front() : 1);
    // In Fortran's order, the fastest axis is the first one.
    const bool is_reversed = hdf5_text(*file, *mesh, "dataOrder") == "F";
    for (size_t i = 0; i < axes.size(); ++i) {
      const auto at = [&](const std::optional<std::vector<double>>& numbers) {
        return numbers && numbers->size() == axes.size() ? (*numbers)[i] : 0;
      };
      ArrayAxis& axis = axes[is_reversed ? axes.size() - 1 - i : i];
      axis.name = (*names)[i];
      axis.letter = axis_letter(axis.name);
      axis.step = (*spacing)[i] * millimetres;
      axis.first = at(offset) * millimetres + at(position) * *axis.step;
    }
    return true;
  }
  return false;
}

}  // namespace isosplat::import
