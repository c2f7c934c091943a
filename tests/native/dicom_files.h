#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "shared/core/grid/grid.h"
#include "tests/native/import_checks.h"

// Writes DICOM files element by element, according to PS3.5 and PS3.10. Series of slices sample a
// field that is known at every position, so tests can check each voxel.
namespace isosplat::test {

/// An element's value in little-endian encoding.
struct DicomValue {
  std::string vr;
  std::string bytes;
  size_t unit = 1;  ///< size of the units whose bytes big-endian files swap
  std::vector<std::map<uint32_t, DicomValue>> items;  ///< VR SQ
};

using DicomItem = std::map<uint32_t, DicomValue>;

inline DicomValue dicom_text(std::string vr, std::string text) {
  if (text.size() % 2) text += vr == "UI" ? '\0' : ' ';
  return {std::move(vr), std::move(text), 1, {}};
}

template <class T>
DicomValue dicom_numbers(std::string vr, const std::vector<T>& numbers) {
  return {std::move(vr), bytes_of(numbers), sizeof(T), {}};
}

inline DicomValue dicom_u16(uint16_t number) {
  return dicom_numbers("US", std::vector<uint16_t>{number});
}

inline DicomValue dicom_sequence(std::vector<DicomItem> items) {
  return {"SQ", "", 1, std::move(items)};
}

inline std::string dicom_decimals(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) text += fmt::format("{}{}", text.empty() ? "" : "\\", number);
  return text;
}

/// The encoding of a file.
struct DicomSyntax {
  std::string uid = "1.2.840.10008.1.2.1";
  bool is_explicit = true;
  bool big_endian = false;
  bool deflated = false;
  bool undefined_lengths = false;  ///< of sequences and items
  bool has_prefix = true;
};

inline constexpr const char* kExplicitLittle = "1.2.840.10008.1.2.1";

inline DicomSyntax implicit_little() {
  return {"1.2.840.10008.1.2", false, false, false, false, true};
}
inline DicomSyntax explicit_big() {
  return {"1.2.840.10008.1.2.2", true, true, false, false, true};
}
inline DicomSyntax deflated_little() {
  return {"1.2.840.10008.1.2.1.99", true, false, true, false, true};
}

/// Writes data sets with one encoding.
class DicomWriter {
 public:
  explicit DicomWriter(DicomSyntax syntax) : syntax_(std::move(syntax)) {}

  std::string file(const DicomItem& data) const {
    std::string set = item(data);
    if (syntax_.deflated) set = test::deflated(set, -15);
    if (!syntax_.has_prefix) return set;
    const DicomWriter plain{DicomSyntax{}};
    const std::string meta = plain.item({{0x00020001, {"OB", std::string("\0\1", 2), 1, {}}},
                                         {0x00020010, dicom_text("UI", syntax_.uid)}});
    const auto length = dicom_numbers("UL", std::vector{static_cast<uint32_t>(meta.size())});
    return std::string(128, '\0') + "DICM" + plain.element(0x00020000, length) + meta + set;
  }

  std::string item(const DicomItem& data) const {
    std::string out;
    for (const auto& [tag, value] : data) out += element(tag, value);
    return out;
  }

 private:
  std::string number(uint32_t value, size_t bytes) const {
    std::string out(reinterpret_cast<const char*>(&value), bytes);
    if (syntax_.big_endian) std::reverse(out.begin(), out.end());
    return out;
  }

  std::string tag_bytes(uint32_t tag) const {
    return number(tag >> 16, 2) + number(tag & 0xffff, 2);
  }

  std::string element(uint32_t tag, const DicomValue& value) const {
    std::string bytes = value.bytes;
    if (syntax_.big_endian) {
      for (size_t i = 0; i + value.unit <= bytes.size(); i += value.unit) {
        std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                     bytes.begin() + static_cast<std::ptrdiff_t>(i + value.unit));
      }
    }
    auto length = static_cast<uint32_t>(bytes.size());
    if (value.vr == "SQ") {
      for (const DicomItem& one : value.items) {
        const std::string inside = item(one);
        bytes += tag_bytes(0xfffee000);
        bytes += syntax_.undefined_lengths ? number(0xffffffff, 4)
                                           : number(static_cast<uint32_t>(inside.size()), 4);
        bytes += inside;
        if (syntax_.undefined_lengths) bytes += tag_bytes(0xfffee00d) + number(0, 4);
      }
      length = static_cast<uint32_t>(bytes.size());
      if (syntax_.undefined_lengths) {
        bytes += tag_bytes(0xfffee0dd) + number(0, 4);
        length = 0xffffffff;
      }
    }
    const bool is_encapsulated = value.vr == "fragments";
    if (is_encapsulated) length = 0xffffffff;
    std::string head = tag_bytes(tag);
    if (!syntax_.is_explicit) return head + number(length, 4) + bytes;
    const std::string vr = is_encapsulated ? "OB" : value.vr;
    const bool is_long = vr == "OB" || vr == "OW" || vr == "OF" || vr == "OD" || vr == "SQ" ||
                         vr == "UN" || vr == "UT";
    head += vr;
    head += is_long ? std::string(2, '\0') + number(length, 4) : number(length, 2);
    return head + bytes;
  }

  DicomSyntax syntax_;
};

/// Encapsulated pixels: an offset table, which may be empty, and the fragments.
inline DicomValue dicom_fragments(const std::vector<std::string>& fragments,
                                  const std::vector<uint32_t>& offsets = {}) {
  const auto item = [](const std::string& bytes) {
    const auto length = static_cast<uint32_t>(bytes.size());
    return std::string("\xfe\xff\x00\xe0", 4) +
           std::string(reinterpret_cast<const char*>(&length), 4) + bytes;
  };
  std::string all = item(bytes_of(offsets));
  for (std::string fragment : fragments) {
    if (fragment.size() % 2) fragment += '\0';
    all += item(fragment);
  }
  return {"fragments", all + std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8), 1, {}};
}

/// Pixels of 1 bit: the lowest bit of a byte is the first pixel, without gaps between frames.
inline DicomValue dicom_bits(const std::vector<uint8_t>& pixels) {
  std::string bytes((pixels.size() + 15) / 16 * 2, '\0');
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i]) bytes[i / 8] = static_cast<char>(bytes[i / 8] | 1 << (i % 8));
  }
  return {"OB", bytes, 1, {}};
}

/// A field of three balls away from the centre. Values are up to 3000 inside of a ball, decrease
/// towards its edge, and are 0 outside. No rotation, reflection or shift maps the field to itself.
inline double three_balls(Vec3d p) {
  struct Ball {
    Vec3d centre;
    double radius, height;
  };
  constexpr Ball kBalls[] = {{{-4, -3, 2}, 7, 1000}, {{5, 2, -4}, 6, 2000}, {{1, 6, 6}, 5, 3000}};
  double value = 0;
  for (const Ball& ball : kBalls) {
    value = std::max(value, ball.height * (1 - length(p - ball.centre) / ball.radius));
  }
  return value;
}

/// A stack of slices through three_balls, and its files.
struct BallSeries {
  Index3 size{20, 17, 12};
  Vec3d row{1, 0, 0}, column{0, 1, 0};
  Vec3d spacing{1.25, 1.5, 2};
  Vec3d step{0, 0, 0};  ///< from slice to slice; zeros: along the normal by spacing.z
  Vec3d centre{0, 0, 0};
  std::string uid = "1.2.3.4";
  std::string modality = "CT";
  double slope = 1, intercept = 0;
  bool is_signed = false;
  uint16_t stored = 12;
  double add = 0;  ///< added to every value
  int first_instance = 1;
  DicomSyntax syntax;

  Vec3d slice_step() const { return length(step) > 0 ? step : cross(row, column) * spacing.z; }

  Vec3d position(int z) const {
    return centre - row * (spacing.x * (size.x - 1) / 2) - column * (spacing.y * (size.y - 1) / 2) +
           slice_step() * (z - (size.z - 1) / 2.0);
  }

  double value(Vec3d world) const { return three_balls(world) + add; }

  std::vector<uint16_t> pixels(int z) const {
    std::vector<uint16_t> pixels;
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const Vec3d world = position(z) + row * (spacing.x * x) + column * (spacing.y * y);
        const double stored_value = std::round((value(world) - intercept) / slope);
        pixels.push_back(static_cast<uint16_t>(static_cast<int>(stored_value)));
      }
    }
    return pixels;
  }

  /// Elements that every image of the series has.
  DicomItem common() const {
    DicomItem data;
    data[0x00080016] = dicom_text("UI", "1.2.840.10008.5.1.4.1.1.2");
    data[0x00080060] = dicom_text("CS", modality);
    data[0x0020000d] = dicom_text("UI", "1.2.3");
    data[0x0020000e] = dicom_text("UI", uid);
    data[0x00280002] = dicom_u16(1);
    data[0x00280004] = dicom_text("CS", "MONOCHROME2");
    data[0x00280010] = dicom_u16(static_cast<uint16_t>(size.y));
    data[0x00280011] = dicom_u16(static_cast<uint16_t>(size.x));
    data[0x00280100] = dicom_u16(16);
    data[0x00280101] = dicom_u16(stored);
    data[0x00280102] = dicom_u16(static_cast<uint16_t>(stored - 1));
    data[0x00280103] = dicom_u16(is_signed ? 1 : 0);
    return data;
  }

  DicomValue position_value(int z) const {
    const Vec3d p = position(z);
    return dicom_text("DS", dicom_decimals({p.x, p.y, p.z}));
  }
  DicomValue orientation_value() const {
    return dicom_text("DS", dicom_decimals({row.x, row.y, row.z, column.x, column.y, column.z}));
  }
  DicomValue pixel_spacing_value() const {
    return dicom_text("DS", dicom_decimals({spacing.y, spacing.x}));
  }

  /// The elements of a single-frame file.
  DicomItem slice(int z) const {
    DicomItem data = common();
    data[0x00080018] = dicom_text("UI", fmt::format("{}.{}", uid, first_instance + z));
    data[0x00200013] = dicom_text("IS", std::to_string(first_instance + z));
    data[0x00200032] = position_value(z);
    data[0x00200037] = orientation_value();
    data[0x00280030] = pixel_spacing_value();
    if (slope != 1 || intercept != 0) {
      data[0x00281052] = dicom_text("DS", fmt::format("{}", intercept));
      data[0x00281053] = dicom_text("DS", fmt::format("{}", slope));
    }
    data[0x7fe00010] = dicom_numbers("OW", pixels(z));
    return data;
  }

  std::string file_name(int z) const {
    // File names are not in the order of the slices.
    return fmt::format("{}_{:04}.dcm", uid, (7919 * (first_instance + z)) % 9973);
  }

  void write(const TempFolder& folder) const {
    for (int z = 0; z < size.z; ++z) write_slice(folder, z, slice(z));
  }

  void write_slice(const TempFolder& folder, int z, const DicomItem& data) const {
    write_file(folder / file_name(z), DicomWriter(syntax).file(data));
  }

  /// The elements of one file with functional groups, as in Enhanced CT, with a frame for each of
  /// `order`. The caller may change them.
  DicomItem enhanced(const std::vector<int>& order) const {
    DicomItem data = common();
    data[0x00080016] = dicom_text("UI", "1.2.840.10008.5.1.4.1.1.2.1");
    data[0x00280008] = dicom_text("IS", std::to_string(order.size()));
    DicomItem measures{{0x00280030, pixel_spacing_value()}};
    DicomItem transformation{{0x00281052, dicom_text("DS", fmt::format("{}", intercept))},
                             {0x00281053, dicom_text("DS", fmt::format("{}", slope))}};
    data[0x52009229] =
        dicom_sequence({{{0x00209116, dicom_sequence({{{0x00200037, orientation_value()}}})},
                         {0x00289110, dicom_sequence({measures})},
                         {0x00289145, dicom_sequence({transformation})}}});
    std::vector<DicomItem> frames;
    std::vector<uint16_t> all;
    for (const int z : order) {
      frames.push_back({{0x00209113, dicom_sequence({{{0x00200032, position_value(z)}}})}});
      const auto some = pixels(z);
      all.insert(all.end(), some.begin(), some.end());
    }
    data[0x52009230] = dicom_sequence(std::move(frames));
    data[0x7fe00010] = dicom_numbers("OW", all);
    return data;
  }
};

/// Expects that every voxel has the value of the series' field at its world position.
inline void expect_field(import::OpenVolume& volume, const BallSeries& series,
                         double tolerance = 1) {
  ASSERT_TRUE(volume.source);
  const VolumeGrid& grid = volume.source->header().grid;
  EXPECT_EQ(grid.voxels.x, series.size.x);
  EXPECT_EQ(grid.voxels.y, series.size.y);
  const std::vector<double> values = read_all(*volume.source);
  double worst = 0, greatest = 0;
  size_t i = 0;
  for (int z = 0; z < grid.voxels.z; ++z) {
    for (int y = 0; y < grid.voxels.y; ++y) {
      for (int x = 0; x < grid.voxels.x; ++x, ++i) {
        const Vec3d world = grid.world({double(x), double(y), double(z)});
        worst = std::max(worst, std::abs(values[i] - series.value(world)));
        greatest = std::max(greatest, series.value(world));
      }
    }
  }
  EXPECT_LE(worst, tolerance);
  EXPECT_GT(greatest, 1000) << "the volume does not contain the balls";
}

inline import::ImportOptions allowing(import::Allowance allowance) {
  import::ImportOptions options;
  options.allowed.add(allowance);
  return options;
}

/// Expects that opening fails with a message that contains all of `texts`.
inline void expect_open_error(const std::filesystem::path& path,
                              const std::vector<std::string>& texts,
                              const import::ImportOptions& options = {}) {
  const auto volume = import::open_volume(path, options);
  ASSERT_FALSE(volume) << "expected an error that contains \"" << texts[0] << "\"";
  for (const std::string& text : texts) {
    EXPECT_NE(volume.error().message.find(text), std::string::npos) << volume.error().message;
  }
}

}  // namespace isosplat::test
