#include "shared/import/dicom/dicom.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/dicom/order.h"
#include "shared/import/dicom/segments.h"
#include "shared/import/dicom/source.h"
#include "shared/import/dicom/stacks.h"
#include "shared/import/dicom/values.h"
#include "shared/import/slices/slice_files.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/volume/volume_name.h"
#include "shared/import/voxels/array_source.h"

// Reads DICOM: a folder with a file per slice, or files with several frames. frames.h makes
// frames from the files' elements, stacks.h groups frames into stacks, order.h orders
// them by position. values.h chooses the voxels' type. source.h reads the pixels when
// slices are requested.
namespace isosplat::import {
namespace {

/// Bytes that are read to recognize DICOM.
constexpr size_t kLookedAtBytes = 256;

using namespace dicom;

/// Number of file names that a note lists.
constexpr size_t kMaxNames = 4;

/// "a.txt, b.txt and 3 more".
std::string names_of(const std::vector<std::string>& files) {
  std::string text;
  for (size_t i = 0; i < std::min(files.size(), kMaxNames); ++i) {
    if (i > 0) text += ", ";
    text += std::filesystem::path(files[i]).filename().string();
  }
  if (files.size() > kMaxNames) text += fmt::format(" and {} more", files.size() - kMaxNames);
  return text;
}

/// Checks that all parts of a concatenation exist. Errors: malformed_volume, unless gaps are
/// allowed.
Result<void> check_parts(const Collection& collection, const std::vector<uint32_t>& frames,
                         const std::filesystem::path& path, const ImportOptions& options,
                         std::vector<std::string>& notes) {
  struct Parts {
    std::set<int> numbers;
    int total = 0;
  };
  std::map<std::string_view, Parts> images;
  for (const uint32_t index : frames) {
    const Concatenation& part = collection.images[collection.frames[index].image].concatenation;
    if (part.uid.empty()) continue;
    Parts& parts = images[part.uid];
    parts.numbers.insert(part.number);
    parts.total = std::max({parts.total, part.total, part.number});
  }
  for (const auto& [uid, parts] : images) {
    const auto there = static_cast<int>(parts.numbers.size());
    if (there >= parts.total) continue;
    const std::string what = fmt::format("{} of {} parts of the image (Concatenation) are missing",
                                         parts.total - there, parts.total);
    if (!options.allowed.has(Allowance::gaps)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: {}: give the folder with all of them, or read those that are "
                              "there with {}",
                              path.string(), what, flag_of(Allowance::gaps)));
    }
    notes.push_back(what);
  }
  return {};
}

/// Checks the chosen frames' files: returns an error, or adds notes.
Result<void> check_images(const Collection& collection, const std::vector<uint32_t>& frames,
                          const std::filesystem::path& path, const ImportOptions& options,
                          std::vector<std::string>& notes) {
  std::vector<std::string> cut_off, surplus;
  std::vector<std::string> assumptions;
  uint32_t last = ~uint32_t{0};
  for (const uint32_t index : frames) {
    const uint32_t image_index = collection.frames[index].image;
    if (image_index == last) continue;
    last = image_index;
    const Image& image = collection.images[image_index];
    if (!image.obstacle.empty()) {
      return fail(image.refusal, fmt::format("{}: {}", image.file, image.obstacle));
    }
    if (image.cut_off) cut_off.push_back(image.file);
    if (image.has_surplus) surplus.push_back(image.file);
    for (const std::string& note : image.notes) {
      const auto found = std::find(assumptions.begin(), assumptions.end(), note);
      if (found == assumptions.end()) assumptions.push_back(note);
    }
  }
  struct Case {
    const std::vector<std::string>& files;
    Allowance allowance;
    Status status;
    const char *what, *done;
  };
  const Case cases[] = {
      {cut_off, Allowance::truncated, Status::truncated, "end before their last pixel",
       "the missing pixels have no value"},
      {surplus, Allowance::surplus, Status::malformed_volume,
       "have more pixels than their header says", "the extra pixels are ignored"},
  };
  for (const Case& c : cases) {
    if (c.files.empty()) continue;
    const std::string text =
        fmt::format("{} of the files {} ({})", c.files.size(), c.what, names_of(c.files));
    if (!options.allowed.has(c.allowance)) {
      return fail(c.status, fmt::format("{}: {}: copy or export them again, or read them with {}",
                                        path.string(), text, flag_of(c.allowance)));
    }
    notes.push_back(fmt::format("{}: {}", text, c.done));
  }
  notes.insert(notes.end(), assumptions.begin(), assumptions.end());
  return check_parts(collection, frames, path, options, notes);
}

/// Adds a note if the positions of the frames refer to different origins.
void note_frames_of_reference(const Collection& collection, const std::vector<uint32_t>& frames,
                              std::vector<std::string>& notes) {
  std::set<std::string_view> found;
  for (const uint32_t index : frames) {
    found.insert(collection.images[collection.frames[index].image].frame_of_reference);
  }
  if (found.size() < 2) return;
  notes.push_back(fmt::format(
      "the slices have {} frames of reference (Frame of Reference UID): their positions "
      "are taken as those of one patient in one place",
      found.size()));
}

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
  note_frames_of_reference(collection, used, notes);
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
  VolumeHeader header{orientation->grid, values.type,  "DICOM",
                      volume_name(path), values.slope, values.intercept};
  volume.source = make_dicom_source(std::move(header), collection, arranged->planes, values,
                                    orientation->reverse_rows, options);
  return volume;
}

/// The files of a folder without frames, by reason.
struct IgnoredFiles {
  std::vector<std::string> not_dicom, no_pixels, colour, tiles, unreadable;

  /// Handles a file that ends before its pixels. Errors: truncated, unless gaps are allowed.
  Result<void> add_broken(const std::string& file, const ImportOptions& options) {
    if (options.allowed.has(Allowance::gaps)) {
      unreadable.push_back(file);
      return {};
    }
    return fail(Status::truncated,
                fmt::format("{}: expected a slice, found a file that ends before its pixels: copy "
                            "or export it again, or ignore it with {}",
                            file, flag_of(Allowance::gaps)));
  }

  void describe(std::vector<std::string>& notes) const {
    const auto add = [&](const std::vector<std::string>& files, const char* one, const char* many) {
      if (files.empty()) return;
      notes.push_back(fmt::format("{} file{} ignored, which {} ({})", files.size(),
                                  files.size() > 1 ? "s are" : " is", files.size() > 1 ? many : one,
                                  names_of(files)));
    };
    add(not_dicom, "is not DICOM", "are not DICOM");
    add(no_pixels, "has no pixels", "have no pixels");
    add(colour, "is a colour picture", "are colour pictures");
    add(tiles, "is a whole-slide image", "are whole-slide images");
    add(unreadable, "cannot be read", "cannot be read");
  }
};

/// Whether the file's extension is that of DICOM.
bool is_named_dicom(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".dcm" || extension == ".dicom" || extension == ".ima";
}

/// Whether a file ends before DICOM's prefix and all its bytes are 0. `beginning`: its first bytes,
/// if they can be read.
bool is_blank(const std::filesystem::path& path, const Result<std::string>& beginning) {
  if (!beginning) return input_state(path).value_or(InputState{1}).bytes == 0;
  return beginning->size() < 132 &&
         beginning->find_first_not_of('\0') >= std::min<size_t>(128, beginning->size());
}

/// Whether a file without pixels is incomplete: other files of its SOP class are images, or it ends
/// before its SOP class. Reports, plans and indices have other SOP classes.
bool is_truncated_image(const Collection& collection, const Pixelless& file) {
  return file.sop_class.empty() ||
         std::any_of(collection.images.begin(), collection.images.end(),
                     [&](const Image& image) { return image.sop_class == file.sop_class; });
}

tl::unexpected<Error> whole_slide(const std::filesystem::path& path, const std::string& tiles) {
  return fail(Status::unsupported_format,
              fmt::format("{}: expected slices of a volume, found {}: tiles are not slices; save "
                          "the focal planes, each as a whole, as TIFF slices",
                          path.string(), tiles));
}

Result<FileContent> add_file(const std::filesystem::path& path, Collection& collection) {
  const auto elements = read_elements(path);
  if (!elements) return tl::unexpected(elements.error());
  return add_frames(*elements, path, collection);
}

}  // namespace

bool is_dicom(std::string_view beginning) {
  return looks_like_dicom(beginning.substr(0, kLookedAtBytes));
}

bool is_dicom_file(const std::filesystem::path& path) {
  const auto beginning = read_beginning(path, kLookedAtBytes);
  return beginning && looks_like_dicom(*beginning);
}

Result<OpenVolume> open_dicom_file(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  Collection collection;
  const auto content = add_file(path, collection);
  if (!content) return tl::unexpected(content.error());
  if (*content == FileContent::colour) return not_scalar(path, 3);
  if (*content == FileContent::tiles) return whole_slide(path, collection.slides.front());
  if (*content == FileContent::no_pixels) {
    return fail(
        Status::unsupported_format,
        fmt::format("{}: expected a DICOM image, found one without pixels (a report, a plan, "
                    "an index, …): give the folder of the series",
                    path.string()));
  }
  if (const Image& image = collection.images.front(); !image.obstacle.empty()) {
    return fail(image.refusal, fmt::format("{}: {}", path.string(), image.obstacle));
  }
  if (collection.frames.size() < 2) {
    return fail(Status::no_cells,
                fmt::format("{}: expected a volume, found a single DICOM slice: give the folder "
                            "that holds the series",
                            path.string()));
  }
  return open_frames(std::move(collection), path, options, {});
}

Result<OpenVolume> open_dicom_folder(const std::filesystem::path& path,
                                     const ImportOptions& options) {
  Collection collection;
  IgnoredFiles ignored;
  for (const std::filesystem::path& file : files_of_folder(path, {})) {
    const std::string name = file.string();
    const auto beginning = read_beginning(file, kLookedAtBytes);
    if (!(beginning && is_dicom(*beginning)) && !is_named_dicom(file)) {
      if (!is_blank(file, beginning)) {
        ignored.not_dicom.push_back(name);
        continue;
      }
      if (auto r = ignored.add_broken(name, options); !r) return tl::unexpected(r.error());
      continue;
    }
    const auto content = add_file(file, collection);
    if (!content) {
      if (!options.allowed.has(Allowance::gaps)) {
        return fail(content.error().status,
                    fmt::format("{} (or ignore unreadable files with {})", content.error().message,
                                flag_of(Allowance::gaps)));
      }
      ignored.unreadable.push_back(name);
    } else if (*content == FileContent::colour) {
      ignored.colour.push_back(name);
    } else if (*content == FileContent::tiles) {
      ignored.tiles.push_back(name);
    }
  }
  for (const Pixelless& file : collection.without_pixels) {
    if (!is_truncated_image(collection, file)) {
      ignored.no_pixels.push_back(file.file);
    } else if (auto r = ignored.add_broken(file.file, options); !r) {
      return tl::unexpected(r.error());
    }
  }
  std::vector<std::string> notes;
  ignored.describe(notes);
  if (collection.frames.empty() && !collection.slides.empty()) {
    return whole_slide(path, collection.slides.front());
  }
  if (collection.frames.empty()) {
    std::string found = "neither";
    for (const std::string& note : notes) found += "; " + note;
    return fail(Status::unsupported_format,
                fmt::format("{}: expected a folder with DICOM or TIFF slices, found {}: give the "
                            "folder that contains the slices",
                            path.string(), found));
  }
  return open_frames(std::move(collection), path, options, std::move(notes));
}

}  // namespace isosplat::import
