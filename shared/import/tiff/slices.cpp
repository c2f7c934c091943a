#include "shared/import/tiff/slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "shared/import/bytes/input_files.h"

namespace isosplat::import {
namespace {

/// Compares the number of pages with the description's. Adds a note if a difference is allowed.
Result<void> check_page_count(const std::filesystem::path& path, uint64_t found, uint64_t expected,
                              Allowances allowed, std::vector<std::string>& notes) {
  if (found == expected) return {};
  const bool fewer = found < expected;
  const Allowance needed = fewer ? Allowance::truncated : Allowance::surplus;
  const auto text = fmt::format("{}: expected {} pages according to its description, found {}",
                                path.string(), expected, found);
  if (!allowed.has(needed)) {
    return fail(
        fewer ? Status::truncated : Status::malformed_volume,
        fmt::format(
            "{}: the file is incomplete, or its description is wrong; read it anyway with {}", text,
            flag_of(needed)));
  }
  notes.push_back(text + (fewer ? ": the voxels of the missing pages have no value"
                                : ": the surplus is ignored"));
  return {};
}

/// The index of a slice of the volume on each axis.
std::array<uint64_t, 3> indices_of(const TiffVolume& volume, uint64_t slice) {
  auto index = volume.fixed;
  index[static_cast<size_t>(volume.slices)] = slice;
  return index;
}

/// The sample of a slice.
int sample_of(const TiffVolume& volume, uint64_t slice) {
  const auto axis = volume.series.in_samples;
  return axis ? static_cast<int>(indices_of(volume, slice)[static_cast<size_t>(*axis)]) : 0;
}

/// The pages of an OME-TIFF, which may be in several files.
class OmeSlices {
 public:
  OmeSlices(const std::filesystem::path& path, const TiffPages& pages, const TiffVolume& volume,
            Allowances allowed)
      : path_(path), volume_(volume), allowed_(allowed) {
    chains_[""] = pages.chain;
  }

  Result<std::vector<TiffSlice>> find(std::vector<std::string>& notes) {
    const TiffSeries& series = volume_.series;
    if (auto fine = assign(); !fine) return tl::unexpected(fine.error());
    if (is_renamed()) {
      notes.push_back(fmt::format("the file's description calls it {}: it was renamed",
                                  series.ome.front().file));
      for (Place& place : places_) place.file.clear();
    }
    if (auto fine = open_files(); !fine) return tl::unexpected(fine.error());
    std::vector<TiffSlice> slices(places_.size());
    uint64_t missing = 0;
    for (size_t i = 0; i < places_.size(); ++i) {
      const Place& place = places_[i];
      const auto chain = chains_.find(place.file);
      if (!place.is_known || chain == chains_.end() || place.page >= chain->second.size()) {
        ++missing;
        continue;
      }
      slices[i].path = place.file.empty() ? path_ : path_.parent_path() / place.file;
      slices[i].page = chain->second[static_cast<size_t>(place.page)];
      slices[i].part.sample = sample_of(volume_, i);
    }
    if (missing == 0) return slices;
    const bool may_lack = allowed_.has(Allowance::truncated) || allowed_.has(Allowance::gaps);
    if (!may_lack || missing == slices.size()) {
      return fail(
          Status::truncated,
          fmt::format("{}: expected a page for each of {} slices, found none for {}: the "
                      "files are incomplete; copy or download them again, or read the "
                      "others with {}",
                      path_.string(), slices.size(), missing, flag_of(Allowance::truncated)));
    }
    notes.push_back(fmt::format("{} slices are missing: their voxels have no value", missing));
    return slices;
  }

 private:
  struct Place {
    std::string file;  ///< empty: the file that was opened
    uint64_t page = 0;
    bool is_known = false;
  };

  bool is_own(const OmePages& block) const {
    const std::string& own = volume_.series.ome_uuid;
    if (block.file.empty() || block.file == path_.filename().string()) return true;
    return !own.empty() && block.uuid == own;
  }

  /// Finds the page of each slice.
  Result<void> assign() {
    const TiffSeries& series = volume_.series;
    const auto contradiction = [&](const std::string& what) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected a page for each plane in its OME description, found "
                              "{}: save it again as OME-TIFF",
                              path_.string(), what));
    };
    places_.resize(static_cast<size_t>(volume_.size()));
    uint64_t work = 0;
    for (const OmePages& block : series.ome) {
      const std::string file = is_own(block) ? "" : block.file;
      for (size_t axis = 0; axis < 3; ++axis) {
        if (block.first[axis] >= series.sizes[axis])
          return contradiction("one outside of the volume");
      }
      const uint64_t start = plane_number(series, block.first[0], block.first[1], block.first[2]);
      const uint64_t count = std::min(block.count, series.pages - std::min(series.pages, start));
      work += count;
      if (work > uint64_t{1} << 26) return contradiction("too many");
      for (uint64_t i = 0; i < count; ++i) {
        const auto index = indices_at(start + i);
        bool is_chosen = true;
        for (size_t axis = 0; axis < 3; ++axis) {
          const bool is_free =
              axis == static_cast<size_t>(volume_.slices) ||
              (series.in_samples && axis == static_cast<size_t>(*series.in_samples));
          is_chosen = is_chosen && (is_free || index[axis] == volume_.fixed[axis]);
        }
        if (!is_chosen) continue;
        const bool are_samples = volume_.slices == series.in_samples;
        const uint64_t first = are_samples ? 0 : index[static_cast<size_t>(volume_.slices)];
        for (uint64_t slice = first; slice < (are_samples ? volume_.size() : first + 1); ++slice) {
          Place& place = places_[static_cast<size_t>(slice)];
          const Place found{file, block.page + i, true};
          if (place.is_known && (place.file != found.file || place.page != found.page)) {
            return contradiction("two");
          }
          place = found;
        }
      }
    }
    return {};
  }

  /// The indices z, channel and time of a plane by its number.
  std::array<uint64_t, 3> indices_at(uint64_t number) const {
    const TiffSeries& series = volume_.series;
    std::array<uint64_t, 3> index{};
    for (const TiffAxis axis : series.order) {
      if (axis == series.in_samples) continue;
      index[static_cast<size_t>(axis)] = number % series.size(axis);
      number /= series.size(axis);
    }
    return index;
  }

  /// Whether all planes are in one file of another name that does not exist.
  bool is_renamed() const {
    const std::vector<OmePages>& blocks = volume_.series.ome;
    const std::string& name = blocks.front().file;
    const bool is_one = std::all_of(blocks.begin(), blocks.end(),
                                    [&](const OmePages& block) { return block.file == name; });
    return is_one && !is_own(blocks.front()) && !exists(name);
  }

  bool exists(const std::string& name) const {
    return input_kind(path_.parent_path() / name) == InputKind::file;
  }

  /// Reads the lists of pages of the other files.
  Result<void> open_files() {
    std::set<std::string> missing;
    std::set<std::string> names;
    for (const Place& place : places_) names.insert(place.file);
    for (const std::string& name : names) {
      if (name.empty()) continue;
      if (!exists(name)) {
        missing.insert(name);
        continue;
      }
      auto pages = find_tiff_pages(path_.parent_path() / name);
      if (!pages) return tl::unexpected(pages.error());
      chains_[name] = std::move(pages->chain);
    }
    if (missing.empty() || allowed_.has(Allowance::gaps)) return {};
    return fail(Status::malformed_volume,
                fmt::format("{}: expected the other files of its volume beside it, found {} of {} "
                            "missing, such as {}: put them into the same folder, and give the "
                            "folder, or read the others with {}",
                            path_.string(), missing.size(), names.size(), *missing.begin(),
                            flag_of(Allowance::gaps)));
  }

  const std::filesystem::path& path_;
  const TiffVolume& volume_;
  Allowances allowed_;
  std::vector<Place> places_;
  std::map<std::string, std::vector<uint64_t>> chains_;  ///< directories of each file
};

bool is_in_one_file(const std::vector<TiffSeries>& series) {
  for (const TiffSeries& each : series) {
    for (const OmePages& block : each.ome) {
      if (!block.file.empty() && block.file != each.ome.front().file) return false;
    }
    if (each.ome.front().file != series.front().ome.front().file) return false;
  }
  return true;
}

}  // namespace

Result<std::vector<TiffSlice>> tiff_slices(const std::filesystem::path& path,
                                           const TiffPages& pages,
                                           const std::vector<TiffSeries>& series,
                                           const TiffVolume& volume, Allowances allowed,
                                           std::vector<std::string>& notes) {
  const TiffSeries& chosen = volume.series;
  uint64_t expected = 0;
  for (const TiffSeries& each : series) expected += each.follow ? 1 : each.pages;
  const bool is_ome = !chosen.ome.empty();
  if (chosen.counted && (!is_ome || is_in_one_file(series))) {
    const uint64_t found = is_ome ? pages.chain.size() : pages.offsets.size();
    if (auto fine = check_page_count(path, found, expected, allowed, notes); !fine) {
      return tl::unexpected(fine.error());
    }
  }
  if (is_ome) return OmeSlices(path, pages, volume, allowed).find(notes);

  const auto file = open_tiff(path, chosen.follow || chosen.depth_is_z);
  std::vector<TiffSlice> slices(static_cast<size_t>(volume.size()));
  size_t missing = 0;
  for (size_t i = 0; i < slices.size(); ++i) {
    const auto [z, channel, time] = indices_of(volume, i);
    const uint64_t number = plane_number(chosen, z, channel, time);
    const uint64_t page = chosen.first_page + (chosen.follow ? 0 : number);
    if (page >= pages.offsets.size()) continue;
    const uint64_t directory = pages.offsets[static_cast<size_t>(page)];
    TiffSlice slice{path, directory, {}};
    slice.part.plane = chosen.follow ? number : chosen.depth_is_z ? z : 0;
    slice.part.sample = sample_of(volume, i);
    const bool is_checked = chosen.follow || allowed.has(Allowance::truncated);
    if (is_checked && (!file || !file->go_to(directory) || !file->is_whole(slice.part.plane))) {
      ++missing;
      continue;
    }
    slices[i] = std::move(slice);
  }
  if (missing > 0 && !allowed.has(Allowance::truncated)) {
    return fail(Status::truncated,
                fmt::format("{}: expected {} planes of uncompressed voxels after its first page, "
                            "found {}: the file is incomplete, or its description is wrong; read "
                            "it anyway with {}",
                            path.string(), slices.size(), slices.size() - missing,
                            flag_of(Allowance::truncated)));
  }
  if (missing > 0) {
    notes.push_back(fmt::format("{} pages are incomplete: their voxels have no value", missing));
  }
  return slices;
}

}  // namespace isosplat::import
