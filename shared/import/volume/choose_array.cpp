#include "shared/import/volume/choose_array.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/volume/choose_channel.h"

namespace isosplat::import {
namespace {

std::vector<GridNumber> channels_of(const std::vector<GridArray>& arrays) {
  std::vector<GridNumber> channels;
  for (const bool of_cells : {false, true}) {
    for (size_t i = 0; i < arrays.size(); ++i) {
      if (arrays[i].of_cells != of_cells || !arrays[i].is_readable) continue;
      for (size_t k = 0; k < arrays[i].components && channels.size() < kMaxOffered; ++k) {
        channels.push_back({i, k});
      }
    }
    if (!channels.empty()) break;
  }
  return channels;
}

std::vector<ChannelDescription> names_of(const std::vector<GridArray>& arrays,
                                         const std::vector<GridNumber>& channels) {
  std::vector<ChannelDescription> names;
  for (const GridNumber& each : channels) {
    const GridArray& array = arrays[each.array];
    names.push_back({array.components == 1
                         ? array.name
                         : fmt::format("{}, component {}", array.name, each.component),
                     {}});
  }
  return names;
}

}  // namespace

Result<GridNumber> choose_array(const std::filesystem::path& path,
                                const std::vector<GridArray>& arrays, std::optional<size_t> scalars,
                                const ImportOptions& options, std::vector<std::string>& notes) {
  const std::vector<GridNumber> channels = channels_of(arrays);
  if (!scalars || (options.channel && !channels.empty())) {
    const auto channel = choose_channel(path, channels.size(), options, names_of(arrays, channels));
    if (!channel) return tl::unexpected(channel.error());
    return channels[static_cast<size_t>(*channel)];
  }
  const GridArray& array = arrays[*scalars];
  const char* const owner = array.of_cells ? "cells" : "points";
  const bool is_channel = std::any_of(channels.begin(), channels.end(),
                                      [&](const GridNumber& c) { return c.array == *scalars; });
  const auto is_elsewhere = [&](const GridArray& each) {
    return each.is_readable && each.components == 1 && each.of_cells != array.of_cells;
  };
  if (is_channel && channels.size() > 1) {
    offer_channels(options, channels.size(), names_of(arrays, channels));
    notes.push_back(fmt::format(
        "the file has {} arrays or components: '{}' of its {} is read; --channel 0 to --channel "
        "{} chooses another",
        channels.size(), array.name, owner, channels.size() - 1));
  } else if (std::any_of(arrays.begin(), arrays.end(), is_elsewhere)) {
    notes.push_back(fmt::format(
        "the file has arrays of points and of cells: '{}' of its {} is read", array.name, owner));
  }
  return GridNumber{*scalars, 0};
}

}  // namespace isosplat::import
