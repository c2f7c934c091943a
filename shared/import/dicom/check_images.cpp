#include "shared/import/dicom/check_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "shared/import/dicom/collect.h"
#include "shared/import/volume/hash.h"

namespace isosplat::import::dicom {
namespace {

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

}  // namespace

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

std::string frame_of_reference(const Image& image) {
  const std::string& uid = image.frame_of_reference;
  return uid.empty() ? "" : "dicom-" + hash_text(uid);
}

std::string frame_of_reference(const Collection& collection, const std::vector<uint32_t>& frames,
                               std::vector<std::string>& notes) {
  std::set<std::string_view> found;
  for (const uint32_t index : frames) {
    found.insert(collection.images[collection.frames[index].image].frame_of_reference);
  }
  if (found.size() < 2) {
    return frame_of_reference(collection.images[collection.frames[frames.at(0)].image]);
  }
  notes.push_back(
      fmt::format("the slices have {} frames of reference (Frame of Reference UID): it is assumed "
                  "that they are the same",
                  found.size()));
  return {};
}

}  // namespace isosplat::import::dicom
