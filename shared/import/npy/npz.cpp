#include "shared/import/npy/npz.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/codecs/zip_directory.h"
#include "shared/import/npy/npy.h"
#include "shared/import/text/header_text.h"
#include "shared/import/text/name_list.h"
#include "shared/import/volume/volume_choices.h"

// Reads archives of NumPy arrays, which numpy.savez and savez_compressed write: a ZIP whose files
// are arrays.
namespace isosplat::import {
namespace {

constexpr std::string_view kSuffix = ".npy";

/// An array with at least three axes of several samples.
struct Array {
  std::string name;  ///< without .npy
  ZipMember member;
};

bool is_volume(const std::vector<int64_t>& shape) {
  return std::count_if(shape.begin(), shape.end(), [](int64_t size) { return size > 1; }) >= 3;
}

/// The volumes of an archive. Arrays whose headers are damaged count, so that reading them is an
/// error.
Result<std::vector<Array>> volumes_of(const std::filesystem::path& path) {
  const auto members = read_zip_directory(path);
  if (!members) return tl::unexpected(members.error());
  std::vector<Array> volumes;
  for (const ZipMember& member : *members) {
    if (!member.name.ends_with(kSuffix)) continue;
    auto bytes = open_zip_member(path, member);
    if (!bytes) return tl::unexpected(bytes.error());
    const auto shape = npy_shape(path, **bytes);
    if (shape && !is_volume(*shape)) continue;
    volumes.push_back({member.name.substr(0, member.name.size() - kSuffix.size()), member});
  }
  return volumes;
}

}  // namespace

bool is_npz(std::string_view head) {
  if (head.size() < 30 || !head.starts_with("PK\3\4")) return false;
  const size_t size = static_cast<uint8_t>(head[26]) + size_t{static_cast<uint8_t>(head[27])} * 256;
  const std::string_view name = head.substr(30, size);
  return name.ends_with(kSuffix) && name.find('/') == name.npos;
}

Result<std::vector<std::string>> npz_datasets(const std::filesystem::path& path) {
  auto volumes = volumes_of(path);
  if (!volumes) return tl::unexpected(volumes.error());
  std::vector<std::string> names;
  for (Array& each : *volumes) names.push_back(std::move(each.name));
  return names;
}

Result<OpenVolume> open_npz(const std::filesystem::path& path, const ImportOptions& options) {
  const auto volumes = volumes_of(path);
  if (!volumes) return tl::unexpected(volumes.error());
  std::vector<std::string> names;
  for (const Array& each : *volumes) names.push_back(each.name);
  if (volumes->empty()) {
    return fail(Status::no_cells,
                fmt::format("{}: expected an array with three axes of several samples, found none "
                            "in the archive: save the whole volume as one array",
                            path.string()));
  }
  std::string wanted = options.dataset;
  if (wanted.ends_with(kSuffix)) wanted.resize(wanted.size() - kSuffix.size());
  const auto found = wanted.empty() && volumes->size() == 1
                         ? volumes->begin()
                         : std::find_if(volumes->begin(), volumes->end(),
                                        [&](const Array& each) { return each.name == wanted; });
  if (found == volumes->end()) {
    if (wanted.empty()) {
      std::vector<VolumeChoice> offered;
      for (const std::string& name : names) {
        offered.push_back({.label = name, .name = name, .dataset = name});
      }
      offer(options, std::move(offered));
    }
    return fail(
        Status::invalid_argument,
        fmt::format("{}: expected {}, found {}: {}: choose one with --dataset", path.string(),
                    wanted.empty() ? "one volume" : fmt::format("the array {}", wanted),
                    names.size(), name_list(names, 20)));
  }
  auto bytes = open_zip_member(path, found->member);
  if (!bytes) return tl::unexpected(bytes.error());
  return open_npy_array(path, std::move(*bytes), found->member.method == 0, options);
}

}  // namespace isosplat::import
