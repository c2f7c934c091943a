#include "shared/import/tiff/choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/core/grid/grid.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::import {
namespace {

constexpr size_t kMaxListed = 10, kMaxChoices = 1000;

std::string size_text(const TiffSeries& series) {
  const auto& [z, c, t] = series.sizes;
  std::string text = fmt::format("{} slice{}", z, z == 1 ? "" : "s");
  if (c > 1) text += fmt::format(", {} channels", c);
  if (t > 1) text += fmt::format(", {} times", t);
  return text;
}

/// "2 (cells, 30 slices)"
std::string describe(const TiffSeries& series, size_t number) {
  return fmt::format("{} ({}{}{})", number, series.name, series.name.empty() ? "" : ", ",
                     size_text(series));
}

Result<size_t> choose_series(const std::filesystem::path& path,
                             const std::vector<TiffSeries>& series, const ImportOptions& options,
                             std::vector<std::string>& notes) {
  std::string list;
  for (size_t i = 0; i < std::min(series.size(), kMaxListed); ++i) {
    list += fmt::format("{}--series {}", i == 0 ? "" : ", ", describe(series[i], i + 1));
  }
  if (series.size() > kMaxListed) list += ", …";
  if (!options.series.empty()) {
    const auto number = whole_number(options.series);
    if (number && *number >= 1 && static_cast<uint64_t>(*number) <= series.size()) {
      return static_cast<size_t>(*number) - 1;
    }
    for (size_t i = 0; i < series.size(); ++i) {
      if (series[i].name == options.series) return i;
    }
    return fail(
        Status::invalid_argument,
        fmt::format("{}: expected an image of the file, found --series {}: choose one of {}",
                    path.string(), options.series, list));
  }
  if (series.size() == 1) return size_t{0};
  const auto is_volume = [](const TiffSeries& each) { return each.size(TiffAxis::z) > 1; };
  const auto first = std::find_if(series.begin(), series.end(), is_volume);
  const bool is_described = std::all_of(series.begin(), series.end(),
                                        [](const TiffSeries& each) { return each.counted; });
  if (is_described && std::count_if(series.begin(), series.end(), is_volume) == 1) {
    const auto index = static_cast<size_t>(first - series.begin());
    notes.push_back(fmt::format("the file has {} images: the only one with slices is read, {}",
                                series.size(), describe(series[index], index + 1)));
    return index;
  }
  std::vector<VolumeChoice> offered;
  for (size_t i = 0; i < series.size(); ++i) {
    const auto& [z, channels, times] = series[i].sizes;
    if (z < 2 && channels < 2 && times < 2) continue;
    offered.push_back({.label = "image " + describe(series[i], i + 1),
                       .name = series[i].name,
                       .series = std::to_string(i + 1)});
  }
  offer(options, std::move(offered));
  return fail(Status::invalid_argument,
              fmt::format("{}: expected one volume, found {} images: choose one of {}",
                          path.string(), series.size(), list));
}

std::string names_of(const TiffSeries& series) {
  std::string text;
  for (const auto& [name, colour] : series.channels) {
    if (name.empty()) return {};
    text += (text.empty() ? "" : ", ") + name;
    if (text.size() > 200) return {};
  }
  return text.empty() ? "" : " (" + text + ")";
}

/// If an array has two axes without names in addition to x and y, and the options choose a channel,
/// the second of them is the axis of channels.
void make_channels(TiffSeries& series) {
  series.size(TiffAxis::channel) = series.size(TiffAxis::z);
  series.size(TiffAxis::z) = series.size(TiffAxis::time);
  series.size(TiffAxis::time) = 1;
  series.order = {TiffAxis::channel, TiffAxis::z, TiffAxis::time};
}

/// The axis of the slices, if the z axis has only one.
Result<TiffAxis> choose_frames(const std::filesystem::path& path, const TiffSeries& series,
                               const ImportOptions& options) {
  const uint64_t channels = series.size(TiffAxis::channel), times = series.size(TiffAxis::time);
  if (!options.allowed.has(Allowance::frames)) {
    const std::string found = channels > 1 && times > 1
                                  ? fmt::format("{} channels at {} times", channels, times)
                              : times > 1 ? fmt::format("at {} times", times)
                                          : fmt::format("of {} channels", channels);
    return fail(
        Status::no_cells,
        fmt::format("{}: expected slices, found one slice {}: if the {} are slices, read "
                    "them with {}{}",
                    path.string(), found, times > 1 ? "times" : "channels",
                    flag_of(Allowance::frames), channels > 1 && times > 1 ? " --channel 0" : ""));
  }
  if (channels > 1 && times > 1) {
    if (options.channel.has_value() == options.time_step.has_value()) {
      if (!options.channel) offer_channels(options, channels, series.channels);
      return fail(Status::invalid_argument,
                  fmt::format("{}: expected slices, found {} channels at {} times: choose a "
                              "--channel to read its times as slices, or a --time-step to read its "
                              "channels as slices",
                              path.string(), channels, times));
    }
    return options.channel ? TiffAxis::time : TiffAxis::channel;
  }
  return times > 1 ? TiffAxis::time : TiffAxis::channel;
}

}  // namespace

Result<TiffVolume> choose_tiff_volume(const std::filesystem::path& path,
                                      std::vector<TiffSeries> series, const ImportOptions& options,
                                      std::vector<std::string>& notes) {
  const auto index = choose_series(path, series, options, notes);
  if (!index) return tl::unexpected(index.error());
  TiffVolume volume;
  volume.series = std::move(series[*index]);
  TiffSeries& chosen = volume.series;
  const bool may_be_channels =
      chosen.unnamed && !chosen.depth_is_z && chosen.size(TiffAxis::channel) == 1;
  if (may_be_channels && options.channel) {
    make_channels(chosen);
    notes.push_back(
        fmt::format("the axes of the array have no names: the second one, of {}, is "
                    "read as channels",
                    chosen.size(TiffAxis::channel)));
  } else if (chosen.unnamed && !options.time_step) {
    const uint64_t others = chosen.size(TiffAxis::time), slices = chosen.size(TiffAxis::z);
    offer_steps(options, others);
    return fail(Status::invalid_argument,
                fmt::format("{}: expected one volume, found an array of {} × {} planes whose axes "
                            "have no names: choose one of {} volumes with --time-step 0 to "
                            "--time-step {}{}",
                            path.string(), others, slices, others, others - 1,
                            may_be_channels
                                ? fmt::format(", or, if the second axis has channels, one of {} "
                                              "with --channel 0 to --channel {}",
                                              slices, slices - 1)
                                : ""));
  } else if (chosen.unnamed) {
    notes.push_back(
        fmt::format("the axes of the array have no names: the first one, of {}, is "
                    "read as several volumes",
                    chosen.size(TiffAxis::time)));
  }
  const uint64_t channels = chosen.size(TiffAxis::channel), times = chosen.size(TiffAxis::time);
  if (chosen.size(TiffAxis::z) == 1 && (channels > 1 || times > 1)) {
    const auto axis = choose_frames(path, chosen, options);
    if (!axis) return tl::unexpected(axis.error());
    volume.slices = *axis;
    notes.push_back(fmt::format("the file has one slice: its {} {} are read as slices",
                                chosen.size(*axis),
                                *axis == TiffAxis::time ? "times" : "channels"));
  }
  if (volume.slices != TiffAxis::channel) {
    const auto channel = choose_channel(path, channels, options, chosen.channels, names_of(chosen));
    if (!channel) return tl::unexpected(channel.error());
    volume.fixed[static_cast<size_t>(TiffAxis::channel)] = *channel;
  }
  if (volume.slices != TiffAxis::time) {
    const auto count = static_cast<int64_t>(times);
    const auto step = choose_step(
        path, count, options, TimeAxis::regular(0, chosen.time_distance, count, chosen.time_unit));
    if (!step) return tl::unexpected(step.error());
    volume.fixed[static_cast<size_t>(TiffAxis::time)] = *step;
  }
  if (volume.size() > static_cast<uint64_t>(kMaxVoxelsPerAxis)) {
    return fail(Status::volume_too_large,
                fmt::format("{}: expected up to {} slices, found {}: crop the volume",
                            path.string(), kMaxVoxelsPerAxis, volume.size()));
  }
  return volume;
}

std::vector<VolumeChoice> tiff_choices(const std::vector<TiffSeries>& series) {
  std::vector<VolumeChoice> all;
  for (size_t i = 0; i < series.size(); ++i) {
    const auto& [z, channels, times] = series[i].sizes;
    if (z < 2) continue;
    for (uint64_t channel = 0; channel < channels; ++channel) {
      for (uint64_t time = 0; time < times; ++time) {
        if (all.size() >= kMaxChoices) return all;
        VolumeChoice choice;
        const auto add = [&](const std::string& part) {
          choice.label += (choice.label.empty() ? "" : ", ") + part;
        };
        if (series.size() > 1) {
          choice.series = std::to_string(i + 1);
          add(series[i].name.empty() ? fmt::format("image {}", i + 1) : series[i].name);
        }
        if (channels > 1) {
          choice.channel = static_cast<int64_t>(channel);
          const auto& described = series[i].channels;
          const auto at = static_cast<size_t>(channel);
          add(at < described.size() && !described[at].name.empty()
                  ? described[at].name
                  : fmt::format("channel {}", channel));
        }
        if (times > 1) {
          choice.time_step = static_cast<int64_t>(time);
          add(fmt::format("{} {}", series[i].unnamed ? "volume" : "time step", time));
        }
        all.push_back(std::move(choice));
      }
    }
  }
  if (all.size() < 2) all.clear();
  return all;
}

}  // namespace isosplat::import
