#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/array_source.h"
#include "shared/import/conventions.h"
#include "shared/import/formats.h"
#include "shared/import/header_text.h"
#include "shared/import/slice_files.h"
#include "shared/import/slice_order.h"
#include "shared/import/tiff_pages.h"
#include "shared/import/tiff_source.h"

// Reads TIFF stacks: a file with a page per slice, or a folder with a file per slice. This file
// decides which pages are slices; tiff_file.h decodes them.
namespace isosplat {
namespace {

/// A pixel's size in the unit of the page's resolution (ImageJ uses this unit too).
double pixel_size(std::optional<double> pixels_per_unit) {
  return pixels_per_unit.value_or(0) > 0 ? 1 / *pixels_per_unit : 1;
}

HeaderGeometry geometry_of(const TiffPage& first, const TiffDescription& description,
                           const ImportOptions& options, std::vector<std::string>& notes) {
  HeaderGeometry geometry;
  if (options.spacing) {
    geometry.spacing = *options.spacing;
  } else if (description.voxel || description.between_slices) {
    geometry.spacing =
        description.voxel ? *description.voxel
                          : Vec3d{pixel_size(first.pixels_per_unit_x),
                                  pixel_size(first.pixels_per_unit_y), *description.between_slices};
    spacing_to_millimetres(description.units, geometry, notes);
  } else {
    notes.push_back(
        "the TIFF file has no distance between slices: spacing 1,1,1 is assumed; --spacing sets "
        "another");
  }
  return geometry;
}

Result<void> check_page(const std::filesystem::path& path, const TiffPage& page,
                        std::vector<std::string>& notes) {
  if (page.palette) {
    return fail(
        Status::unsupported_type,
        fmt::format(
            "{}: expected grey values, found a colour palette: convert the stack to greyscale",
            path.string()));
  }
  if (page.samples != 1) return not_scalar(path, page.samples);
  if (!page.unknown.empty()) return unknown_type(path, page.unknown);
  if (page.orientation < 1 || page.orientation > 4) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected rows along x (TIFF orientation 1 to 4), found {}: rotate "
                            "the stack",
                            path.string(), page.orientation));
  }
  if (auto fine = check_decodable(path, page); !fine) return fine;
  if (page.white_is_zero) {
    notes.push_back(is_unsigned(page.type) ? "the file stores 0 as white: its values are inverted"
                                           : "the file stores 0 as white, which has no meaning for "
                                             "signed voxels: its values are not inverted");
  }
  return {};
}

Result<OpenVolume> make_stack(const std::filesystem::path& path, const TiffPage& page,
                              const HeaderGeometry& geometry, const TiffDescription& description,
                              std::vector<TiffSlice> slices, std::vector<std::string> notes) {
  auto orientation =
      orient({page.width, page.height, static_cast<int64_t>(slices.size())}, geometry);
  if (!orientation) {
    return fail(orientation.error().status, path.string() + ": " + orientation.error().message);
  }
  for (std::string& note : orientation->notes) notes.push_back(std::move(note));
  notes.insert(notes.end(), description.notes.begin(), description.notes.end());
  VolumeHeader header{orientation->grid, page.type,         "TIFF",
                      volume_name(path), description.slope, description.intercept};
  return OpenVolume{make_tiff_source(std::move(header), page, std::move(slices)), std::move(notes)};
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
  file.tiff = open_tiff(path);
  auto first = file.tiff ? file.tiff->go_to(pages->offsets[0]) : std::nullopt;
  if (!first) return damaged_tiff(path.string());
  file.first = std::move(*first);
  file.pages = std::move(*pages);
  return file;
}

/// ImageJ writes stacks of more than 4 GB as one page, followed by the other pages' voxels without
/// directories.
Result<OpenVolume> open_bare_stack(const std::filesystem::path& path, const OpenFile& file,
                                   const TiffDescription& description, uint64_t step,
                                   const HeaderGeometry& geometry, const ImportOptions& options,
                                   std::vector<std::string> notes) {
  const TiffPage& page = file.first;
  if (!page.uncompressed_at || page.white_is_zero || page.orientation != 1) {
    return fail(Status::truncated,
                fmt::format("{}: expected {} pages, found one: the file is incomplete, or its "
                            "description is wrong",
                            path.string(), *description.images));
  }
  ArrayVolume array =
      make_array("TIFF", path, {page.width, page.height, static_cast<int64_t>(description.slices)},
                 geometry, options);
  array.stored.type = page.type;
  array.stored.big_endian = file.pages.big_endian;
  array.stored.slope = description.slope;
  array.stored.intercept = description.intercept;
  notes.insert(notes.end(), description.notes.begin(), description.notes.end());
  array.offset = *page.uncompressed_at;
  array.steps = description.frames;
  array.step = step;
  array.step_axis = description.frames_before_slices ? 2 : 3;
  array.ends_with_file = false;
  auto bytes = open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

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

/// The pages of the slices of one time step. Incomplete pages, if allowed, are missing slices.
std::vector<TiffSlice> slices_of_step(const std::filesystem::path& path, const OpenFile& file,
                                      const TiffDescription& description, uint64_t step,
                                      Allowances allowed, std::vector<std::string>& notes) {
  std::vector<TiffSlice> slices(static_cast<size_t>(description.slices));
  size_t missing = 0;
  for (size_t z = 0; z < slices.size(); ++z) {
    const uint64_t page = description.frames_before_slices ? z * description.frames + step
                                                           : step * description.slices + z;
    if (page >= file.pages.offsets.size()) continue;
    const uint64_t directory = file.pages.offsets[static_cast<size_t>(page)];
    if (allowed.has(Allowance::truncated) &&
        (!file.tiff->go_to(directory) || !file.tiff->is_whole())) {
      ++missing;
      continue;
    }
    slices[z] = {path, directory};
  }
  if (missing > 0) {
    notes.push_back(fmt::format("{} pages are incomplete: their voxels have no value", missing));
  }
  return slices;
}

std::optional<FillValue> fill_of(std::optional<double> no_data) {
  if (!no_data) return std::nullopt;
  return FillValue{*no_data, *no_data};
}

}  // namespace

Result<OpenVolume> open_tiff_file(const std::filesystem::path& path, const ImportOptions& options) {
  std::vector<std::string> notes;
  auto file = open_pages(path, options.allowed, notes);
  if (!file) return tl::unexpected(file.error());
  // Values of the first page's directory, including sizes, may be stored after its voxels.
  if (!file->tiff->is_whole()) return damaged_tiff(path.string());
  const TiffPage& page = file->first;
  if (auto fine = check_page(path, page, notes); !fine) return tl::unexpected(fine.error());
  auto parsed = parse_tiff_description(path, page.description);
  if (!parsed) return tl::unexpected(parsed.error());
  TiffDescription& description = *parsed;
  if (description.width.value_or(page.width) != page.width ||
      description.height.value_or(page.height) != page.height) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected pages of {} × {} voxels according to its description, "
                            "found {} × {}: save it again",
                            path.string(), description.width.value_or(page.width),
                            description.height.value_or(page.height), page.width, page.height));
  }
  const uint64_t found = file->pages.offsets.size();
  if (!description.images) {
    description.slices = found;
    description.channels = description.frames = 1;
    description.images = found;
  }
  if (description.channels > 1) {
    return not_scalar(path, static_cast<int>(std::min<uint64_t>(description.channels, 1000)));
  }
  const auto step = choose_step(path, static_cast<int64_t>(description.frames), options);
  if (!step) return tl::unexpected(step.error());
  if (description.slices < 2 && description.frames > 1) {
    return fail(Status::no_cells,
                fmt::format("{}: expected slices, found one slice at {} times: if the times are "
                            "slices, change this in ImageJ (Image > Properties)",
                            path.string(), description.frames));
  }
  const HeaderGeometry geometry = geometry_of(page, description, options, notes);
  if (found == 1 && *description.images > 1 && description.is_imagej && !file->pages.ends_early) {
    return open_bare_stack(path, *file, description, *step, geometry, options, std::move(notes));
  }
  if (auto fine = check_page_count(path, found, *description.images, options.allowed, notes);
      !fine) {
    return tl::unexpected(fine.error());
  }
  auto slices = slices_of_step(path, *file, description, *step, options.allowed, notes);
  auto volume = make_stack(path, page, geometry, description, std::move(slices), std::move(notes));
  if (volume) volume->fill_value = fill_of(file->pages.no_data);
  return volume;
}

Result<OpenVolume> open_tiff_folder(const std::filesystem::path& path,
                                    const ImportOptions& options) {
  auto files = files_of_folder(path, {".tif", ".tiff"});
  if (files.empty()) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected TIFF slices, found none", path.string()));
  }
  if (files.size() == 1) return open_tiff_file(files[0], options);
  if (options.time_step.value_or(0) != 0) {
    return fail(Status::invalid_argument,
                fmt::format("{}: a folder of TIFF slices has no time steps: remove --time-step",
                            path.string()));
  }
  auto order = order_slices(path, std::move(files), options.allowed);
  if (!order) return tl::unexpected(order.error());
  std::vector<std::string> notes = std::move(order->notes);
  std::vector<TiffSlice> slices;
  std::optional<double> no_data;
  const std::filesystem::path* first = nullptr;
  for (const std::filesystem::path& file : order->slices) {
    slices.push_back({file, 0});
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
    if (!first) first = &file, no_data = pages->no_data;
  }
  const auto tiff = open_tiff(*first);
  const auto found = tiff ? tiff->go_to(slices[0].page) : std::nullopt;
  if (!found) return damaged_tiff(first->string());
  const TiffPage& page = *found;
  if (auto fine = check_page(*first, page, notes); !fine) return tl::unexpected(fine.error());
  auto description = parse_tiff_description(*first, page.description);
  if (!description) return tl::unexpected(description.error());
  const HeaderGeometry geometry = geometry_of(page, *description, options, notes);
  auto volume = make_stack(path, page, geometry, *description, std::move(slices), std::move(notes));
  if (volume) volume->fill_value = fill_of(no_data);
  return volume;
}

}  // namespace isosplat
