#include "shared/import/hdf5/volumes.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/hdf5/attributes.h"
#include "shared/import/hdf5/pyramid.h"
#include "shared/import/text/commands.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::import {
namespace {

std::string text_of(const std::vector<uint64_t>& sizes) {
  return fmt::format("({})", fmt::join(sizes, ", "));
}

/// The object as a dataset, of any type and shape; nothing if it is a group or has no elements.
Result<std::optional<Hdf5Volume>> dataset_of(Hdf5File& file, const Hdf5Object& object,
                                             const std::string& path) {
  if (!object.find(Hdf5Kind::layout)) return std::nullopt;
  const auto elements = hdf5_elements(file, object);
  if (!elements) return tl::unexpected(elements.error());
  const auto& [sizes, type] = *elements;
  if (!type) return file.malformed("the type of an array is cut off");
  if (!sizes) return std::nullopt;
  const size_t slash = path.rfind('/');
  return Hdf5Volume{path, slash == path.npos ? "" : path.substr(0, slash), object, *sizes, *type};
}

size_t long_axes(const Hdf5Volume& dataset) {
  return static_cast<size_t>(std::count_if(dataset.sizes.begin(), dataset.sizes.end(),
                                           [](uint64_t size) { return size > 1; }));
}

bool is_volume(const Hdf5Volume& dataset) {
  return dataset.type.kind == Hdf5Type::Kind::number && long_axes(dataset) >= 3 &&
         std::find(dataset.sizes.begin(), dataset.sizes.end(), 0) == dataset.sizes.end();
}

/// All datasets, in the order of the links of groups.
Result<std::vector<Hdf5Volume>> datasets_of(Hdf5File& file) {
  struct Place {
    std::string path;
    uint64_t address;
  };
  std::vector<Hdf5Volume> found;
  std::vector<Place> places{{"", file.root()}};
  // Links may form cycles of groups.
  std::vector<uint64_t> seen{file.root()};  // ascending
  while (!places.empty()) {
    const Place place = std::move(places.back());
    places.pop_back();
    const auto object = read_hdf5_object(file, place.address);
    if (!object) return tl::unexpected(object.error());
    auto dataset = dataset_of(file, *object, place.path);
    if (!dataset) return tl::unexpected(dataset.error());
    if (*dataset) found.push_back(std::move(**dataset));
    auto links = hdf5_links(file, *object);
    if (!links) return tl::unexpected(links.error());
    // The stack returns the last one first. If a dataset has several paths, the first is kept.
    const size_t before = places.size();
    for (const Hdf5Link& link : *links) {
      const auto known = std::lower_bound(seen.begin(), seen.end(), link.address);
      if (known != seen.end() && *known == link.address) continue;
      seen.insert(known, link.address);
      places.push_back({place.path + "/" + link.name, link.address});
    }
    std::reverse(places.begin() + static_cast<std::ptrdiff_t>(before), places.end());
  }
  return found;
}

/// The error that states why a dataset is not a volume.
tl::unexpected<Error> no_volume(const Hdf5File& file, const Hdf5Volume& dataset) {
  const std::string path = printable(dataset.path);
  if (dataset.type.kind != Hdf5Type::Kind::number) {
    return unknown_type(file.path(), fmt::format("{} in {}", dataset.type.name, path));
  }
  return fail(
      Status::no_cells,
      fmt::format("{}: expected an array whose axes z, y and x have several voxels, found the "
                  "shape {} in {}: save the whole volume as one array",
                  file.path().string(), text_of(dataset.sizes), path));
}

/// Removes coarser copies of other volumes, and those with more axes than others.
void keep_finest(std::vector<Hdf5Volume>& volumes) {
  std::erase_if(volumes, [](const Hdf5Volume& each) { return !is_volume(each); });
  const auto finest = [&](const Hdf5Volume& each) {
    const auto place = hdf5_place(each.path);
    return !place || place->level == 0;
  };
  if (std::any_of(volumes.begin(), volumes.end(), finest)) {
    std::erase_if(volumes, [&](const Hdf5Volume& each) { return !finest(each); });
  }
  // Chimera's maps: copies of one map are in one group.
  const auto is_copy = [&](const Hdf5Volume& each) {
    return each.parent.starts_with("/Chimera/") &&
           std::any_of(volumes.begin(), volumes.end(), [&](const Hdf5Volume& other) {
             const bool is_before = &other < &each;
             return other.parent == each.parent && &other != &each &&
                    (other.sizes > each.sizes || (other.sizes == each.sizes && is_before));
           });
  };
  std::vector<bool> copies;
  for (const Hdf5Volume& each : volumes) copies.push_back(is_copy(each));
  std::vector<Hdf5Volume> kept;
  for (size_t i = 0; i < volumes.size(); ++i) {
    if (!copies[i]) kept.push_back(std::move(volumes[i]));
  }
  volumes = std::move(kept);
  const auto has_three = [](const Hdf5Volume& each) { return long_axes(each) == 3; };
  if (std::any_of(volumes.begin(), volumes.end(), has_three)) {
    std::erase_if(volumes, [&](const Hdf5Volume& each) { return !has_three(each); });
  }
}

/// The indices of an image pyramid's volumes, ascending, without repetitions.
std::vector<uint64_t> places(const std::vector<Hdf5Volume>& volumes, uint64_t Hdf5Place::*member) {
  std::vector<uint64_t> numbers;
  for (const Hdf5Volume& each : volumes) {
    if (const auto place = hdf5_place(each.path)) numbers.push_back((*place).*member);
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

/// The volume of an image pyramid that the options choose.
Result<Hdf5Volume> choose_of_pyramid(Hdf5File& file, std::vector<Hdf5Volume> volumes,
                                     ImportOptions& options) {
  const bool is_imaris = hdf5_place(volumes.front().path)->is_imaris;
  const char* what = is_imaris ? "channel" : "setup";
  const auto channels = places(volumes, &Hdf5Place::channel),
             times = places(volumes, &Hdf5Place::time);
  if (channels.size() > 1 && !options.channel) {
    std::string list;
    std::vector<VolumeChoice> offered;
    for (const uint64_t channel : channels) {
      const std::string name = hdf5_channel_name(file, channel, is_imaris);
      list += fmt::format("{}{}{}", list.empty() ? "" : ", ", channel, name);
      offered.push_back({.label = fmt::format("{} {}{}", what, channel, name),
                         .name = name.size() > 3 ? name.substr(2, name.size() - 3) : "",
                         .channel = static_cast<int64_t>(channel)});
    }
    offer(options, std::move(offered));
    return fail(Status::invalid_argument,
                fmt::format("{}: expected one {}, found {}: {}: choose one with --channel",
                            file.path().string(), what, channels.size(), list));
  }
  const auto channel = options.channel.value_or(static_cast<int64_t>(channels.front()));
  if (channel < 0 || std::find(channels.begin(), channels.end(), static_cast<uint64_t>(channel)) ==
                         channels.end()) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a --channel of {}, found {}: choose another",
                            file.path().string(), fmt::join(channels, ", "), channel));
  }
  const auto step = choose_step(file.path(), static_cast<int64_t>(times.size()), options);
  if (!step) return tl::unexpected(step.error());
  const uint64_t time = times[static_cast<size_t>(*step)];
  const auto found = std::find_if(volumes.begin(), volumes.end(), [&](const Hdf5Volume& each) {
    const auto place = hdf5_place(each.path);
    return place->time == time && place->channel == static_cast<uint64_t>(channel);
  });
  if (found == volumes.end()) {
    return file.malformed(
        fmt::format("{} {} does not exist at time step {}", what, channel, *step));
  }
  options.channel.reset();
  options.time_step.reset();
  return std::move(*found);
}

/// The dataset that the file names as its default: attributes "default" lead from the root to a
/// group, whose attribute "signal" names it (NeXus). Empty if there is none.
std::string default_path(Hdf5File& file) {
  constexpr int kMaxGroups = 10;
  std::string path;
  for (int i = 0; i < kMaxGroups; ++i) {
    const auto group = hdf5_object_at(file, path);
    if (!group || !*group) return {};
    const auto named = [&](const char* attribute) {
      const auto texts = hdf5_texts(file, **group, attribute);
      return texts && texts->size() == 1 ? texts->front() : std::string();
    };
    if (const std::string inside = named("default"); !inside.empty()) {
      path += "/" + inside;
      continue;
    }
    const std::string signal = named("signal");
    return signal.empty() ? "" : path + "/" + signal;
  }
  return {};
}

}  // namespace

std::string hdf5_text(const Hdf5Volume& volume) {
  const StoredVoxels& stored = volume.type.stored;
  return fmt::format("{} ({}, {})", printable(volume.path),
                     stored.is_half ? "f16" : voxel_type_name(stored.type),
                     fmt::join(volume.sizes, " × "));
}

std::string hdf5_advice(const std::filesystem::path& file, const Hdf5Volume& volume) {
  return fmt::format(
      "save one volume of it with python3 -c \"import sys, h5py, numpy; "
      "numpy.save('volume.npy', h5py.File(sys.argv[1])[sys.argv[2]][{}])\" {} {}",
      numpy_index({volume.sizes.begin(), volume.sizes.end()}), shell_word(file),
      shell_word(printable(volume.path)));
}

Result<std::vector<Hdf5Volume>> hdf5_volumes(Hdf5File& file) {
  auto datasets = datasets_of(file);
  if (datasets) keep_finest(*datasets);
  return datasets;
}

Result<std::optional<Hdf5Object>> hdf5_object_at(Hdf5File& file, std::string_view path) {
  auto object = read_hdf5_object(file, file.root());
  while (object && !path.empty()) {
    const size_t end = std::min(path.find('/'), path.size());
    const std::string_view name = path.substr(0, end);
    path.remove_prefix(std::min(end + 1, path.size()));
    if (name.empty()) continue;
    const auto links = hdf5_links(file, *object);
    if (!links) return tl::unexpected(links.error());
    const auto link = std::find_if(links->begin(), links->end(),
                                   [&](const Hdf5Link& each) { return each.name == name; });
    if (link == links->end()) return std::nullopt;
    object = read_hdf5_object(file, link->address);
  }
  if (!object) return tl::unexpected(object.error());
  return std::move(*object);
}

Result<Hdf5Volume> choose_hdf5_volume(Hdf5File& file, ImportOptions& options) {
  const std::string& path = options.dataset;
  if (!path.empty()) {
    const auto object = hdf5_object_at(file, path);
    if (!object) return tl::unexpected(object.error());
    if (*object) {
      auto dataset = dataset_of(file, **object, path.starts_with('/') ? path : "/" + path);
      if (!dataset) return tl::unexpected(dataset.error());
      if (*dataset && !is_volume(**dataset)) return no_volume(file, **dataset);
      if (*dataset) return std::move(**dataset);
    }
  }
  auto datasets = datasets_of(file);
  if (!datasets) return tl::unexpected(datasets.error());
  std::vector<Hdf5Volume> volumes = *datasets;
  keep_finest(volumes);
  if (volumes.empty() && path.empty()) {
    // The largest dataset describes the file best.
    const auto largest = std::max_element(
        datasets->begin(), datasets->end(), [](const Hdf5Volume& a, const Hdf5Volume& b) {
          const auto key = [](const Hdf5Volume& each) {
            return std::pair(each.type.kind == Hdf5Type::Kind::number, long_axes(each));
          };
          return key(a) < key(b);
        });
    if (largest != datasets->end()) return no_volume(file, *largest);
    return fail(Status::unsupported_format,
                fmt::format("{}: expected a volume, found an HDF5 file without arrays: choose "
                            "another file",
                            file.path().string()));
  }
  const auto is_placed = [](const Hdf5Volume& each) { return hdf5_place(each.path).has_value(); };
  if (path.empty() && std::all_of(volumes.begin(), volumes.end(), is_placed)) {
    return choose_of_pyramid(file, std::move(volumes), options);
  }
  std::string list;
  constexpr size_t kMaxListed = 20;
  for (const Hdf5Volume& volume : volumes) {
    if (&volume == &volumes.front() + kMaxListed) {
      list += ", …";
      break;
    }
    list += (list.empty() ? "" : ", ") + hdf5_text(volume);
  }
  if (!path.empty()) {
    return fail(
        Status::invalid_argument,
        fmt::format("{}: expected a dataset {}, found {}: choose one of those with "
                    "--dataset",
                    file.path().string(), printable(path), list.empty() ? "no volumes" : list));
  }
  if (volumes.size() == 1) return std::move(volumes.front());
  const std::string named = default_path(file);
  const auto found = std::find_if(volumes.begin(), volumes.end(),
                                  [&](const Hdf5Volume& each) { return each.path == named; });
  if (found != volumes.end()) return std::move(*found);
  std::vector<VolumeChoice> offered;
  for (const Hdf5Volume& each : volumes) {
    offered.push_back({.label = each.path, .name = hdf5_text(each), .dataset = each.path});
  }
  offer(options, std::move(offered));
  return fail(Status::invalid_argument,
              fmt::format("{}: expected one volume, found {}: {}: choose one with --dataset",
                          file.path().string(), volumes.size(), list));
}

}  // namespace isosplat::import
