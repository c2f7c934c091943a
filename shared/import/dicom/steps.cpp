#include "shared/import/dicom/steps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <string_view>

namespace isosplat::import::dicom {
namespace {

struct Named {
  Key key;
  std::string_view name;
};

/// The frames of one volume have the same value of these keys, in the order in which they are
/// tried.
constexpr Named kGroups[] = {
    {Key::temporal_position, "temporal position"},
    {Key::frame_type, "image type"},
    {Key::quantity, "quantity"},
    {Key::echo, "echo"},
    {Key::b_value, "diffusion b-value"},
    {Key::gradient, "diffusion gradient"},
    {Key::inversion_time, "inversion time"},
    {Key::energy_window, "energy window"},
    {Key::detector, "detector"},
    {Key::rr_interval, "R-R interval"},
    {Key::time_slot, "time slot"},
    {Key::trigger_time, "trigger time"},
    {Key::dimension_1, "dimension index 1"},
    {Key::dimension_2, "dimension index 2"},
    {Key::dimension_3, "dimension index 3"},
    {Key::dimension_4, "dimension index 4"},
    {Key::dimension_5, "dimension index 5"},
    {Key::acquisition, "acquisition number"},
    {Key::reference_time, "frame reference time"},
    {Key::acquisition_time, "acquisition time"},
};

/// These keys vary from slice to slice within a volume, but are ordered at each position.
constexpr Named kRanks[] = {
    {Key::trigger_time, "trigger time"},         {Key::reference_time, "frame reference time"},
    {Key::acquisition_time, "acquisition time"}, {Key::content_time, "content time"},
    {Key::instance, "instance number"},
};

class StepFinder {
 public:
  StepFinder(const Collection& collection, const Positions& positions)
      : collection_(collection), positions_(positions) {
    for (const auto& position : positions) {
      max_ = std::max(max_, position.size());
      min_ = std::min(min_, position.size());
    }
    // Compares text in alphabetical order, not by its first occurrence.
    std::map<std::string_view, double> in_order;
    for (const std::string& text : collection.texts) in_order[text] = 0;
    double rank = 0;
    for (auto& [text, position] : in_order) position = rank++;
    for (const std::string& text : collection.texts) text_ranks_.push_back(in_order[text]);
  }

  Steps find() const {
    for (const Named& a : kGroups) {
      if (Steps steps = group({&a, 1}); !steps.frames.empty()) return steps;
    }
    for (size_t i = 0; i < std::size(kGroups); ++i) {
      for (size_t j = i + 1; j < std::size(kGroups); ++j) {
        const Named pair[] = {kGroups[i], kGroups[j]};
        if (Steps steps = group(pair); !steps.frames.empty()) return steps;
      }
    }
    for (const Named& named : kRanks) {
      if (Steps steps = rank(named); !steps.frames.empty()) return steps;
    }
    return {};
  }

 private:
  double value(uint32_t frame, Key key) const {
    const double number = collection_.frames[frame].keys[static_cast<size_t>(key)];
    if (std::isnan(number)) return -std::numeric_limits<double>::infinity();
    const bool is_text = key == Key::frame_type || key == Key::quantity || key == Key::gradient;
    return is_text ? text_ranks_[static_cast<size_t>(number)] : number;
  }

  Steps group(std::span<const Named> by) const {
    std::map<std::array<double, 2>, std::vector<uint32_t>> groups;
    for (const auto& position : positions_) {
      std::vector<std::array<double, 2>> seen;
      for (const uint32_t frame : position) {
        std::array<double, 2> key{value(frame, by[0].key),
                                  by.size() > 1 ? value(frame, by[1].key) : 0};
        if (std::find(seen.begin(), seen.end(), key) != seen.end()) return {};
        seen.push_back(key);
        groups[key].push_back(frame);
        if (groups.size() > max_) return {};
      }
    }
    if (groups.size() != max_) return {};
    Steps steps;
    std::vector<double> times;
    for (auto& [key, frames] : groups) {
      if (2 * frames.size() < positions_.size()) return {};  // a few extra frames are not a volume
      steps.frames.push_back(std::move(frames));
      times.push_back(key[0]);
    }
    // Trigger Time (0018,1060) and Frame Reference Time (0054,1300) are in milliseconds.
    const bool are_times = by[0].key == Key::trigger_time || by[0].key == Key::reference_time;
    if (by.size() == 1 && are_times) steps.times = TimeAxis::of(std::move(times), "ms");
    steps.distinguished_by = by[0].name;
    if (by.size() > 1) steps.distinguished_by += " and " + std::string(by[1].name);
    return steps;
  }

  Steps rank(const Named& by) const {
    if (min_ != max_) return {};
    Steps steps;
    steps.frames.resize(max_);
    for (std::vector<uint32_t> position : positions_) {
      std::sort(position.begin(), position.end(),
                [&](uint32_t a, uint32_t b) { return value(a, by.key) < value(b, by.key); });
      for (size_t i = 0; i < position.size(); ++i) {
        const double number = value(position[i], by.key);
        if (std::isinf(number) || (i > 0 && number == value(position[i - 1], by.key))) return {};
        steps.frames[i].push_back(position[i]);
      }
    }
    steps.distinguished_by = by.name;
    return steps;
  }

  const Collection& collection_;
  const Positions& positions_;
  std::vector<double> text_ranks_;  ///< alphabetical ranks of Collection::texts
  size_t max_ = 0, min_ = std::numeric_limits<size_t>::max();
};

}  // namespace

Steps find_steps(const Collection& collection, const Positions& positions) {
  return StepFinder(collection, positions).find();
}

}  // namespace isosplat::import::dicom
