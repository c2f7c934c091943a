#include "shared/import/tiff/tiff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/bytes/input_files.h"
#include "shared/import/slices/slice_files.h"
#include "shared/import/slices/slice_order.h"
#include "shared/import/tiff/geometry.h"
#include "shared/import/tiff/slices.h"
#include "shared/import/tiff/source.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/volume/volume_name.h"

// Opens TIFF stacks: a file with a page per slice, or a folder with a file per slice. series.h
// determines which pages are slices; file.h decodes them.
namespace isosplat::import {
namespace {

Result<void> check_page(const std::filesystem::path& path, const TiffPage& page,
                        std::vector<std::string>& notes) {
  if (page.palette() && !is_imagej(page.description)) {
    return fail(
        Status::unsupported_type,
        fmt::format(
            "{}: expected grey values, found a colour palette: convert the stack to greyscale",
            path.string()));
  }
  if (page.palette()) {
    notes.push_back("the file has a colour table: the values are those that it gives colours to");
  }
  if (!page.unknown.empty()) return unknown_type(path, page.unknown);
  if (page.orientation < 1 || page.orientation > 4) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected rows along x (TIFF orientation 1 to 4), found {}: rotate "
                            "the stack",
                            path.string(), page.orientation));
  }
  if (auto fine = check_decodable(path, page); !fine) return fine;
  if (page.white_is_zero() && is_shaped(page.description)) {
    notes.push_back("the file stores 0 as white: its values are those of tifffile's array");
  } else if (page.white_is_zero()) {
    notes.push_back(is_unsigned(page.type) ? "the file stores 0 as white: its values are inverted"
                                           : "the file stores 0 as white, which has no meaning for "
                                             "signed voxels: its values are not inverted");
  }
  return {};
}

/// Refuses pixels of several samples that are neither channels nor red, green and blue.
Result<void> check_samples(const std::filesystem::path& path, const TiffPage& page) {
  if (page.samples < 2 || page.photometric <= 2) return {};
  return fail(Status::unsupported_type,
              fmt::format("{}: expected one number per voxel, found {} that are no colours of red, "
                          "green and blue (photometric interpretation {}): save one channel as a "
                          "separate volume",
                          path.string(), page.samples, page.photometric));
}

/// A volume of slices. `left_out`: strips and tiles that were not written.
Result<OpenVolume> make_stack(const std::filesystem::path& path, const TiffPage& page,
                              const TiffSeries& series, const ImportOptions& options,
                              std::vector<TiffSlice> slices, const TiffPages& pages,
                              std::vector<std::string> notes) {
  const HeaderGeometry geometry = tiff_geometry(page, series, options, notes);
  auto orientation =
      orient({page.width, page.height, static_cast<int64_t>(slices.size())}, geometry);
  if (!orientation) {
    return fail(orientation.error().status, path.string() + ": " + orientation.error().message);
  }
  for (std::string& note : orientation->notes) notes.push_back(std::move(note));
  notes.insert(notes.end(), series.notes.begin(), series.notes.end());
  if (pages.left_out_parts > 0) {
    notes.push_back(fmt::format(
        "{} parts of pages were not written (a sparse file): their voxels {}", pages.left_out_parts,
        pages.no_data ? "have the file's fill value" : "have the value 0"));
  }
  VolumeHeader header{orientation->grid, page.type,    "TIFF",
                      volume_name(path), series.slope, series.intercept};
  OpenVolume volume;
  volume.source = make_tiff_source(std::move(header), page, std::move(slices),
                                   !is_shaped(page.description), pages.no_data.value_or(0));
  volume.notes = std::move(notes);
  if (pages.no_data) {
    const double value = series.intercept + series.slope * *pages.no_data;
    volume.fill_value = FillValue{value, value};
  }
  return volume;
}

/// A file, the list of its pages, and the first of them.
struct OpenFile {
  TiffPages pages;
  std::unique_ptr<TiffFile> tiff;
  TiffPage first;
};

Result<OpenFile> open_pages(const std::filesystem::path& path, Allowances allowed,
                            std::vector<std::string>& notes) {
  auto pages = find_tiff_pages(path);
  if (!pages) return tl::unexpected(pages.error());
  if (pages->ends_early) {
    if (!allowed.has(Allowance::truncated)) {
      return fail(
          Status::truncated,
          fmt::format("{}: expected another page after {} pages, found the end of the file: it is "
                      "incomplete; copy or download it again, or read the incomplete stack with {}",
                      path.string(), pages->offsets.size(), flag_of(Allowance::truncated)));
    }
    notes.push_back(fmt::format("{} ends after {} pages, before its last page",
                                path.filename().string(), pages->offsets.size()));
  }
  if (pages->left_out > 0) {
    notes.push_back(fmt::format("{} pages are smaller copies or masks of others: they are ignored",
                                pages->left_out));
  }
  OpenFile file;
  file.tiff = open_tiff(path, pages->entries[0].kind.depth > 1);
  auto first = file.tiff ? file.tiff->go_to(pages->offsets[0]) : std::nullopt;
  if (!first) return damaged_tiff(path.string());
  file.first = std::move(*first);
  file.pages = std::move(*pages);
  return file;
}

}  // namespace

Result<OpenVolume> open_tiff_file(const std::filesystem::path& path, const ImportOptions& options) {
  std::vector<std::string> notes;
  auto file = open_pages(path, options.allowed, notes);
  if (!file) return tl::unexpected(file.error());
  // Values of the first page's directory, including sizes, may be stored after its voxels.
  if (!file->tiff->is_whole()) return damaged_tiff(path.string());
  if (auto fine = check_samples(path, file->first); !fine) return tl::unexpected(fine.error());
  const auto series = tiff_series(path, file->pages, file->first);
  if (!series) return tl::unexpected(series.error());
  const auto volume = choose_tiff_volume(path, *series, options, notes);
  if (!volume) return tl::unexpected(volume.error());
  const TiffSeries& chosen = volume->series;
  auto slices = tiff_slices(path, file->pages, *series, *volume, options.allowed, notes);
  if (!slices) return tl::unexpected(slices.error());

  // The slices have the size and type of the first existing one.
  const auto there = std::find_if(slices->begin(), slices->end(),
                                  [](const TiffSlice& slice) { return !slice.path.empty(); });
  TiffPage page = file->first;
  if (there != slices->end() && (there->path != path || there->page != file->pages.offsets[0])) {
    const auto other = open_tiff(there->path, chosen.follow || chosen.depth_is_z);
    auto found = other ? other->go_to(there->page) : std::nullopt;
    if (!found) return damaged_tiff(there->path.string());
    found->description = page.description;
    page = std::move(*found);
  }
  if (auto fine = check_page(path, page, notes); !fine) return tl::unexpected(fine.error());
  if (chosen.width.value_or(page.width) != page.width ||
      chosen.height.value_or(page.height) != page.height) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected pages of {} × {} voxels according to its description, "
                            "found {} × {}: save it again",
                            path.string(), chosen.width.value_or(page.width),
                            chosen.height.value_or(page.height), page.width, page.height));
  }
  if (page.depth > 1 && !chosen.depth_is_z) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected pages with one slice each, found {} in a page beside a "
                            "description of another order: write it again with one slice per page",
                            path.string(), page.depth));
  }
  return make_stack(path, page, chosen, options, std::move(*slices), file->pages, std::move(notes));
}

Result<std::vector<VolumeChoice>> tiff_volumes(const std::filesystem::path& given) {
  std::filesystem::path path = given;
  if (input_kind(given) == InputKind::folder) {
    const auto files = files_of_folder(given, {".tif", ".tiff"});
    if (files.empty()) return std::vector<VolumeChoice>{};
    path = files[0];
  }
  std::vector<std::string> notes;
  Allowances all;
  all.add(Allowance::truncated);
  const auto file = open_pages(path, all, notes);
  if (!file) return tl::unexpected(file.error());
  const auto series = tiff_series(path, file->pages, file->first);
  if (!series) return tl::unexpected(series.error());
  if (path != given && !is_ome(file->first.description)) return std::vector<VolumeChoice>{};
  return tiff_choices(*series);
}

Result<OpenVolume> open_tiff_folder(const std::filesystem::path& path,
                                    const ImportOptions& options) {
  auto files = files_of_folder(path, {".tif", ".tiff"});
  if (files.empty()) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected TIFF slices, found none", path.string()));
  }
  if (files.size() == 1) return open_tiff_file(files[0], options);
  std::vector<std::string> notes;
  // The description of an OME-TIFF states which file has which slice.
  if (auto file = open_pages(files[0], options.allowed, notes);
      file && is_ome(file->first.description)) {
    const auto series = tiff_series(files[0], file->pages, file->first);
    if (!series) return tl::unexpected(series.error());
    const bool is_one_page = std::all_of(series->begin(), series->end(),
                                         [](const auto& each) { return each.pages == 1; });
    if (!is_one_page) {
      auto volume = open_tiff_file(files[0], options);
      if (!volume) return volume;
      const auto used = volume->source->files();
      const auto others = std::count_if(files.begin(), files.end(), [&](const auto& each) {
        return std::find(used.begin(), used.end(), each) == used.end();
      });
      if (others > 0) {
        volume->notes.push_back(fmt::format(
            "{} TIFF files of the folder do not belong to the volume that {} describes: they are "
            "not read",
            others, files[0].filename().string()));
      }
      return volume;
    }
  }
  notes.clear();
  if (options.time_step.value_or(0) != 0) {
    return fail(Status::invalid_argument,
                fmt::format("{}: a folder of TIFF slices has no time steps: remove --time-step",
                            path.string()));
  }
  auto order = order_slices(path, std::move(files), options.allowed);
  if (!order) return tl::unexpected(order.error());
  notes = std::move(order->notes);
  std::vector<TiffSlice> slices;
  TiffPages first_pages;
  const std::filesystem::path* first = nullptr;
  for (const std::filesystem::path& file : order->slices) {
    slices.push_back({file, 0, {}});
    if (file.empty()) continue;
    auto pages = find_tiff_pages(file);
    if (!pages) return tl::unexpected(pages.error());
    if (pages->offsets.size() > 1 || pages->ends_early) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected one page in each file of a folder, found {}: give the "
                              "file itself, or keep only files of one page in the folder",
                              file.string(), pages->offsets.size()));
    }
    slices.back().page = pages->offsets[0];
    if (!first) {
      first = &file;
      first_pages = std::move(*pages);
    } else {
      first_pages.left_out_parts += pages->left_out_parts;
    }
  }
  const auto tiff = open_tiff(*first, false);
  const auto found = tiff ? tiff->go_to(first_pages.offsets[0]) : std::nullopt;
  if (!found) return damaged_tiff(first->string());
  const TiffPage& page = *found;
  if (auto fine = check_samples(*first, page); !fine) return tl::unexpected(fine.error());
  auto series = tiff_series(*first, first_pages, page);
  if (!series) return tl::unexpected(series.error());
  TiffSeries& one = series->front();
  if (one.pages > 1 || page.depth > 1) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected one slice in each file of a folder, found {}: give the "
                            "file itself",
                            first->string(), std::max<uint64_t>(one.pages, page.depth)));
  }
  const auto channel = choose_channel(path, page.samples, options);
  if (!channel) return tl::unexpected(channel.error());
  for (TiffSlice& slice : slices) slice.part.sample = static_cast<int>(*channel);
  if (auto fine = check_page(*first, page, notes); !fine) return tl::unexpected(fine.error());
  return make_stack(path, page, one, options, std::move(slices), first_pages, std::move(notes));
}

}  // namespace isosplat::import
