#include "shared/import/dicom/segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "shared/import/text/header_text.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::import::dicom {
namespace {

using Kind = Segmentation::Kind;

/// Maximum number of segments that a message lists.
constexpr size_t kMaxListed = 24;

/// A segment of one file of the stack.
struct Candidate {
  uint32_t image = 0;
  int number = 0;
  std::string label;
  size_t frames = 0;
};

class SegmentChooser {
 public:
  SegmentChooser(const Collection& collection, Stack stack, const std::filesystem::path& path,
                 const ImportOptions& options, std::vector<std::string>& notes)
      : collection_(collection),
        stack_(std::move(stack)),
        path_(path),
        options_(options),
        wanted_(options.segment),
        notes_(notes) {}

  Result<Stack> choose() {
    const Segmentation& first = segmentation_of(stack_.frames.front());
    if (first.kind == Kind::none) {
      if (wanted_.empty()) return std::move(stack_);
      return fail(Status::invalid_argument,
                  fmt::format("{}: expected a segmentation for --segment, found an image: remove "
                              "the option, or choose the segmentation with --series",
                              path_.string()));
    }
    list_candidates(first.kind == Kind::labels);
    stack_.lattice = stack_.frames;
    return first.kind == Kind::labels ? choose_label() : choose_frames();
  }

 private:
  const Frame& frame_of(uint32_t index) const { return collection_.frames[index]; }
  const Segmentation& segmentation_of(uint32_t frame) const {
    return collection_.images[frame_of(frame).image].segmentation;
  }

  /// The candidate for a segment of a file; a new one if there is none.
  Candidate& candidate_of(uint32_t image, int number, const std::string& label) {
    const auto [found, is_new] = indices_.try_emplace({image, number}, candidates_.size());
    if (is_new) candidates_.push_back({image, number, label, 0});
    return candidates_[found->second];
  }

  /// Segments that the files describe, and those that only frames refer to.
  void list_candidates(bool is_label_map) {
    uint32_t last = ~uint32_t{0};
    for (const uint32_t index : stack_.frames) {
      const Frame& frame = frame_of(index);
      if (frame.image != last) {
        last = frame.image;
        for (const auto& segment : segmentation_of(index).segments) {
          candidate_of(is_label_map ? 0 : frame.image, segment.number, segment.label);
        }
      }
      if (!is_label_map) ++candidate_of(frame.image, frame.segment, {}).frames;
    }
  }

  std::optional<int> wanted_number() const {
    int number = 0;
    const auto [end, error] =
        std::from_chars(wanted_.data(), wanted_.data() + wanted_.size(), number);
    if (error != std::errc{} || end != wanted_.data() + wanted_.size()) return std::nullopt;
    return number;
  }

  /// The candidates that the option matches: by number, or else by label.
  std::vector<const Candidate*> matches() const {
    std::vector<const Candidate*> found;
    const auto number = wanted_number();
    for (const Candidate& candidate : candidates_) {
      if (number && candidate.number == *number) found.push_back(&candidate);
    }
    for (const Candidate& candidate : candidates_) {
      if (found.empty() && lower_case(candidate.label) == lower_case(wanted_)) {
        found.push_back(&candidate);
      }
    }
    return found;
  }

  std::string name_of(const Candidate& candidate) const {
    return candidate.label.empty() ? std::to_string(candidate.number)
                                   : fmt::format("{} (\"{}\")", candidate.number, candidate.label);
  }

  std::string list() const {
    std::string text;
    for (size_t i = 0; i < std::min(candidates_.size(), kMaxListed); ++i) {
      const Candidate& candidate = candidates_[i];
      text += (i > 0 ? "; " : "") + ("--segment " + std::to_string(candidate.number));
      if (!candidate.label.empty()) text += fmt::format(" or \"{}\"", candidate.label);
      if (!is_label_map()) text += fmt::format(", {} frames", candidate.frames);
    }
    if (candidates_.size() > kMaxListed) {
      text += fmt::format("; and {} more", candidates_.size() - kMaxListed);
    }
    return text;
  }

  bool is_label_map() const { return segmentation_of(stack_.frames.front()).kind == Kind::labels; }

  tl::unexpected<Error> wrong_choice(const std::string& found) const {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected one segment, found {}: choose one of {}", path_.string(),
                            found, list()));
  }

  /// Offers the segments that have frames and that an option can select uniquely.
  void offer_candidates() const {
    std::vector<VolumeChoice> offered;
    for (const Candidate& each : candidates_) {
      if (each.frames == 0) continue;
      const auto number = std::to_string(each.number);
      const auto equals = [&](const auto& same) {
        return std::count_if(candidates_.begin(), candidates_.end(), same) > 1;
      };
      const bool is_shared = equals([&](const Candidate& c) { return c.number == each.number; });
      if (is_shared && (each.label.empty() || equals([&](const Candidate& c) {
                          return lower_case(c.label) == lower_case(each.label);
                        }))) {
        continue;
      }
      offered.push_back({.label = "segment " + name_of(each),
                         .name = each.label,
                         .segment = is_shared ? each.label : number});
    }
    offer(options_, std::move(offered));
  }

  Result<Stack> choose_frames() {
    auto found = matches();
    if (wanted_.empty()) {
      if (candidates_.size() > 1) {
        offer_candidates();
        return wrong_choice(
            fmt::format("{} in a segmentation (isosplat build --labels makes a scene of all)",
                        candidates_.size()));
      }
      found = {&candidates_.front()};
    }
    if (found.empty()) return wrong_choice(fmt::format("none that is \"{}\"", wanted_));
    if (found.size() > 1) {
      return fail(Status::invalid_argument,
                  fmt::format("{}: expected one segment, found {} that are \"{}\", in different "
                              "files or with the same label: choose one by its number, or give its "
                              "file instead of the folder",
                              path_.string(), found.size(), wanted_));
    }
    const Candidate& chosen = *found.front();
    if (chosen.frames == 0) {
      return wrong_choice(
          fmt::format("segment {}, which has no frames: it is empty", name_of(chosen)));
    }
    std::erase_if(stack_.frames, [&](uint32_t index) {
      return frame_of(index).image != chosen.image || frame_of(index).segment != chosen.number;
    });
    // Only the frames of the same file determine where this segment is empty.
    std::erase_if(stack_.lattice,
                  [&](uint32_t index) { return frame_of(index).image != chosen.image; });
    if (candidates_.size() > 1) {
      notes_.push_back(
          fmt::format("this is segment {} of {}", name_of(chosen), candidates_.size()));
    }
    const Segmentation& segmentation = segmentation_of(stack_.frames.front());
    if (segmentation.kind == Kind::fractional) {
      notes_.push_back(fmt::format(
          "the values are stored fractions: {} stands for 1 (Maximum Fractional Value){}",
          segmentation.max_fraction,
          segmentation.fraction_type.empty()
              ? std::string()
              : fmt::format(", {}", lower_case(segmentation.fraction_type))));
    }
    return std::move(stack_);
  }

  Result<Stack> choose_label() {
    if (wanted_.empty()) return std::move(stack_);
    const auto found = matches();
    const auto number = wanted_number();
    if (found.empty() && (!number || !candidates_.empty())) {
      return wrong_choice(fmt::format("none that is \"{}\"", wanted_));
    }
    stack_.label = found.empty() ? *number : found.front()->number;
    notes_.push_back(
        fmt::format("voxels of segment {} are 1, all others 0",
                    found.empty() ? std::to_string(*number) : name_of(*found.front())));
    return std::move(stack_);
  }

  const Collection& collection_;
  Stack stack_;
  const std::filesystem::path& path_;
  const ImportOptions& options_;
  const std::string& wanted_;
  std::vector<std::string>& notes_;
  std::vector<Candidate> candidates_;
  std::map<std::pair<uint32_t, int>, size_t> indices_;  ///< of candidates, by file and number
};

}  // namespace

Result<Stack> choose_segment(const Collection& collection, Stack stack,
                             const std::filesystem::path& path, const ImportOptions& options,
                             std::vector<std::string>& notes) {
  return SegmentChooser(collection, std::move(stack), path, options, notes).choose();
}

}  // namespace isosplat::import::dicom
