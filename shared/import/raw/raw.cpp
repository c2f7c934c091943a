#include "shared/import/raw/raw.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/type_names.h"
#include "shared/import/voxels/array_source.h"

namespace isosplat::import {
namespace {

struct RawLayout {
  Vec3<int64_t> dims;
  VoxelType type;
};

constexpr std::string_view kDigits = "0123456789";
constexpr size_t kMaxDigits = 7;

/// The first three numbers of at most seven digits with an x between them, as in 256x256x128.
std::optional<Vec3<int64_t>> dims_in(std::string_view name) {
  for (size_t start = 0; start < name.size(); ++start) {
    size_t at = start;
    std::array<int64_t, 3> numbers{};
    for (size_t i = 0; i < 3; ++i) {
      const std::string_view rest = name.substr(at);
      size_t digits = std::min(rest.find_first_not_of(kDigits), rest.size());
      if (i == 2) digits = std::min(digits, kMaxDigits);
      if (digits == 0 || digits > kMaxDigits) break;
      if (i < 2 && !rest.substr(digits).starts_with('x')) break;
      numbers[i] = *whole_number(rest.substr(0, digits));
      at += digits + 1;
      if (i == 2) return Vec3<int64_t>{numbers[0], numbers[1], numbers[2]};
    }
  }
  return std::nullopt;
}

/// The type in a name whose parts are separated by _, . or -: the first part that is a type with
/// its number of bits, "float" or "double".
std::optional<VoxelType> type_in(std::string_view name) {
  for (;;) {
    const size_t end = std::min(name.find_first_of("_.-"), name.size());
    const std::string_view part = name.substr(0, end);
    const auto type = voxel_type_of(part);
    const bool has_bits = part.find_first_of(kDigits) != part.npos;
    if (type && (has_bits || part == "float" || part == "double")) return type;
    if (end == name.size()) return std::nullopt;
    name.remove_prefix(end + 1);
  }
}

/// Parses dims and type from a file name, as in many archives: foot_256x256x256_uint8.raw.
std::optional<RawLayout> layout_in_name(const std::filesystem::path& path) {
  const std::string name = lower_case(path.filename().string());
  const auto dims = dims_in(name);
  const auto type = type_in(name);
  if (!dims || !type) return std::nullopt;
  return RawLayout{*dims, *type};
}

}  // namespace

bool raw_name_is_complete(const std::filesystem::path& path) {
  return layout_in_name(path).has_value();
}

Result<OpenVolume> open_raw(const FileHead& head, const ImportOptions& options) {
  const std::filesystem::path& path = head.path;
  std::vector<std::string> notes;
  const auto named = layout_in_name(path);
  if ((!options.dims && !named) || (!options.type && !named)) {
    return fail(Status::invalid_argument,
                fmt::format("{}: a raw file has no header: give --dims and --type, for example "
                            "--dims 256x256x128 --type u8",
                            path.string()));
  }
  if (options.time_step.value_or(0) != 0) {
    return fail(
        Status::invalid_argument,
        fmt::format("{}: raw files have no time steps: use --skip-bytes instead", path.string()));
  }
  const auto shape = options.dims ? *options.dims : named->dims;
  const VoxelType type = options.type ? *options.type : named->type;
  if (!options.dims || !options.type) {
    notes.push_back(fmt::format("dims {}x{}x{} and type {} are taken from the file's name", shape.x,
                                shape.y, shape.z, voxel_type_name(type)));
  }
  ArrayVolume array = make_array("raw", path, shape, HeaderGeometry{}, options);
  array.stored.type = type;
  array.stored.big_endian = options.big_endian.value_or(false);
  if (!options.big_endian && voxel_bytes(type) > 1) {
    notes.push_back("little-endian voxels are assumed; --endian big sets the other byte order");
  }
  if (!options.spacing) {
    notes.push_back("a raw file has no voxel spacing: 1,1,1 is assumed; --spacing sets another");
  }
  array.offset = options.skip_bytes;
  array.plain = !head.is_gzip();
  auto bytes = array.plain ? open_plain(path) : open_deflated(path);
  if (!bytes) return tl::unexpected(bytes.error());

  // The file size is the only check of dims and type, so it must match exactly.
  const uint64_t found = (*bytes)->size_limit();
  if (array.plain && shape.x > 0 && shape.y > 0 && shape.z > 0 && shape.x <= kMaxVoxelsPerAxis &&
      shape.y <= kMaxVoxelsPerAxis && shape.z <= kMaxVoxelsPerAxis) {
    const uint64_t expected = volume_bytes(shape, voxel_bytes(type));
    const bool fits = array.offset <= found && found - array.offset == expected;
    const Allowance needed =
        found < array.offset + expected ? Allowance::truncated : Allowance::surplus;
    if (!fits && !options.allowed.has(needed)) {
      std::string hint;
      for (const size_t bytes_per_voxel : {1, 2, 4, 8}) {
        if (array.offset <= found && volume_bytes(shape, bytes_per_voxel) == found - array.offset) {
          hint = fmt::format(" (voxels of {} bytes would fit)", bytes_per_voxel);
        }
      }
      return fail(found < expected ? Status::truncated : Status::malformed_volume,
                  fmt::format("{}: expected {} bytes for {} × {} × {} voxels of type {} after {} "
                              "skipped, found a file of {} bytes{}: correct --dims, --type or "
                              "--skip-bytes",
                              path.string(), expected, shape.x, shape.y, shape.z,
                              voxel_type_name(type), array.offset, found, hint));
    }
  }
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat::import
