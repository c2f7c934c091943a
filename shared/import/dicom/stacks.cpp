#include "shared/import/dicom/stacks.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::import::dicom {
namespace {

/// More stacks than this are not volumes, but unrelated slices.
constexpr size_t kMaxStacks = 1000;

/// Number of stacks that a message lists.
constexpr size_t kMaxListed = 8;

/// Directions that differ by less than this (0.06°) are equal; files have 4 to 16 digits.
constexpr double kSameDirection = 1e-3;
constexpr double kSameSpacing = 1e-3;  ///< relative

bool same_direction(Vec3d a, Vec3d b) {
  return length(a - b) < kSameDirection;
}

bool same_spacing(double a, double b) {
  return std::abs(a - b) <= kSameSpacing * std::max(std::abs(a), std::abs(b));
}

/// Whether two frames can be slices of one volume.
bool belong_to_one_stack(const Collection& collection, const Frame& a, const Frame& b) {
  const Image& image_a = collection.images[a.image];
  const Image& image_b = collection.images[b.image];
  return a.series == b.series && a.stack == b.stack && a.is_placed == b.is_placed &&
         image_a.segmentation.kind == image_b.segmentation.kind && a.is_inverse == b.is_inverse &&
         image_a.columns == image_b.columns && image_a.rows == image_b.rows &&
         same_direction(a.row, b.row) && same_direction(a.column, b.column) &&
         same_spacing(a.spacing_x, b.spacing_x) && same_spacing(a.spacing_y, b.spacing_y);
}

uint64_t voxels_of(const Collection& collection, const Stack& stack) {
  const Image& image = collection.images[collection.frames[stack.frames[0]].image];
  return static_cast<uint64_t>(image.columns) * static_cast<uint64_t>(image.rows) *
         stack.frames.size();
}

const char* plane_name(Vec3d normal) {
  const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
  const double largest = std::max({x, y, z});
  if (largest < 0.999) return "oblique";
  return largest == z ? "axial" : largest == y ? "coronal" : "sagittal";
}

std::string describe(const Collection& collection, const Stack& stack, size_t number) {
  const Frame& frame = collection.frames[stack.frames[0]];
  const Image& image = collection.images[frame.image];
  const Series& series = collection.series[frame.series];
  std::string text = fmt::format("--series {}: ", number);
  if (!series.modality.empty()) text += series.modality + ", ";
  text +=
      fmt::format("{} {}slices of {} × {}", stack.frames.size(),
                  frame.is_placed ? std::string(plane_name(cross(frame.row, frame.column))) + " "
                                  : std::string(),
                  image.columns, image.rows);
  if (frame.spacing_x > 0) text += fmt::format(", {:.4g} mm", frame.spacing_x);
  if (frame.stack > 0) text += fmt::format(", stack {}", collection.texts[frame.stack]);
  if (!series.description.empty()) text += fmt::format(", \"{}\"", series.description);
  return text + fmt::format(" ({})", series.uid);
}

std::string list_of(const Collection& collection, const std::vector<Stack>& stacks,
                    const std::vector<size_t>& which) {
  std::string text;
  for (size_t i = 0; i < std::min(which.size(), kMaxListed); ++i) {
    text += (i > 0 ? "; " : "") + describe(collection, stacks[which[i]], which[i] + 1);
  }
  if (which.size() > kMaxListed) text += fmt::format("; and {} more", which.size() - kMaxListed);
  return text;
}

/// ", 2026-11-29"; empty if the date has another form.
std::string date_part(const std::string& date) {
  const bool is_date = date.size() == 8 && std::all_of(date.begin(), date.end(),
                                                       [](char c) { return c >= '0' && c <= '9'; });
  if (!is_date) return {};
  return fmt::format(", {}-{}-{}", date.substr(0, 4), date.substr(4, 2), date.substr(6));
}

/// The stacks of several slices, as choices of --series.
std::vector<VolumeChoice> choices_of(const Collection& collection,
                                     const std::vector<Stack>& stacks) {
  std::vector<VolumeChoice> choices;
  for (size_t i = 0; i < stacks.size(); ++i) {
    if (stacks[i].frames.size() < 2) continue;
    const Frame& frame = collection.frames[stacks[i].frames[0]];
    const Image& image = collection.images[frame.image];
    const Series& series = collection.series[frame.series];
    std::string name = series.modality.empty() ? "" : series.modality + ", ";
    name += fmt::format("{} × {} × {}", image.columns, image.rows, stacks[i].frames.size());
    if (frame.stack > 0) name += fmt::format(", {}", collection.texts[frame.stack]);
    if (!series.description.empty()) name += fmt::format(", \"{}\"", series.description);
    name += date_part(series.date);
    choices.push_back({.label = fmt::format("series {}: {}", i + 1, name),
                       .name = name,
                       .series = std::to_string(i + 1)});
  }
  return choices;
}

bool is_segmentation(const Collection& collection, const Frame& frame) {
  return collection.images[frame.image].segmentation.kind != Segmentation::Kind::none;
}

/// All stacks, sorted: those with positions and the most voxels first, segmentations last.
Result<std::vector<Stack>> find_stacks(const Collection& collection,
                                       const std::filesystem::path& path, bool with_localizers) {
  std::vector<Stack> stacks;
  size_t last = 0;  // the next frame usually belongs to the same stack as the previous one
  for (uint32_t i = 0; i < collection.frames.size(); ++i) {
    const Frame& frame = collection.frames[i];
    if (frame.is_localizer && !with_localizers) continue;
    const auto takes = [&](const Stack& stack) {
      return belong_to_one_stack(collection, collection.frames[stack.frames[0]], frame);
    };
    if (last >= stacks.size() || !takes(stacks[last])) {
      last =
          static_cast<size_t>(std::find_if(stacks.begin(), stacks.end(), takes) - stacks.begin());
    }
    if (last == stacks.size()) stacks.emplace_back();
    stacks[last].frames.push_back(i);
    if (stacks.size() > kMaxStacks) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected slices of a volume, found more than {} that differ in "
                              "series, size or orientation: give the folder of one series",
                              path.string(), kMaxStacks));
    }
  }
  const auto rank = [&](const Stack& stack) {
    const Frame& frame = collection.frames[stack.frames[0]];
    return std::tuple(is_segmentation(collection, frame), !frame.is_placed,
                      -static_cast<int64_t>(voxels_of(collection, stack)),
                      collection.series[frame.series].uid);
  };
  std::stable_sort(stacks.begin(), stacks.end(),
                   [&](const Stack& a, const Stack& b) { return rank(a) < rank(b); });
  return stacks;
}

/// Parses --series: the number of a stack, or a Series Instance UID.
Result<size_t> named_stack(const Collection& collection, const std::vector<Stack>& stacks,
                           const std::filesystem::path& path, const std::string& name) {
  std::vector<size_t> all(stacks.size()), found;
  for (size_t i = 0; i < stacks.size(); ++i) {
    all[i] = i;
    const Frame& frame = collection.frames[stacks[i].frames[0]];
    if (collection.series[frame.series].uid == name) found.push_back(i);
  }
  size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool is_number = error == std::errc{} && end == name.data() + name.size();
  if (is_number && number >= 1 && number <= stacks.size()) return number - 1;
  if (found.size() == 1) return found[0];
  return fail(Status::invalid_argument,
              fmt::format("{}: expected one match for --series, found {} for {}: choose one of {}",
                          path.string(), found.size(), name,
                          list_of(collection, stacks, found.empty() ? all : found)));
}

}  // namespace

Result<Stack> choose_stack(const Collection& collection, const std::filesystem::path& path,
                           const ImportOptions& options, std::vector<std::string>& notes) {
  const auto localizers = std::count_if(collection.frames.begin(), collection.frames.end(),
                                        [](const Frame& frame) { return frame.is_localizer; });
  const bool only_localizers = localizers == static_cast<std::ptrdiff_t>(collection.frames.size());
  auto stacks = find_stacks(collection, path, only_localizers);
  if (!stacks) return tl::unexpected(stacks.error());
  if (localizers > 0 && !only_localizers) {
    notes.push_back(
        fmt::format("{} localizer image{} ignored", localizers, localizers > 1 ? "s are" : " is"));
  }
  if (!options.series.empty()) {
    const auto index = named_stack(collection, *stacks, path, options.series);
    if (!index) return tl::unexpected(index.error());
    return std::move((*stacks)[*index]);
  }
  const uint32_t series = collection.frames[stacks->front().frames[0]].series;
  std::vector<size_t> same, others;
  for (size_t i = 0; i < stacks->size(); ++i) {
    const bool is_same = collection.frames[(*stacks)[i].frames[0]].series == series;
    (is_same ? same : others).push_back(i);
  }
  if (auto choices = choices_of(collection, *stacks); choices.size() > 1) {
    offer(options, std::move(choices));
  }
  if (same.size() > 1) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected slices of one size, orientation and pixel spacing in a "
                            "series, found {} kinds: choose one of {}",
                            path.string(), same.size(), list_of(collection, *stacks, same)));
  }
  if (!others.empty()) {
    notes.push_back(fmt::format(
        "the largest of several DICOM series is read, {}; the others are {}",
        describe(collection, stacks->front(), 1), list_of(collection, *stacks, others)));
  }
  return std::move(stacks->front());
}

Result<std::vector<VolumeChoice>> list_stacks(const Collection& collection,
                                              const std::filesystem::path& path) {
  const auto stacks = find_stacks(collection, path, false);
  if (!stacks) return tl::unexpected(stacks.error());
  return choices_of(collection, *stacks);
}

}  // namespace isosplat::import::dicom
