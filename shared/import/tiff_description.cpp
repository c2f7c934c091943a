#include <fmt/format.h>

#include <cmath>

#include "shared/import/header_text.h"
#include "shared/import/tiff_pages.h"

// Parses the descriptions that ImageJ and OME programs write into the first page of a stack.
namespace isosplat {
namespace {

/// The value of a line `name=…`.
std::optional<std::string_view> line_value(std::string_view text, std::string_view name) {
  for (size_t at = 0; (at = text.find(name, at)) != text.npos; at += name.size()) {
    const bool begins = at == 0 || text[at - 1] == '\n';
    const size_t equals = at + name.size();
    if (!begins || equals >= text.size() || text[equals] != '=') continue;
    const size_t end = std::min(text.find('\n', equals), text.size());
    return trimmed(text.substr(equals + 1, end - equals - 1));
  }
  return std::nullopt;
}

/// The value of an attribute name="…" or name='…' in an XML element.
std::optional<std::string_view> attribute(std::string_view element, const std::string& name) {
  for (const char* before : {" ", "\n", "\t"}) {
    for (const char quote : {'"', '\''}) {
      const std::string key = before + name + '=' + quote;
      const size_t at = element.find(key);
      if (at == element.npos) continue;
      const size_t begin = at + key.size(), end = element.find(quote, begin);
      if (end != element.npos) return element.substr(begin, end - begin);
    }
  }
  return std::nullopt;
}

/// Checks that the TiffData elements, which map pages to slices and times, give the order of
/// DimensionOrder. Errors: unsupported_format.
Result<void> check_page_order(const std::filesystem::path& path, std::string_view text,
                              const TiffDescription& d) {
  constexpr std::string_view kName = "<TiffData";
  for (size_t at = text.find(kName); at != text.npos; at = text.find(kName, at + 1)) {
    const std::string_view element = text.substr(at, text.find('>', at) - at);
    const auto number = [&](const char* name) {
      return whole_number(attribute(element, name).value_or("0")).value_or(-1);
    };
    const auto slices = static_cast<int64_t>(d.slices), frames = static_cast<int64_t>(d.frames);
    const int64_t page = d.frames_before_slices ? number("FirstZ") * frames + number("FirstT")
                                                : number("FirstT") * slices + number("FirstZ");
    if (number("IFD") == page) continue;
    return fail(Status::unsupported_format,
                fmt::format("{}: expected pages in the order of its DimensionOrder, found page {} "
                            "in the place of page {} (TiffData): save it again as OME-TIFF",
                            path.string(), number("IFD"), page));
  }
  return {};
}

/// Reads ImageJ's calibration function of values ("cf"): 0 is a straight line with the coefficients
/// c0 and c1; the others are curves, which are not applied. Errors: malformed_volume.
Result<void> read_calibration(const std::filesystem::path& path, std::string_view text,
                              TiffDescription& d) {
  const auto function = line_value(text, "cf");
  if (!function || function == "20") return {};  // 20: none
  if (function != "0") {
    d.notes.push_back(
        fmt::format("ImageJ's calibration of values (function {}) is not a straight line: it is "
                    "not applied, the values are those stored",
                    *function));
    return {};
  }
  const auto c0 = number_in(line_value(text, "c0").value_or(""));
  const auto c1 = number_in(line_value(text, "c1").value_or(""));
  if (!c0 || !c1 || !std::isfinite(*c0) || !std::isfinite(*c1) || *c1 == 0) {
    return fail(Status::malformed_volume,
                path.string() +
                    ": expected numbers c0 and c1, c1 not 0, of the calibration of values in its "
                    "ImageJ description");
  }
  d.intercept = *c0;
  d.slope = *c1;
  return {};
}

Result<TiffDescription> parse_ome(const std::filesystem::path& path, std::string_view text) {
  TiffDescription d;
  const size_t begin = text.find("<Pixels");
  if (begin == text.npos) return d;
  if (text.find("<Pixels", begin + 1) != text.npos) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected an OME-TIFF with one image, found several: save one of "
                            "them as a separate file",
                            path.string()));
  }
  const std::string_view pixels = text.substr(begin, text.find('>', begin) - begin);
  const auto count = [&](const char* name) -> uint64_t {
    const auto value = whole_number(attribute(pixels, name).value_or("1"));
    return value && *value > 0 && *value < int64_t{1} << 20 ? static_cast<uint64_t>(*value) : 0;
  };
  d.slices = count("SizeZ");
  d.channels = count("SizeC");
  d.frames = count("SizeT");
  if (d.slices == 0 || d.channels == 0 || d.frames == 0) {
    return fail(Status::malformed_volume,
                path.string() + ": expected SizeZ, SizeC and SizeT above 0 in its OME description");
  }
  d.images = d.slices * d.channels * d.frames;
  const std::string_view order = attribute(pixels, "DimensionOrder").value_or("XYZCT");
  d.frames_before_slices = order.find('T') < order.find('Z');
  const auto size = [&](const char* name) {
    return number_in(attribute(pixels, name).value_or("")).value_or(0);
  };
  const Vec3d voxel{size("PhysicalSizeX"), size("PhysicalSizeY"), size("PhysicalSizeZ")};
  if (voxel.x > 0 && voxel.y > 0 && voxel.z > 0) d.voxel = voxel;
  d.units = {std::string(attribute(pixels, "PhysicalSizeXUnit").value_or("um")),
             std::string(attribute(pixels, "PhysicalSizeYUnit").value_or("um")),
             std::string(attribute(pixels, "PhysicalSizeZUnit").value_or("um"))};
  d.width = whole_number(attribute(pixels, "SizeX").value_or(""));
  d.height = whole_number(attribute(pixels, "SizeY").value_or(""));
  if (d.channels > 1) return d;
  if (auto fine = check_page_order(path, text.substr(begin), d); !fine) {
    return tl::unexpected(fine.error());
  }
  return d;
}

}  // namespace

Result<TiffDescription> parse_tiff_description(const std::filesystem::path& path,
                                               std::string_view text) {
  if (text.find("<OME") != text.npos) return parse_ome(path, text);
  TiffDescription d;
  if (!text.starts_with("ImageJ=")) return d;
  d.is_imagej = true;
  const auto count = [&](const char* name) -> std::optional<uint64_t> {
    const auto value = line_value(text, name);
    if (!value) return std::nullopt;
    const auto number = whole_number(*value);
    return number && *number > 0 && *number < int64_t{1} << 20 ? static_cast<uint64_t>(*number) : 0;
  };
  d.images = count("images");
  d.channels = count("channels").value_or(1);
  d.frames = count("frames").value_or(1);
  const auto slices = count("slices");
  const uint64_t others = d.channels * d.frames;
  d.slices = slices ? *slices : others > 0 ? d.images.value_or(1) / others : 0;
  if (d.channels == 0 || d.frames == 0 || d.slices == 0) {
    return fail(Status::malformed_volume,
                path.string() + ": expected numbers above 0 in its ImageJ description");
  }
  if (d.images && *d.images != d.channels * d.slices * d.frames) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected channels × slices × frames = images in its ImageJ "
                            "description, found {} × {} × {} and {}",
                            path.string(), d.channels, d.slices, d.frames, *d.images));
  }
  const std::string unit(line_value(text, "unit").value_or(""));
  d.units = {unit, std::string(line_value(text, "yunit").value_or(unit)),
             std::string(line_value(text, "zunit").value_or(unit))};
  if (auto fine = read_calibration(path, text, d); !fine) return tl::unexpected(fine.error());
  const auto spacing = number_in(line_value(text, "spacing").value_or(""));
  if (spacing && *spacing != 0 && std::isfinite(*spacing)) d.between_slices = std::abs(*spacing);
  return d;
}

}  // namespace isosplat
