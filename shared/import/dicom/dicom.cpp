#include "shared/import/dicom/dicom.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/dicom/check_images.h"
#include "shared/import/dicom/collect.h"
#include "shared/import/dicom/order.h"
#include "shared/import/dicom/segment_maps.h"
#include "shared/import/dicom/segments.h"
#include "shared/import/dicom/source.h"
#include "shared/import/dicom/stacks.h"
#include "shared/import/dicom/values.h"
#include "shared/import/volume/volume_name.h"
#include "shared/import/voxels/array_source.h"

// Reads DICOM: a folder with a file per slice, or files with several frames. frames.h makes
// frames from the files' elements, stacks.h groups frames into stacks, order.h orders
// them by position. values.h chooses the voxels' type. source.h reads the pixels when
// slices are requested.
namespace isosplat::import {
namespace {

using namespace dicom;

/// The padding values of the chosen frames' files, if all files have the same.
std::optional<FillValue> padding_of(const Collection& collection,
                                    const std::vector<uint32_t>& frames, const Values& values,
                                    std::vector<std::string>& notes) {
  const Frame& first = collection.frames[frames[0]];
  const Image& image = collection.images[first.image];
  bool is_same = values.has_one_rescaling, is_any = false;
  for (const uint32_t index : frames) {
    const Image& other = collection.images[collection.frames[index].image];
    is_any = is_any || other.padding;
    is_same =
        is_same && other.padding == image.padding && other.padding_limit == image.padding_limit;
  }
  if (!is_any) return std::nullopt;
  if (!is_same) {
    notes.push_back(
        "the slices have different padding values (Pixel Padding Value): voxels with these values "
        "are kept");
    return std::nullopt;
  }
  const double a = first.intercept + first.slope * *image.padding;
  const double b = first.intercept + first.slope * image.padding_limit.value_or(*image.padding);
  return FillValue{std::min(a, b), std::max(a, b), false};
}

/// Makes a volume from frames.
Result<OpenVolume> open_frames(Collection collection, const std::filesystem::path& path,
                               const ImportOptions& options, std::vector<std::string> notes) {
  auto chosen = choose_stack(collection, path, options, notes);
  if (!chosen) return tl::unexpected(chosen.error());
  const auto stack = choose_segment(collection, std::move(*chosen), path, options, notes);
  if (!stack) return tl::unexpected(stack.error());
  if (auto r = check_images(collection, stack->frames, path, options, notes); !r) {
    return tl::unexpected(r.error());
  }
  auto arranged = arrange(collection, *stack, path, options, notes);
  if (!arranged) return tl::unexpected(arranged.error());

  std::vector<uint32_t> used;
  for (const Plane& plane : arranged->planes) {
    used.push_back(plane.first);
    if (plane.weight > 0) used.push_back(plane.second);
  }
  std::string frame = frame_of_reference(collection, used, notes);
  const Values values = find_values(collection, used, stack->label);
  if (!values.has_one_rescaling) {
    notes.push_back(
        fmt::format("the slices have different slopes or intercepts of their values (slopes from "
                    "{:.6g} to {:.6g}): each slice's values are computed with its own",
                    values.min_slope, values.greatest_slope));
  }
  const Frame& first = collection.frames[used[0]];
  if (first.is_inverse) {
    notes.push_back(
        "the pixels are MONOCHROME1 (low values are displayed bright): the values are not "
        "inverted");
  }
  HeaderGeometry geometry = arranged->geometry;
  if (options.spacing) geometry.spacing = *options.spacing;
  const Image& image = collection.images[first.image];
  auto orientation =
      orient({image.columns, image.rows, static_cast<int64_t>(arranged->planes.size())}, geometry);
  if (!orientation) {
    return fail(orientation.error().status, path.string() + ": " + orientation.error().message);
  }
  notes.insert(notes.end(), orientation->notes.begin(), orientation->notes.end());

  OpenVolume volume;
  volume.fill_value = padding_of(collection, used, values, notes);
  volume.notes = std::move(notes);
  VolumeHeader header{orientation->grid, values.type,      "DICOM",         volume_name(path),
                      values.slope,      values.intercept, std::move(frame)};
  volume.source = make_dicom_source(std::move(header), collection, arranged->planes, values,
                                    orientation->reverse_rows, options);
  return volume;
}

}  // namespace

bool is_dicom(std::string_view beginning) {
  return looks_like_dicom(beginning.substr(0, kDicomBeginning));
}

bool is_dicom_file(const std::filesystem::path& path) {
  const auto beginning = read_beginning(path, kDicomBeginning);
  return beginning && looks_like_dicom(*beginning);
}

Result<OpenVolume> open_dicom_file(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  auto collection = collect_file(path);
  if (!collection) return tl::unexpected(collection.error());
  return open_frames(std::move(*collection), path, options, {});
}

Result<OpenVolume> open_dicom_folder(const std::filesystem::path& path,
                                     const ImportOptions& options) {
  std::vector<std::string> notes;
  auto collection = collect_folder(path, options, notes);
  if (!collection) return tl::unexpected(collection.error());
  return open_frames(std::move(*collection), path, options, std::move(notes));
}

Result<std::vector<VolumeChoice>> dicom_volumes(const std::filesystem::path& path) {
  std::vector<std::string> notes;
  const bool is_folder = input_kind(path) == InputKind::folder;
  const auto collection = is_folder ? collect_folder(path, {}, notes) : collect_file(path);
  if (!collection) return tl::unexpected(collection.error());
  return list_stacks(*collection, path);
}

Result<std::vector<SegmentMap>> open_dicom_segments(const std::filesystem::path& path,
                                                    const ImportOptions& options) {
  std::vector<std::string> notes;
  const bool is_folder = input_kind(path) == InputKind::folder;
  auto collected = is_folder ? collect_folder(path, options, notes) : collect_file(path);
  if (!collected) return tl::unexpected(collected.error());
  Collection& collection = *collected;
  const auto kind_of = [&](const Frame& frame) {
    return collection.images[frame.image].segmentation.kind;
  };
  std::erase_if(collection.frames,
                [&](const Frame& frame) { return kind_of(frame) == Segmentation::Kind::none; });
  if (collection.frames.empty()) return std::vector<SegmentMap>{};
  const auto stack = choose_stack(collection, path, options, notes);
  if (!stack) return tl::unexpected(stack.error());
  if (kind_of(collection.frames[stack->frames.front()]) != Segmentation::Kind::labels) {
    return map_segments(collection, *stack, path, options, std::move(notes));
  }
  auto map = describe_label_map(collection, *stack, path, options);
  if (!map) return tl::unexpected(map.error());
  ImportOptions all = options;
  all.segment.clear();
  auto volume = open_frames(std::move(collection), path, all, std::move(notes));
  if (!volume) return tl::unexpected(volume.error());
  map->volume = std::move(*volume);
  std::vector<SegmentMap> maps;
  maps.push_back(std::move(*map));
  return maps;
}

}  // namespace isosplat::import
