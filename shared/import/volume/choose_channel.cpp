#include "shared/import/volume/choose_channel.h"

#include <fmt/format.h>

namespace isosplat::import {
namespace {

constexpr size_t kMaxListed = 20;

/// " (0: density; 1: velocity, component 0; …)"; empty if no channel has a name.
std::string listed(const std::vector<ChannelDescription>& described, uint64_t count) {
  std::string list;
  for (size_t i = 0; i < described.size() && i < count; ++i) {
    if (described[i].name.empty()) continue;
    list += list.empty() ? " (" : "; ";
    if (i >= kMaxListed) return list + "…)";
    list += fmt::format("{}: {}", i, described[i].name);
  }
  return list.empty() ? list : list + ")";
}

}  // namespace

Result<uint64_t> choose_channel(const std::filesystem::path& path, uint64_t count,
                                const ImportOptions& options,
                                const std::vector<ChannelDescription>& described,
                                std::string_view which) {
  if (count > 1 && !options.channel) {
    offer_channels(options, count, described);
    return fail(Status::unsupported_type,
                fmt::format("{}: expected one number per voxel, found {} channels{}: choose one "
                            "with --channel 0 to --channel {}{}",
                            path.string(), count, which, count - 1, listed(described, count)));
  }
  const int64_t channel = options.channel.value_or(0);
  if (channel < 0 || static_cast<uint64_t>(channel) >= count) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a --channel from 0 to {}, found {}: choose another{}",
                            path.string(), count - 1, channel, listed(described, count)));
  }
  return static_cast<uint64_t>(channel);
}

std::vector<ChannelDescription> rgba_channels() {
  return {{"red", {{1, 0, 0}}}, {"green", {{0, 1, 0}}}, {"blue", {{0, 0, 1}}}, {"alpha", {}}};
}

}  // namespace isosplat::import
