#include <fmt/format.h>

#include <algorithm>

#include "shared/import/axes/cf_axis.h"
#include "shared/import/hdf5/array.h"
#include "shared/import/hdf5/attributes.h"
#include "shared/import/hdf5/description.h"
#include "shared/import/text/header_text.h"

// Axes that attributes name:
//
// HDF5's dimension scales (h5py, netCDF-4)  DIMENSION_LIST refers to datasets of positions;
//                                           DIMENSION_LABELS has names. netCDF's dimensions without
//                                           positions are such datasets too; their NAME says so.
// CF (netCDF)                               of positions: axis, standard_name, units, positive
// NeXus                                     of the group: signal, axes (names of datasets);
//                                           before 2014 of the dataset: axes="z:y:x"
// vigra (ilastik)                           axistags: {"axes": [{"key": "z", …}, …]}
// Fiji, ilastik                             element_size_um
namespace isosplat::import {
namespace {

/// The keys in vigra's text; empty if the text has another number of axes.
std::vector<std::string> tagged_axes(std::string_view text, size_t axes) {
  constexpr std::string_view kKey = "\"key\"";
  std::vector<std::string> names;
  for (size_t at = text.find(kKey); at != text.npos; at = text.find(kKey, at + 1)) {
    const size_t colon = text.find_first_not_of(" \n\t", at + kKey.size());
    if (colon == text.npos || text[colon] != ':') return {};
    const size_t begin = text.find_first_not_of(" \n\t", colon + 1);
    if (begin == text.npos || text[begin] != '"') return {};
    const size_t end = text.find('"', begin + 1);
    if (end == text.npos) return {};
    names.emplace_back(text.substr(begin + 1, end - begin - 1));
  }
  return names.size() == axes ? names : std::vector<std::string>{};
}

/// The names of a text such as "z:y:x", or of several texts.
std::vector<std::string> listed(const std::vector<std::string>& texts) {
  if (texts.size() != 1) return texts;
  std::vector<std::string> names(1);
  for (const char c : texts.front()) {
    if (c == '[' || c == ']' || c == ' ') continue;
    if (c == ':' || c == ',') {
      names.emplace_back();
    } else {
      names.back() += c;
    }
  }
  return names;
}

class Reader {
 public:
  Reader(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
         ArrayDescription& description)
      : file_(file), volume_(volume), axes_(description.axes), notes_(description.notes) {}

  Result<void> read() {
    if (auto read = read_scales(); !read) return read;
    if (auto read = read_nexus(); !read) return read;
    if (const auto tags = hdf5_texts(*file_, volume_.object, "axistags");
        tags && tags->size() == 1) {
      const auto names = tagged_axes(tags->front(), axes_.size());
      for (size_t i = 0; i < names.size(); ++i) axes_[i].name = names[i];
    }
    const bool has_width = std::any_of(axes_.begin(), axes_.end(), [](const ArrayAxis& axis) {
      return lower_case(axis.name) == "width";
    });
    for (ArrayAxis& axis : axes_) {
      if (axis.letter == 0) axis.letter = axis_letter(axis.name, has_width);
    }
    for (const auto& [i, object] : positions_) {
      if (auto placed = place(axes_[i], object); !placed) return placed;
    }
    read_sizes();
    return {};
  }

 private:
  Result<void> read_scales() {
    if (const auto labels = hdf5_texts(*file_, volume_.object, "DIMENSION_LABELS");
        labels && labels->size() == axes_.size()) {
      for (size_t i = 0; i < axes_.size(); ++i) axes_[i].name = (*labels)[i];
    }
    const auto lists = hdf5_references(*file_, volume_.object, "DIMENSION_LIST");
    if (!lists || lists->size() != axes_.size()) return {};
    for (size_t i = 0; i < axes_.size(); ++i) {
      for (const uint64_t address : (*lists)[i]) {
        const auto scale = read_hdf5_object(*file_, address);
        if (!scale) return tl::unexpected(scale.error());
        auto name = name_of(address);
        if (!name) return tl::unexpected(name.error());
        const std::string own = hdf5_text(*file_, *scale, "NAME");
        const bool has_positions = !own.starts_with("This is a netCDF dimension");
        if (name->empty() && has_positions) *name = own;
        // netCDF renames a dimension whose name is that of another variable.
        constexpr std::string_view kPrefix = "_nc4_non_coord_";
        if (name->starts_with(kPrefix)) name->erase(0, kPrefix.size());
        if (axes_[i].name.empty()) axes_[i].name = *name;
        if (has_positions) add_positions(i, *scale);
      }
    }
    return {};
  }

  /// The name of an object in the volume's group or a group around it.
  Result<std::string> name_of(uint64_t address) {
    std::string group = volume_.parent;
    for (;;) {
      const auto object = hdf5_object_at(*file_, group);
      if (!object) return tl::unexpected(object.error());
      if (*object) {
        const auto links = hdf5_links(*file_, **object);
        if (!links) return tl::unexpected(links.error());
        for (const Hdf5Link& link : *links) {
          if (link.address == address) return link.name;
        }
      }
      if (group.empty()) return std::string();
      group.resize(std::min(group.rfind('/'), group.size()));
    }
  }

  Result<void> read_nexus() {
    const auto group = hdf5_object_at(*file_, volume_.parent);
    if (!group) return tl::unexpected(group.error());
    auto names = hdf5_texts(*file_, volume_.object, "axes");
    if (*group) {
      const auto signal = hdf5_texts(*file_, **group, "signal");
      const auto axes = hdf5_texts(*file_, **group, "axes");
      // A group states positions only for its signal.
      if (axes && signal && signal->size() == 1 &&
          volume_.path == volume_.parent + "/" + signal->front()) {
        names = axes;
      }
    }
    if (!names) return {};
    const auto list = listed(*names);
    if (list.size() != axes_.size()) return {};
    for (size_t i = 0; i < axes_.size(); ++i) {
      if (list[i].empty() || list[i] == ".") continue;
      if (axes_[i].name.empty()) axes_[i].name = list[i];
      const auto object = hdf5_object_at(*file_, volume_.parent + "/" + list[i]);
      if (!object) return tl::unexpected(object.error());
      if (*object) add_positions(i, **object);
    }
    return {};
  }

  /// Adds the positions along an axis; CF's attributes identify the axis.
  void add_positions(size_t i, const Hdf5Object& object) {
    name_by_positions(axes_[i], Hdf5Attributes(*file_, object));
    const auto same = [&](const auto& each) { return each.first == i; };
    if (std::none_of(positions_.begin(), positions_.end(), same))
      positions_.emplace_back(i, object);
  }

  Result<void> place(ArrayAxis& axis, const Hdf5Object& object) {
    if (axis.size < 2 || axis.letter == 'c') return {};
    if (axis.letter == 't') {
      return read_hdf5_times(file_, object, hdf5_text(*file_, object, "units"), axis);
    }
    std::vector<uint64_t> sizes;
    const auto positions = hdf5_small_array(file_, object, sizes);
    if (!positions) return tl::unexpected(positions.error());
    if (!*positions || sizes != std::vector{axis.size}) return {};
    return place_by_positions(axis, **positions, Hdf5Attributes(*file_, object), file_->path(),
                              notes_);
  }

  void read_sizes() {
    const auto sizes = hdf5_numbers(*file_, volume_.object, "element_size_um");
    if (!sizes) return;
    std::vector<ArrayAxis*> picked;
    for (ArrayAxis& axis : axes_) {
      if (sizes->size() == axes_.size() || axis.size > 1) picked.push_back(&axis);
    }
    if (sizes->size() != picked.size()) return;
    constexpr double kMillimetres = 1e-3;
    for (size_t i = 0; i < picked.size(); ++i) {
      if ((*sizes)[i] > 0) picked[i]->step = (*sizes)[i] * kMillimetres;
    }
  }

  const std::shared_ptr<Hdf5File>& file_;
  const Hdf5Volume& volume_;
  std::vector<ArrayAxis>& axes_;
  std::vector<std::string>& notes_;
  std::vector<std::pair<size_t, Hdf5Object>> positions_;  ///< by axis, at most one of each
};

}  // namespace

Result<bool> describe_by_attributes(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                                    ArrayDescription& description) {
  if (auto read = Reader(file, volume, description).read(); !read) {
    return tl::unexpected(read.error());
  }
  return true;
}

}  // namespace isosplat::import
