#include "shared/import/mrc/header.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>

#include "shared/import/geometry/conventions.h"
#include "shared/import/mrc/mrc.h"

// MRC2014 (Cheng et al., "MRC2014: Extensions to the MRC format header for electron
// cryo-microscopy and tomography", J. Struct. Biol. 192, 2015), with IMOD's flags. Numbers are i32
// and f32.
//
// NX, NY, NZ              0    3 × i32      ISPG                 88   i32
// MODE                    12   i32          NSYMBT               92   i32
// NXSTART, …              16   3 × i32      NVERSION             108  i32
// MX, MY, MZ              28   3 × i32      IMOD's stamp         152  i32
// CELLA (lengths)         40   3 × f32      IMOD's flags         156  i32
// CELLB (angles)          52   3 × f32      ORIGIN               196  3 × f32
// MAPC, MAPR, MAPS        64   3 × i32      "MAP "               208  4 bytes
// DMIN, DMAX, DMEAN       76   3 × f32      MACHST               212  4 bytes
//
// CCP4 has LSKFLG (96, i32), SKWMAT (100, 9 × f32) and SKWTRN (136, 3 × f32) in fields that MRC2014
// leaves to others: map = SKWMAT · (atoms - SKWTRN).
namespace isosplat::import {
namespace {

constexpr int32_t kImodStamp = 1146047817;  // "IMOD"
constexpr int32_t kOriginHasItsSign =
    4;  // IMOD's flag for an origin with the sign that MRC2014 defines
constexpr double kMillimetresPerAngstrom = 1e-7;

class Numbers {
 public:
  Numbers(std::span<const std::byte> bytes, bool big_endian)
      : bytes_(bytes), swap_(big_endian != (std::endian::native == std::endian::big)) {}

  int32_t whole(size_t offset) const { return static_cast<int32_t>(word(offset)); }
  double real(size_t offset) const {
    const uint32_t bits = word(offset);
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return static_cast<double>(value);
  }
  std::array<int32_t, 3> wholes(size_t offset) const {
    return {whole(offset), whole(offset + 4), whole(offset + 8)};
  }
  std::array<double, 3> reals(size_t offset) const {
    return {real(offset), real(offset + 4), real(offset + 8)};
  }

 private:
  uint32_t word(size_t offset) const {
    uint32_t value;
    std::memcpy(&value, bytes_.data() + offset, sizeof value);
    return swap_ ? __builtin_bswap32(value) : value;
  }

  std::span<const std::byte> bytes_;
  bool swap_;
};

Vec3d to_vector(const std::array<double, 3>& numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

bool is_mode(int32_t mode) {
  return (mode >= 0 && mode <= 4) || mode == 6 || mode == 12 || mode == 16 || mode == 101;
}

/// Whether the numbers are plausible. Read in the wrong byte order, they are very large.
bool makes_sense(const Numbers& n) {
  const auto axes = n.wholes(64);
  return is_mode(n.whole(12)) &&
         std::all_of(axes.begin(), axes.end(), [](int32_t axis) { return axis >= 0 && axis <= 3; });
}

/// Whether the CCP4 fields, which MRC2014 leaves to other programs, have a rotation or shift that
/// is not the identity.
bool has_skew(const Numbers& n) {
  if (n.whole(96) != 1) return false;
  const Vec3d a = to_vector(n.reals(100)), b = to_vector(n.reals(112)), c = to_vector(n.reals(124));
  const bool is_rotation = std::abs(dot(a, cross(b, c)) - 1) < 0.01 &&
                           std::abs(length(a) - 1) < 0.01 && std::abs(length(b) - 1) < 0.01;
  const bool is_identity = std::abs(a.x - 1) < 1e-5 && std::abs(b.y - 1) < 1e-5;
  return is_rotation && !(is_identity && n.reals(136) == std::array{0.0, 0.0, 0.0});
}

/// The byte order of the machine stamp; nothing if it has neither of the two defined values.
std::optional<bool> stamped_big_endian(std::span<const std::byte> bytes) {
  if (bytes[212] == std::byte{0x44}) return false;
  if (bytes[212] == std::byte{0x11}) return true;
  return std::nullopt;
}

/// The axes of the cell by file axis, from 0. Errors: malformed_volume.
Result<std::array<size_t, 3>> axes_of_file(const std::filesystem::path& path, const MrcHeader& h,
                                           std::vector<std::string>& notes) {
  const auto [c, r, s] = h.axis_of;
  if (c == 0 && r == 0 && s == 0) {
    notes.push_back(
        "the header does not say which axes its columns, rows and sections are: x, y and z are "
        "assumed");
    return std::array<size_t, 3>{0, 1, 2};
  }
  std::array<int32_t, 3> sorted = h.axis_of;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != std::array{1, 2, 3}) {
    return malformed_mrc(path, fmt::format("expected its columns, rows and sections (MAPC, MAPR, "
                                           "MAPS) to be axes 1, 2 and 3, found {}, {} and {}",
                                           c, r, s));
  }
  return std::array{static_cast<size_t>(c - 1), static_cast<size_t>(r - 1),
                    static_cast<size_t>(s - 1)};
}

/// The position of the first voxel, in the unit of the steps. Most programs use ORIGIN if it is
/// set, else the start of the grid.
Vec3d first_voxel(const MrcHeader& h, const std::array<Vec3d, 3>& steps, bool has_cell,
                  std::vector<std::string>& notes) {
  Vec3d by_start{0, 0, 0};
  for (size_t i = 0; i < 3; ++i) by_start = by_start + steps[i] * static_cast<double>(h.start[i]);
  const double sign = h.is_imod && (h.imod_flags & kOriginHasItsSign) == 0 ? -1 : 1;
  const Vec3d by_origin = to_vector(h.origin) * sign;
  if (by_origin == Vec3d{0, 0, 0} || !has_cell) return by_start;
  const double step = std::min({length(steps[0]), length(steps[1]), length(steps[2])});
  if (by_start != Vec3d{0, 0, 0} && length(by_start - by_origin) > 0.01 * step) {
    notes.push_back(
        "the header has two positions of the first voxel that differ (ORIGIN and NXSTART, NYSTART, "
        "NZSTART): ORIGIN is used");
  }
  return by_origin;
}

}  // namespace

tl::unexpected<Error> malformed_mrc(const std::filesystem::path& path, const std::string& what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the MRC header is damaged; export the volume again",
                          path.string(), what));
}

bool is_mrc(std::string_view beginning, bool by_name) {
  return beginning.size() >= kMrcBytes &&
         parse_mrc(std::as_bytes(std::span(beginning.data(), kMrcBytes)), by_name);
}

std::optional<MrcHeader> parse_mrc(std::span<const std::byte> bytes, bool by_name) {
  const bool has_text = std::memcmp(bytes.data() + 208, "MAP", 3) == 0;
  if (!has_text && !by_name) return std::nullopt;
  const auto stamp = stamped_big_endian(bytes);
  const bool likely = stamp.value_or(false);
  bool big_endian = likely;
  if (!makes_sense(Numbers(bytes, likely))) big_endian = !likely;
  const Numbers n(bytes, big_endian);
  if (!makes_sense(n)) return std::nullopt;
  MrcHeader h;
  h.big_endian = big_endian;
  h.has_map_text = has_text;
  h.is_stamp_right = stamp == big_endian;
  h.size = n.wholes(0);
  if (!has_text && *std::min_element(h.size.begin(), h.size.end()) < 1) return std::nullopt;
  h.mode = n.whole(12);
  h.start = n.wholes(16);
  h.sampling = n.wholes(28);
  h.cell = n.reals(40);
  h.angles = n.reals(52);
  h.axis_of = n.wholes(64);
  h.least = n.real(76);
  h.greatest = n.real(80);
  h.space_group = n.whole(88);
  h.extended_bytes = n.whole(92);
  h.version = n.whole(108);
  h.is_imod = n.whole(152) == kImodStamp;
  h.imod_flags = h.is_imod ? n.whole(156) : 0;
  h.origin = n.reals(196);
  h.has_skew = !h.is_imod && has_skew(n);
  return h;
}

Result<HeaderGeometry> mrc_geometry(const std::filesystem::path& path, const MrcHeader& h,
                                    std::vector<std::string>& notes) {
  const auto axis_of = axes_of_file(path, h, notes);
  if (!axis_of) return tl::unexpected(axis_of.error());
  std::array<double, 3> angles = h.angles;
  if (angles == std::array{0.0, 0.0, 0.0}) {
    notes.push_back("the header has no angles between its axes: right angles are assumed");
    angles = {90, 90, 90};
  }
  const auto axes = cell_axes(angles);
  if (!axes) {
    return malformed_mrc(path, fmt::format("expected the angles of a cell in degrees (CELLB), "
                                           "found {}, {} and {}",
                                           angles[0], angles[1], angles[2]));
  }
  std::array<double, 3> spacing{};
  bool has_cell = true;
  for (size_t i = 0; i < 3; ++i) {
    spacing[i] = h.cell[i] / h.sampling[i];
    has_cell &= h.sampling[i] > 0 && spacing[i] > 0 && std::isfinite(spacing[i]);
  }
  if (!has_cell) {
    notes.push_back("the header has no voxel spacing: 1,1,1 is assumed; --spacing sets another");
    spacing = {1, 1, 1};
  }
  std::array<Vec3d, 3> steps;
  for (size_t i = 0; i < 3; ++i) steps[i] = (*axes)[(*axis_of)[i]] * spacing[(*axis_of)[i]];
  HeaderGeometry geometry = geometry_of_steps(steps, first_voxel(h, steps, has_cell, notes));
  if (has_cell) scale_lengths(kMillimetresPerAngstrom, geometry);
  return geometry;
}

}  // namespace isosplat::import
