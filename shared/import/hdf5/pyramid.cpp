#include "shared/import/hdf5/pyramid.h"

#include <fmt/format.h>

#include <charconv>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/hdf5/array.h"
#include "shared/import/hdf5/attributes.h"
#include "shared/import/hdf5/description.h"
#include "shared/import/text/header_text.h"

// Imaris ("Imaris 5.5 File Format"):
//   /DataSet/ResolutionLevel L/TimePoint T/Channel C   attributes ImageSizeX, Y, Z: voxels;
//                                                      Data is padded to whole chunks
//   /DataSetInfo/Image                                 X, Y, Z; ExtMin0 … ExtMax2: the borders
//                                                      along x, y, z; Unit
// BigDataViewer:
//   /tTTTTT/sSS/L/cells   unsigned numbers in int16, unless the group sSS has "dataType"
//   /sSS/resolutions      a row for each level: voxels of the finest one along x, y, z
//   NAME.xml              beside NAME.h5: the size of voxels
namespace isosplat::import {
namespace {

/// Takes a text and the number that follows it from the beginning of `path`.
std::optional<uint64_t> take(std::string_view& path, std::string_view text) {
  if (!path.starts_with(text)) return std::nullopt;
  path.remove_prefix(text.size());
  uint64_t number = 0;
  const auto [end, error] = std::from_chars(path.data(), path.data() + path.size(), number);
  if (error != std::errc()) return std::nullopt;
  path.remove_prefix(static_cast<size_t>(end - path.data()));
  return number;
}

/// The text between `begin` and `end`, from `at` on; moves `at` behind it. Empty if there is none.
std::string_view between(std::string_view text, std::string_view begin, std::string_view end,
                         size_t& at) {
  const size_t first = text.find(begin, at);
  if (first == text.npos) return {};
  const size_t last = text.find(end, first + begin.size());
  if (last == text.npos) return {};
  at = last + end.size();
  return text.substr(first + begin.size(), last - first - begin.size());
}

struct VoxelSize {
  Vec3d size;
  std::string unit;
};

/// The size of a setup's voxels in BigDataViewer's XML file. `has_transforms`: whether the file
/// also has positions.
std::optional<VoxelSize> size_in_xml(const std::filesystem::path& hdf5, uint64_t setup,
                                     bool& has_transforms) {
  std::filesystem::path xml = hdf5;
  xml.replace_extension(".xml");
  const auto text = read_beginning(xml, size_t{16} << 20);
  if (!text) return std::nullopt;
  has_transforms = text->find("<ViewTransform") != text->npos;
  size_t at = 0;
  for (;;) {
    const std::string_view each = between(*text, "<ViewSetup>", "</ViewSetup>", at);
    if (each.empty()) return std::nullopt;
    size_t inside = 0;
    if (whole_number(trimmed(between(each, "<id>", "</id>", inside))) !=
        static_cast<int64_t>(setup)) {
      continue;
    }
    inside = 0;
    const std::string_view voxel = between(each, "<voxelSize>", "</voxelSize>", inside);
    inside = 0;
    const std::string unit(trimmed(between(voxel, "<unit>", "</unit>", inside)));
    inside = 0;
    const auto size = numbers_in(between(voxel, "<size>", "</size>", inside));
    if (!size || size->size() != 3) return std::nullopt;
    return VoxelSize{{(*size)[0], (*size)[1], (*size)[2]}, unit};
  }
}

}  // namespace

std::optional<Hdf5Place> hdf5_place(std::string_view path) {
  std::string_view rest = path;
  if (const auto time = take(rest, "/t")) {
    const auto setup = take(rest, "/s");
    const auto level = setup ? take(rest, "/") : std::nullopt;
    if (level && rest == "/cells") return Hdf5Place{*level, *time, *setup, false};
    return std::nullopt;
  }
  rest = path.substr(std::min(path.find("/ResolutionLevel "), path.size()));
  const auto level = take(rest, "/ResolutionLevel ");
  const auto time = level ? take(rest, "/TimePoint ") : std::nullopt;
  const auto channel = time ? take(rest, "/Channel ") : std::nullopt;
  if (channel && rest == "/Data") return Hdf5Place{*level, *time, *channel, true};
  return std::nullopt;
}

std::string hdf5_channel_name(Hdf5File& file, uint64_t channel, bool is_imaris) {
  const std::string path =
      is_imaris ? fmt::format("DataSetInfo/Channel {}", channel) : fmt::format("s{:02}", channel);
  const auto object = hdf5_object_at(file, path);
  if (!object || !*object) return {};
  const std::string name = hdf5_text(file, **object, is_imaris ? "Name" : "name");
  return name.empty() ? "" : fmt::format(" ({})", printable(name));
}

Result<bool> describe_imaris(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                             ArrayDescription& description) {
  const auto place = hdf5_place(volume.path);
  if (!place || !place->is_imaris || description.axes.size() != 3) return false;
  const auto channel = hdf5_object_at(*file, volume.parent);
  if (!channel) return tl::unexpected(channel.error());
  const auto root = hdf5_object_at(*file, "");
  if (!root) return tl::unexpected(root.error());
  std::string folder = *root ? hdf5_text(*file, **root, "DataSetInfoDirectoryName") : "";
  if (folder.empty()) folder = "DataSetInfo";
  const auto image = hdf5_object_at(*file, folder + "/Image");
  if (!image) return tl::unexpected(image.error());
  const auto number = [&](const std::optional<Hdf5Object>& object, const std::string& name) {
    return object ? number_in(trimmed(hdf5_text(*file, *object, name))) : std::nullopt;
  };
  const std::string unit = *image ? hdf5_text(*file, **image, "Unit") : "";
  const double millimetres =
      axis_millimetres(unit.empty() ? "um" : unit, "the image", description.notes);
  for (size_t i = 0; i < 3; ++i) {
    ArrayAxis& axis = description.axes[2 - i];
    const std::string letter(1, "XYZ"[i]);
    axis.letter = "xyz"[i];
    auto size = number(*channel, "ImageSize" + letter);
    if (!size && place->level == 0) size = number(*image, letter);
    if (!size) {
      description.notes.push_back(
          fmt::format("the Imaris file does not state the image's size along {}: voxels at its end "
                      "may be padding",
                      axis.letter));
    } else if (*size < 1 || *size > static_cast<double>(axis.size)) {
      return file->malformed(
          fmt::format("expected an image of at most {} voxels along {}, found {}", axis.size,
                      axis.letter, *size));
    } else {
      axis.size = static_cast<uint64_t>(*size);
    }
    const auto least = number(*image, fmt::format("ExtMin{}", i));
    const auto most = number(*image, fmt::format("ExtMax{}", i));
    if (!least || !most || *most == *least) continue;
    axis.step = (*most - *least) / static_cast<double>(axis.size) * millimetres;
    axis.first =
        *least * millimetres + *axis.step / 2;  // the borders are the outer faces of voxels
  }
  description.knows_axes = true;
  return true;
}

Result<bool> describe_big_data_viewer(const std::shared_ptr<Hdf5File>& file,
                                      const Hdf5Volume& volume, ArrayDescription& description) {
  const auto place = hdf5_place(volume.path);
  if (!place || place->is_imaris || description.axes.size() != 3) return false;
  const std::string setup = fmt::format("s{:02}", place->channel);
  const auto group = hdf5_object_at(*file, setup);
  if (!group) return tl::unexpected(group.error());
  const auto resolutions = hdf5_object_at(*file, setup + "/resolutions");
  if (!resolutions) return tl::unexpected(resolutions.error());
  Vec3d factor{1, 1, 1};
  if (*resolutions) {
    std::vector<uint64_t> sizes;
    const auto rows = hdf5_small_array(file, **resolutions, sizes);
    if (!rows) return tl::unexpected(rows.error());
    if (*rows && sizes.size() == 2 && sizes[1] == 3 && place->level < sizes[0]) {
      const double* row = (*rows)->data() + 3 * place->level;
      factor = {row[0], row[1], row[2]};
    }
  }
  const std::string type = *group ? lower_case(hdf5_text(*file, **group, "dataType")) : "";
  description.is_unsigned =
      volume.type.stored.type == VoxelType::i16 && (type.empty() || type == "uint16");
  bool has_transforms = false;
  const auto size = size_in_xml(file->path(), place->channel, has_transforms);
  double millimetres = 1;
  if (size) {
    millimetres = axis_millimetres(size->unit, "BigDataViewer's XML file", description.notes);
  } else {
    description.notes.push_back(
        "BigDataViewer keeps the size of voxels in an XML file, which is not beside this one");
  }
  if (has_transforms) {
    description.notes.push_back(
        "the positions of images in BigDataViewer's XML file (ViewRegistrations) are not applied");
  }
  const double factors[] = {factor.x, factor.y, factor.z};
  for (size_t i = 0; i < 3; ++i) {
    ArrayAxis& axis = description.axes[2 - i];
    axis.letter = "xyz"[i];
    if (!size) continue;
    const double fine = (i == 0   ? size->size.x
                         : i == 1 ? size->size.y
                                  : size->size.z) *
                        millimetres;
    axis.step = fine * factors[i];
    axis.first = (*axis.step - fine) / 2;
  }
  description.knows_axes = true;
  return true;
}

}  // namespace isosplat::import
