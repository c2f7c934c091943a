#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/text/header_text.h"
#include "shared/import/text/xml_scanner.h"
#include "shared/import/tiff/series.h"

// Reads OME-XML (OME-TIFF specification, schema 2016-06 and earlier ones): the images of one or
// several files, and the assignment of pages to planes.
namespace isosplat::import {
namespace {

constexpr size_t kMaxBlocks = size_t{1} << 20, kMaxImages = 10000;
constexpr uint64_t kMaxPlanes = uint64_t{1} << 24;
constexpr size_t kMaxText = size_t{64} << 20;

/// The colour of a channel: its bytes are red, green, blue and alpha, as a signed number.
std::optional<std::array<float, 3>> colour_of(const XmlTag& channel) {
  const auto text = channel.attribute("Color");
  const auto number = text ? whole_number(trimmed(*text)) : std::nullopt;
  if (!number || *number < INT32_MIN || *number > UINT32_MAX) return std::nullopt;
  const auto rgba = static_cast<uint32_t>(*number);
  const auto part = [&](int shift) { return static_cast<float>(rgba >> shift & 255) / 255; };
  return std::array{part(24), part(16), part(8)};
}

/// Parses one text. Each function takes a tag.
class OmeParser {
 public:
  OmeParser(const std::filesystem::path& path, std::string_view text) : path_(path), xml_(text) {}

  std::string companion;  ///< the file that has the sizes instead of this one
  std::string uuid;       ///< of the file; BinaryOnly: of the file that was opened

  Result<std::vector<TiffSeries>> parse() {
    while (const auto tag = xml_.next()) {
      if (auto fine = take(*tag); !fine) return tl::unexpected(fine.error());
    }
    return std::move(images_);
  }

 private:
  tl::unexpected<Error> malformed(const std::string& what) const {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected {} in its OME description", path_.string(), what));
  }

  Result<void> take(const XmlTag& tag) {
    if (tag.name == "OME" && tag.begins) {
      uuid = tag.attribute("UUID").value_or("");
    } else if (tag.name == "BinaryOnly" && tag.begins) {
      companion = tag.attribute("MetadataFile").value_or("");
      uuid = tag.attribute("UUID").value_or(uuid);
    } else if (tag.name == "Image" && tag.begins) {
      name_ = tag.attribute("Name").value_or(tag.attribute("ID").value_or(""));
    } else if (tag.name == "Pixels") {
      if (tag.begins) {
        if (auto fine = begin_image(tag); !fine) return fine;
      }
      if (tag.ends) return end_image();
    } else if (is_inside_) {
      return take_inside(tag);
    } else if (tag.name == "ModuloAlongZ" && tag.begins) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected slices along Z, found planes with a further axis ({}): "
                              "save one volume as a separate file in Fiji (Bio-Formats)",
                              path_.string(), tag.attribute("Type").value_or("unnamed")));
    }
    return {};
  }

  Result<void> begin_image(const XmlTag& tag) {
    if (images_.size() >= kMaxImages) return malformed("up to 10000 images");
    image_ = {};
    image_.name = name_;
    samples_ = 0, colours_ = 1;
    is_inside_ = true;
    const auto count = [&](const char* name) -> uint64_t {
      const auto value = whole_number(trimmed(tag.attribute(name).value_or("1")));
      return value && *value > 0 && *value < int64_t{1} << 20 ? static_cast<uint64_t>(*value) : 0;
    };
    image_.sizes = {count("SizeZ"), count("SizeC"), count("SizeT")};
    const auto& [z, c, t] = image_.sizes;
    if (z == 0 || c == 0 || t == 0 || c > kMaxPlanes / z || t > kMaxPlanes / z / c) {
      return malformed("SizeZ, SizeC and SizeT above 0");
    }
    image_.width = whole_number(tag.attribute("SizeX").value_or(""));
    image_.height = whole_number(tag.attribute("SizeY").value_or(""));
    const std::string order = tag.attribute("DimensionOrder").value_or("XYZCT");
    size_t found = 0;
    for (const char letter : order) {
      const bool is_axis = letter == 'Z' || letter == 'C' || letter == 'T';
      if (!is_axis || found == 3) continue;
      image_.order[found++] = letter == 'Z'   ? TiffAxis::z
                              : letter == 'C' ? TiffAxis::channel
                                              : TiffAxis::time;
    }
    if (found != 3 || image_.order[0] == image_.order[1] || image_.order[1] == image_.order[2] ||
        image_.order[0] == image_.order[2]) {
      return malformed("a DimensionOrder such as XYZCT");
    }
    const char* const sizes[] = {"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto length = number_in(trimmed(tag.attribute(sizes[axis]).value_or("")));
      if (length && *length > 0 && std::isfinite(*length)) image_.lengths[axis] = *length;
      image_.units[axis] = tag.attribute(std::string(sizes[axis]) + "Unit").value_or("um");
    }
    image_.time_distance =
        number_in(trimmed(tag.attribute("TimeIncrement").value_or(""))).value_or(0);
    image_.time_unit = tag.attribute("TimeIncrementUnit").value_or("s");
    return {};
  }

  Result<void> take_inside(const XmlTag& tag) {
    if (tag.name == "Channel" && tag.begins) {
      const auto samples = whole_number(tag.attribute("SamplesPerPixel").value_or("1"));
      colours_ = std::max<uint64_t>(colours_, samples && *samples > 0 && *samples < 65536
                                                  ? static_cast<uint64_t>(*samples)
                                                  : 1);
      samples_++;
      if (image_.channels.size() < 1000) {
        image_.channels.push_back({tag.attribute("Name").value_or(""), colour_of(tag)});
      }
    } else if (tag.name == "TiffData" && tag.begins) {
      if (++blocks_ > kMaxBlocks) return malformed("up to a million TiffData");
      OmePages block;
      bool fine = true;
      const auto number = [&](const char* name, uint64_t otherwise) {
        const auto text = tag.attribute(name);
        if (!text) return otherwise;
        const auto value = whole_number(trimmed(*text));
        if (!value || *value < 0 || *value > int64_t{1} << 32) fine = false;
        return static_cast<uint64_t>(value.value_or(0));
      };
      block.first = {number("FirstZ", 0), number("FirstC", 0), number("FirstT", 0)};
      block.page = number("IFD", 0);
      // If the number of planes is not stated, it is 1 if their page is given, else all planes.
      block.count =
          number("PlaneCount", number("NumPlanes", tag.attribute("IFD") ? 1 : kMaxPlanes));
      if (!fine) return malformed("whole numbers in TiffData");
      image_.ome.push_back(std::move(block));
    } else if (tag.name == "UUID" && tag.begins && !image_.ome.empty()) {
      image_.ome.back().file = file_name(tag.attribute("FileName").value_or(""));
      image_.ome.back().uuid = xml_.content();
    } else if (tag.name == "BinData" && tag.begins) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected pages with voxels, found them in the OME description: "
                              "save it as OME-TIFF",
                              path_.string()));
    }
    return {};
  }

  Result<void> end_image() {
    is_inside_ = false;
    const uint64_t channels = image_.size(TiffAxis::channel);
    if (colours_ > 1) {
      if (channels != colours_ || samples_ > 1) {
        return fail(Status::unsupported_format,
                    fmt::format("{}: expected channels of one number per pixel, found {} channels "
                                "of {}: save one channel as a separate file",
                                path_.string(), samples_, colours_));
      }
      image_.in_samples = TiffAxis::channel;
    }
    image_.pages =
        image_.size(TiffAxis::z) * image_.size(TiffAxis::time) * (image_.in_samples ? 1 : channels);
    image_.counted = true;
    if (image_.ome.empty()) {
      OmePages all;
      all.page = next_page_;
      all.count = image_.pages;
      image_.ome.push_back(all);
    }
    next_page_ += image_.pages;
    images_.push_back(std::move(image_));
    return {};
  }

  /// A name without folders, since the files of an OME-TIFF are in one folder.
  static std::string file_name(const std::string& name) {
    return name.substr(name.find_last_of("/\\") + 1);
  }

  const std::filesystem::path& path_;
  XmlScanner xml_;
  std::vector<TiffSeries> images_;
  TiffSeries image_;
  std::string name_;
  bool is_inside_ = false;
  uint64_t colours_ = 1, samples_ = 0, next_page_ = 0;
  size_t blocks_ = 0;
};

}  // namespace

bool is_ome(std::string_view text) {
  // The root is the first tag.
  const auto root = XmlScanner(text).next();
  return root && root->name == "OME" && text.find('<') < 1024;
}

TiffSeriesList ome_series(const std::filesystem::path& path, std::string_view text) {
  OmeParser parser(path, text);
  auto images = parser.parse();
  if (!images) return images;
  std::string uuid = parser.uuid;
  if (images->empty() && !parser.companion.empty()) {
    const std::string name = parser.companion.substr(parser.companion.find_last_of("/\\") + 1);
    const auto beside = path.parent_path() / name;
    if (input_kind(beside) != InputKind::file) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected the file {} beside it, which says what its pages are: "
                              "put it into the same folder, and give both",
                              path.string(), name));
    }
    const auto other = read_beginning(beside, kMaxText);
    if (!other) return tl::unexpected(other.error());
    OmeParser companion(beside, *other);
    images = companion.parse();
    if (!images) return images;
  }
  if (images->empty()) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected Pixels in its OME description, found none: save it again "
                            "as OME-TIFF",
                            path.string()));
  }
  for (TiffSeries& image : *images) image.ome_uuid = uuid;
  return images;
}

}  // namespace isosplat::import
