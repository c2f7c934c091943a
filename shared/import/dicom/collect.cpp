#include "shared/import/dicom/collect.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/dicom/dicom.h"
#include "shared/import/slices/slice_files.h"
#include "shared/import/text/header_text.h"
#include "shared/import/text/name_list.h"
#include "shared/import/volume/refusals.h"

namespace isosplat::import::dicom {
namespace {

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

/// Number of file names that a note lists.
constexpr size_t kMaxNames = 4;

/// "a.txt, b.txt and 3 more".
std::string names_of(const std::vector<std::string>& files) {
  std::vector<std::string> names;
  for (const std::string& file : files) {
    names.push_back(std::filesystem::path(file).filename().string());
  }
  return name_list(names, kMaxNames);
}

Result<Collection> collect_file(const std::filesystem::path& path) {
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
  return collection;
}

Result<Collection> collect_folder(const std::filesystem::path& path, const ImportOptions& options,
                                  std::vector<std::string>& notes) {
  Collection collection;
  IgnoredFiles ignored;
  for (const std::filesystem::path& file : files_of_folder(path, {})) {
    const std::string name = file.string();
    const auto beginning = read_beginning(file, kDicomBeginning);
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
  return collection;
}

}  // namespace isosplat::import::dicom
