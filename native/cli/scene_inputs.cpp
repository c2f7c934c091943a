#include "native/cli/scene_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <string_view>

#include "native/cli/numbers.h"
#include "shared/core/scene/scene.h"
#include "shared/import/slices/slice_files.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;
using import::ImportOptions;
using import::VolumeChoice;

/// Larger lists are refused, since a list may come from a stranger.
constexpr uintmax_t kMaxListBytes = uintmax_t{64} << 20;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The number in which the names differ, for each name. Empty if they differ in anything else, or
/// if the numbers do not ascend.
std::vector<double> times_in_names(const std::vector<std::string>& names) {
  const std::string& first = names.front();
  size_t before = first.size(), after = first.size();
  for (const std::string& name : names) {
    const auto [a, b] = std::mismatch(first.begin(), first.end(), name.begin(), name.end());
    before = std::min(before, static_cast<size_t>(a - first.begin()));
    const auto [c, d] = std::mismatch(first.rbegin(), first.rend(), name.rbegin(), name.rend());
    after = std::min(after, static_cast<size_t>(c - first.rbegin()));
  }
  // Digits that all names share belong to their numbers.
  while (before > 0 && is_digit(first[before - 1])) --before;
  while (after > 0 && is_digit(first[first.size() - after])) --after;
  std::vector<double> times;
  for (const std::string& name : names) {
    if (name.size() < before + after) return {};
    const std::string digits = name.substr(before, name.size() - before - after);
    const bool is_number = !digits.empty() && digits.size() <= 15 &&
                           std::all_of(digits.begin(), digits.end(), is_digit);
    if (!is_number) return {};
    times.push_back(std::stod(digits));
    if (times.size() > 1 && times.back() <= times[times.size() - 2]) return {};
  }
  return times;
}

void add_steps(SceneInputs& inputs, const std::vector<fs::path>& files,
               const ImportOptions& options) {
  inputs.layers = {""};
  for (size_t i = 0; i < files.size(); ++i) inputs.volumes.push_back({files[i], options, 0, i});
}

std::vector<double> indices(size_t count) {
  std::vector<double> times(count);
  for (size_t i = 0; i < count; ++i) times[i] = static_cast<double>(i);
  return times;
}

/// Takes the times of the steps if the file states all of them, otherwise none.
void take_times(const std::vector<VolumeChoice>& steps, SceneInputs& inputs) {
  for (const VolumeChoice& step : steps) {
    if (!step.time) {
      inputs.times.clear();
      return;
    }
    inputs.times.push_back(*step.time);
  }
  inputs.time_unit = steps.front().time_unit;
}

/// The choices that a file leaves open, if it is one of channels or of time steps. Empty: it has
/// one volume. Errors: those of open_volume; invalid_argument if there are too many to list.
Result<std::vector<VolumeChoice>> choices_of(const fs::path& file, ImportOptions options) {
  std::vector<VolumeChoice> choices;
  options.choices = &choices;
  const auto opened = import::open_volume(file, options);
  const auto all_have = [&](auto member) {
    return std::all_of(choices.begin(), choices.end(),
                       [&](const VolumeChoice& choice) { return (choice.*member).has_value(); });
  };
  const bool is_known =
      !choices.empty() && (all_have(&VolumeChoice::channel) || all_have(&VolumeChoice::time_step));
  if (is_known && choices.size() >= import::kMaxOffered) {
    // There may be more, which the list leaves out.
    return fail(Status::invalid_argument,
                fmt::format("{}: expected fewer than {} time steps or channels, found more: choose "
                            "one with --time-step or --channel, or save parts as separate files",
                            file.string(), import::kMaxOffered));
  }
  if (is_known) return choices;
  if (!opened) return tl::unexpected(opened.error());
  return std::vector<VolumeChoice>{};
}

}  // namespace

SceneInputs files_as_steps(std::vector<fs::path> files, const ImportOptions& options) {
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return import::natural_order(a.string(), b.string());
  });
  SceneInputs inputs;
  add_steps(inputs, files, options);
  std::vector<std::string> names;
  for (const fs::path& file : files) names.push_back(file.filename().string());
  inputs.times = times_in_names(names);
  if (inputs.times.empty()) {
    inputs.times = indices(files.size());
    inputs.notes.push_back(
        "the names of the files have no ascending numbers: the times are 0, 1, 2, …; --steps FILE "
        "states others");
  } else {
    inputs.notes.push_back(
        fmt::format("the times are the numbers in the names of the files, {} to {}: --steps FILE "
                    "states others",
                    inputs.times.front(), inputs.times.back()));
  }
  return inputs;
}

Result<SceneInputs> listed_steps(const fs::path& list, const ImportOptions& options) {
  std::error_code failed;
  const uintmax_t bytes = fs::file_size(list, failed);
  std::ifstream in(list);
  if (failed || !in) {
    return fail(Status::io_error, list.string() + ": expected a list of steps, cannot read it");
  }
  if (bytes > kMaxListBytes) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected a list of at most {} bytes, found {}", list.string(),
                            kMaxListBytes, bytes));
  }
  SceneInputs inputs;
  std::vector<fs::path> files;
  std::string line;
  for (size_t number = 1; std::getline(in, line); ++number) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    const size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string::npos || line[begin] == '#') continue;
    const size_t end = line.find_first_of(" \t", begin);
    const size_t path = end == std::string::npos ? end : line.find_first_not_of(" \t", end);
    const auto time =
        path == std::string::npos ? std::nullopt : parse_number(line.substr(begin, end - begin));
    const auto refuse = [&](std::string_view expected) {
      return fail(Status::malformed_volume, fmt::format("{}, line {}: expected {}, found '{}'",
                                                        list.string(), number, expected, line));
    };
    if (!time) return refuse("a time, a blank and a path");
    if (!inputs.times.empty() && *time <= inputs.times.back()) {
      return refuse("a time above that of the step before");
    }
    if (files.size() == kMaxSteps) return refuse(fmt::format("at most {} steps", kMaxSteps));
    inputs.times.push_back(*time);
    files.push_back(list.parent_path() / line.substr(path));
  }
  if (files.empty()) {
    return fail(Status::malformed_volume,
                list.string() + ": expected lines of a time, a blank and a path, found none");
  }
  add_steps(inputs, files, options);
  return inputs;
}

Result<SceneInputs> volumes_of_file(const fs::path& file, const ImportOptions& options) {
  SceneInputs inputs;
  // Layers are channels, and steps are steps of time. A file may offer either choice first.
  struct Open {
    ImportOptions options;
    size_t layer, step;
  };
  std::vector<Open> open{{options, 0, 0}};
  size_t steps = 1;
  while (!open.empty()) {
    const Open next = open.back();
    open.pop_back();
    const auto choices = choices_of(file, next.options);
    if (!choices) return tl::unexpected(choices.error());
    if (choices->size() < 2) {
      inputs.volumes.push_back({file, next.options, next.layer, next.step});
      continue;
    }
    const bool are_channels = choices->front().channel.has_value();
    for (size_t i = 0; i < choices->size(); ++i) {
      Open each = next;
      if (are_channels) {
        each.options.channel = (*choices)[i].channel;
        each.layer = i;
        if (inputs.layers.size() <= i) {
          const std::string& name = (*choices)[i].name;
          inputs.layers.push_back(name.empty() ? fmt::format("channel {}", i) : name);
          inputs.colours.push_back((*choices)[i].colour);
        }
      } else {
        each.options.time_step = (*choices)[i].time_step;
        each.step = i;
        steps = std::max(steps, i + 1);
      }
      open.push_back(std::move(each));
    }
    if (!are_channels && inputs.times.empty()) take_times(*choices, inputs);
  }
  if (inputs.layers.empty()) inputs.layers = {""};
  if (inputs.times.size() != steps) {
    inputs.times = indices(steps);
    inputs.time_unit.clear();
  }
  std::sort(inputs.volumes.begin(), inputs.volumes.end(),
            [](const SceneInput& a, const SceneInput& b) {
              return std::pair(a.layer, a.step) < std::pair(b.layer, b.step);
            });
  if (inputs.layers.size() > kMaxLayers || steps > kMaxSteps ||
      inputs.volumes.size() != inputs.layers.size() * steps) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected the same time steps of each channel, at most {} channels "
                            "and {} steps: choose with --channel or --time-step",
                            file.string(), kMaxLayers, kMaxSteps));
  }
  return inputs;
}

}  // namespace isosplat::cli
