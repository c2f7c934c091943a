#include "shared/import/netcdf/netcdf.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/axes/cf_axis.h"
#include "shared/import/axes/packed_values.h"
#include "shared/import/axes/volume_axes.h"
#include "shared/import/netcdf/header.h"
#include "shared/import/text/commands.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/volume/type_names.h"
#include "shared/import/volume/volume_choices.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/strided_reader.h"

// Without netCDF's library, so that it is the same natively and in a browser, as HDF5
// (docs/decisions/014-hdf5-without-its-library.md).
namespace isosplat::import {
namespace {

using netcdf::Dimension;
using netcdf::Header;
using netcdf::Variable;

/// Where the elements of a variable are, in bytes of the file.
struct Layout {
  uint64_t begin = 0;
  std::vector<uint64_t> steps;  ///< along each axis
};

Result<Layout> layout_of(const std::filesystem::path& path, const Header& header,
                         const Variable& variable, uint64_t file_bytes) {
  const auto sizes = header.sizes(variable);
  Layout layout{variable.begin, std::vector<uint64_t>(sizes.size())};
  uint64_t step = voxel_bytes(*variable.type), end = 0;
  bool fits = true;
  for (size_t i = sizes.size(); i-- > 0 && fits;) {
    const bool is_record = header.dimensions[variable.dimensions[i]].is_record;
    layout.steps[i] = is_record ? header.record_bytes : step;
    uint64_t last = 0;
    fits = !__builtin_mul_overflow(layout.steps[i], sizes[i] - 1, &last) &&
           !__builtin_add_overflow(end, last, &end) &&
           !__builtin_mul_overflow(step, sizes[i], &step);
  }
  fits = fits && !__builtin_add_overflow(end, voxel_bytes(*variable.type), &end) &&
         !__builtin_add_overflow(end, layout.begin, &end);
  if (!fits || end > file_bytes) {
    return fail(Status::truncated,
                fmt::format("{}: expected {} bytes, to the end of {}, found {}: the file is "
                            "incomplete",
                            path.string(), fits ? fmt::format("{}", end) : "more than 2^64",
                            printable(variable.name), file_bytes));
  }
  return layout;
}

size_t long_axes(const std::vector<uint64_t>& sizes) {
  return static_cast<size_t>(
      std::count_if(sizes.begin(), sizes.end(), [](uint64_t size) { return size > 1; }));
}

bool is_volume(const Header& header, const Variable& variable) {
  const auto sizes = header.sizes(variable);
  return variable.type && long_axes(sizes) >= 3 &&
         std::find(sizes.begin(), sizes.end(), 0) == sizes.end();
}

std::string text_of(const Header& header, const Variable& variable) {
  return fmt::format("{} ({}, {})", printable(variable.name), voxel_type_name(*variable.type),
                     fmt::join(header.sizes(variable), " × "));
}

/// Variables with several elements along three axes; without any, those along more axes, which may
/// be times or channels.
std::vector<const Variable*> volumes_of(const Header& header) {
  std::vector<const Variable*> volumes;
  for (const Variable& variable : header.variables) {
    if (is_volume(header, variable)) volumes.push_back(&variable);
  }
  const auto has_three = [&](const Variable* each) { return long_axes(header.sizes(*each)) == 3; };
  if (std::any_of(volumes.begin(), volumes.end(), has_three)) {
    std::erase_if(volumes, [&](const Variable* each) { return !has_three(each); });
  }
  return volumes;
}

Result<const Variable*> choose(const std::filesystem::path& path, const Header& header,
                               const ImportOptions& options) {
  if (const Variable* named = header.find(options.dataset); named && !options.dataset.empty()) {
    if (is_volume(header, *named)) return named;
    if (!named->type) return unknown_type(path, "characters in " + printable(named->name));
    return fail(
        Status::no_cells,
        fmt::format("{}: expected a variable whose axes z, y and x have several voxels, found the "
                    "shape ({}) in {}: choose another one with --dataset",
                    path.string(), fmt::join(header.sizes(*named), ", "), printable(named->name)));
  }
  const auto volumes = volumes_of(header);
  constexpr size_t kMaxListed = 20;
  std::string list;
  for (size_t i = 0; i < std::min(volumes.size(), kMaxListed); ++i) {
    list += (i == 0 ? "" : ", ") + text_of(header, *volumes[i]);
  }
  if (volumes.size() > kMaxListed) list += ", …";
  if (!options.dataset.empty()) {
    return fail(
        Status::invalid_argument,
        fmt::format("{}: expected a variable {}, found {}: choose one of those with "
                    "--dataset",
                    path.string(), printable(options.dataset), list.empty() ? "no volumes" : list));
  }
  if (volumes.size() == 1) return volumes.front();
  if (volumes.empty()) {
    return fail(Status::no_cells,
                fmt::format("{}: expected a variable with several elements along three axes, found "
                            "none among {}: choose another file",
                            path.string(), header.variables.size()));
  }
  std::vector<VolumeChoice> offered;
  for (const Variable* each : volumes) {
    offered.push_back({.label = each->name, .name = text_of(header, *each), .dataset = each->name});
  }
  offer(options, std::move(offered));
  return fail(Status::invalid_argument,
              fmt::format("{}: expected one volume, found {}: {}: choose one with --dataset",
                          path.string(), volumes.size(), list));
}

/// The numbers of a variable with one axis; nothing if it is another one, or too long.
Result<std::optional<std::vector<double>>> positions_of(const std::filesystem::path& path,
                                                        const Header& header,
                                                        const Variable& variable,
                                                        ByteReader& file) {
  constexpr uint64_t kMaxNumbers = uint64_t{1} << 20;
  const auto sizes = header.sizes(variable);
  if (!variable.type || sizes.size() != 1 || sizes[0] == 0 || sizes[0] > kMaxNumbers) {
    return std::nullopt;
  }
  const auto layout = layout_of(path, header, variable, file.size_limit());
  if (!layout) return tl::unexpected(layout.error());
  const StoredVoxels stored{.type = *variable.type, .big_endian = true};
  std::vector<std::byte> bytes(stored_bytes(stored));
  std::vector<double> numbers;
  for (uint64_t i = 0; i < sizes[0]; ++i) {
    auto read = file.read(layout->begin + i * layout->steps[0], bytes);
    if (!read) return tl::unexpected(read.error());
    numbers.push_back(stored_number(stored, bytes));
  }
  return numbers;
}

/// The axes of a variable by the coordinate variables of its dimensions (CF, chapter 5).
Result<ArrayDescription> describe(const std::filesystem::path& path, const Header& header,
                                  const Variable& variable, ByteReader& file) {
  ArrayDescription description;
  for (const size_t i : variable.dimensions) {
    const Dimension& dimension = header.dimensions[i];
    description.axes.push_back({.name = dimension.name, .size = dimension.size});
  }
  const bool has_width =
      std::any_of(description.axes.begin(), description.axes.end(),
                  [](const ArrayAxis& axis) { return lower_case(axis.name) == "width"; });
  for (ArrayAxis& axis : description.axes) {
    const Variable* coordinates = header.find(axis.name);
    if (coordinates) name_by_positions(axis, *coordinates);
    if (axis.letter == 0) axis.letter = axis_letter(axis.name, has_width);
    if (!coordinates || axis.size < 2 || axis.letter == 'c') continue;
    auto positions = positions_of(path, header, *coordinates, file);
    if (!positions) return tl::unexpected(positions.error());
    if (!*positions) continue;
    if (axis.letter == 't') {
      set_times(axis, std::move(**positions), coordinates->text("units"));
      continue;
    }
    auto placed = place_by_positions(axis, **positions, *coordinates, path, description.notes);
    if (!placed) return tl::unexpected(placed.error());
  }
  return description;
}

std::string advice(const std::filesystem::path& path, const Header& header,
                   const Variable& variable) {
  const auto sizes = header.sizes(variable);
  return fmt::format(
      "save one volume of it with python3 -c \"import sys, netCDF4, numpy; "
      "numpy.save('volume.npy', netCDF4.Dataset(sys.argv[1])[sys.argv[2]][{}])\" {} {}",
      numpy_index({sizes.begin(), sizes.end()}), shell_word(path),
      shell_word(printable(variable.name)));
}

}  // namespace

bool is_netcdf(std::string_view beginning) {
  using namespace std::string_view_literals;
  return beginning.starts_with("CDF\1"sv) || beginning.starts_with("CDF\2"sv) ||
         beginning.starts_with("CDF\5"sv);
}

Result<OpenVolume> open_netcdf(const std::filesystem::path& path, const ImportOptions& options) {
  const auto header = netcdf::read_header(path);
  if (!header) return tl::unexpected(header.error());
  const auto chosen = choose(path, *header, options);
  if (!chosen) return tl::unexpected(chosen.error());
  const Variable& variable = **chosen;
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  const auto layout = layout_of(path, *header, variable, (*file)->size_limit());
  if (!layout) return tl::unexpected(layout.error());
  auto description = describe(path, *header, variable, **file);
  if (!description) return tl::unexpected(description.error());
  auto axes = volume_axes({.file = path,
                           .format = "netCDF",
                           .name = variable.name,
                           .advice = advice(path, *header, variable)},
                          std::move(*description), options);
  if (!axes) return tl::unexpected(axes.error());

  const ArrayPart& part = axes->part;
  StridedBytes bytes{.first = layout->begin, .element = voxel_bytes(*variable.type)};
  for (size_t i = 0; i < layout->steps.size(); ++i) bytes.first += part.at[i] * layout->steps[i];
  for (size_t i = 0; i < 3; ++i) {
    bytes.sizes[i] = part.sizes[i];
    bytes.steps[i] = layout->steps[part.axes[i]];
  }
  const auto size = [&](size_t axis) { return static_cast<int64_t>(part.sizes[axis]); };
  ArrayVolume array =
      make_array("netCDF", path, {size(2), size(1), size(0)}, axes->geometry, options);
  array.geometry = axes->geometry;  // options.spacing is along x, y and z
  array.stored = {.type = *variable.type, .big_endian = true};
  const MissingNumbers missing = packed_values(variable, false, array.stored);
  auto result =
      open_array(std::move(array), read_strided(std::move(*file), bytes), std::move(axes->notes));
  if (result && !options.missing_value && options.finds_missing_values) {
    remove_missing(missing, *result);
  }
  return result;
}

}  // namespace isosplat::import
