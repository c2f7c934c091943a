#include "shared/import/volume/volume_choices.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "shared/import/volume/import_options.h"

namespace isosplat::import {
namespace {

std::string with_name(std::string label, const std::string& name) {
  return name.empty() ? label : label + " (" + name + ")";
}

}  // namespace

void offer(const ImportOptions& options, std::vector<VolumeChoice> volumes) {
  if (options.choices) *options.choices = std::move(volumes);
}

void offer_steps(const ImportOptions& options, uint64_t count, const TimeAxis& times) {
  if (!options.choices) return;
  std::vector<VolumeChoice> steps(static_cast<size_t>(std::min<uint64_t>(count, kMaxOffered)));
  for (size_t i = 0; i < steps.size(); ++i) {
    steps[i].label = "time step " + std::to_string(i);
    steps[i].time_step = static_cast<int64_t>(i);
    if (i >= times.values.size()) continue;
    steps[i].time = times.values[i];
    steps[i].time_unit = times.unit;
    const std::string time = fmt::format("{} {}", times.values[i], times.unit);
    steps[i].label = with_name(steps[i].label, time.substr(0, time.find_last_not_of(' ') + 1));
  }
  offer(options, std::move(steps));
}

void offer_channels(const ImportOptions& options, uint64_t count,
                    const std::vector<ChannelDescription>& described) {
  if (!options.choices) return;
  std::vector<VolumeChoice> channels(static_cast<size_t>(std::min<uint64_t>(count, kMaxOffered)));
  for (size_t i = 0; i < channels.size(); ++i) {
    if (i < described.size()) {
      channels[i].name = described[i].name;
      channels[i].colour = described[i].colour;
    }
    channels[i].label = with_name("channel " + std::to_string(i), channels[i].name);
    channels[i].channel = static_cast<int64_t>(i);
  }
  offer(options, std::move(channels));
}

void offer_allowance(const ImportOptions& options, std::string_view message) {
  if (!options.choices || !options.choices->empty()) return;
  for (const AllowanceFlag& each : kAllowances) {
    if (options.allowed.has(each.allowance) || message.find(each.flag) == message.npos) continue;
    VolumeChoice choice;
    choice.label = each.help;
    choice.allowance = each.allowance;
    options.choices->push_back(std::move(choice));
    return;
  }
}

}  // namespace isosplat::import
