#include "shared/import/nifti/header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>

#include "shared/import/geometry/conventions.h"

//               NIfTI-1       NIfTI-2                              NIfTI-1        NIfTI-2
// sizeof_hdr    0    i32      0    i32      qform_code, sform_code 252  2 × i16   344  2 × i32
// dim           40   8 × i16  16   8 × i64  quatern_b, c, d        256  3 × f32   352  3 × f64
// datatype      70   i16      12   i16      qoffset_x, y, z        268  3 × f32   376  3 × f64
// bitpix        72   i16      14   i16      srow_x, y, z           280  12 × f32  400  12 × f64
// pixdim        76   8 × f32  104  8 × f64  xyzt_units             123  u8        500  i32
// vox_offset    108  f32      168  i64      magic                  344  4 bytes   4    8 bytes
// scl_slope     112  f32      176  f64
// scl_inter     116  f32      184  f64      toffset                136  f32       216  f64
namespace isosplat::import {
namespace {

using namespace std::string_view_literals;

class Fields {
 public:
  Fields(std::span<const std::byte> bytes, bool swap) : bytes_(bytes), swap_(swap) {}

  template <class T>
  T get(size_t offset) const {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + offset, sizeof(T));
    if (swap_) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  template <class T, size_t n>
  void doubles(size_t offset, std::array<double, n>& out) const {
    for (size_t i = 0; i < n; ++i) out[i] = static_cast<double>(get<T>(offset + i * sizeof(T)));
  }

 private:
  std::span<const std::byte> bytes_;
  bool swap_;
};

using Steps = std::array<Vec3d, 3>;

struct Affine {
  Steps steps;  ///< step vectors of the axes, RAS
  Vec3d origin;
};

bool is_finite(Vec3d v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Whether the numbers are a unit quaternion, except for rounding.
bool has_unit_quaternion(const NiftiHeader& h) {
  const auto& q = h.quaternion;
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] < 1.01;
}

bool is_basis(const Affine& a) {
  const double volume = std::abs(dot(a.steps[0], cross(a.steps[1], a.steps[2])));
  const double box = length(a.steps[0]) * length(a.steps[1]) * length(a.steps[2]);
  return is_finite(a.steps[0]) && is_finite(a.steps[1]) && is_finite(a.steps[2]) &&
         is_finite(a.origin) && box > 0 && volume > 1e-6 * box;
}

Affine sform_of(const NiftiHeader& h) {
  const auto& s = h.srow;
  return {{Vec3d{s[0], s[4], s[8]}, Vec3d{s[1], s[5], s[9]}, Vec3d{s[2], s[6], s[10]}},
          {s[3], s[7], s[11]}};
}

/// Method 2 of the specification: a rotation quaternion, spacings, and qfac, which may reverse z.
Affine qform_of(const NiftiHeader& h) {
  double b = h.quaternion[0], c = h.quaternion[1], d = h.quaternion[2];
  double a = 1 - (b * b + c * c + d * d);
  if (a < 1e-7) {  // a rotation by 180°
    const double scale = 1 / std::sqrt(b * b + c * c + d * d);
    b *= scale, c *= scale, d *= scale;
    a = 0;
  } else {
    a = std::sqrt(a);
  }
  const double qfac = h.pixdim[0] < 0 ? -1 : 1;
  // Spacings are positive by the specification: only the quaternion and qfac give directions.
  const double x = std::abs(h.pixdim[1]), y = std::abs(h.pixdim[2]),
               z = std::abs(h.pixdim[3]) * qfac;
  return {{Vec3d{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)} * x,
           Vec3d{2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)} * y,
           Vec3d{2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b} * z},
          {h.qoffset[0], h.qoffset[1], h.qoffset[2]}};
}

bool is_left_handed(const Affine& a) {
  return dot(a.steps[0], cross(a.steps[1], a.steps[2])) < 0;
}

/// The largest distance between the volume's corners under two transforms.
double disagreement(const Affine& a, const Affine& b, const std::vector<int64_t>& sizes) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d difference = a.origin - b.origin;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double index =
          corner >> axis & 1 ? static_cast<double>(sizes.size() > axis ? sizes[axis] - 1 : 0) : 0;
      difference = difference + (a.steps[axis] - b.steps[axis]) * index;
    }
    largest = std::max(largest, length(difference));
  }
  return largest;
}

bool has_bytes(std::span<const std::byte> bytes, size_t at, std::string_view expected) {
  return std::memcmp(bytes.data() + at, expected.data(), expected.size()) == 0;
}

/// The sizes of the first dim[0] dimensions.
Result<std::vector<int64_t>> sizes_of(const std::filesystem::path& path,
                                      const std::array<double, 8>& dim) {
  if (!(dim[0] >= 1 && dim[0] <= 7)) {
    return malformed_nifti(path, fmt::format("expected 1 to 7 dimensions, found {}", dim[0]));
  }
  std::vector<int64_t> sizes;
  for (size_t i = 1; i <= static_cast<size_t>(dim[0]); ++i) {
    sizes.push_back(static_cast<int64_t>(dim[i]));
  }
  return sizes;
}

/// Reads a NIfTI-1 header. `bytes` has at least 348 bytes; `f`: its fields in their byte order.
Result<NiftiHeader> parse_nifti1(const std::filesystem::path& path,
                                 std::span<const std::byte> bytes, const Fields& f) {
  NiftiHeader h;
  h.is_pair = has_bytes(bytes, 344, "ni1\0"sv);
  if (!h.is_pair && !has_bytes(bytes, 344, "n+1\0"sv)) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected a NIfTI header with the magic 'n+1' or 'ni1', found an "
                            "ANALYZE 7.5 or other header: ANALYZE does not distinguish left from "
                            "right; save the volume as NIfTI",
                            path.string()));
  }
  std::array<double, 8> dim{};
  f.doubles<int16_t>(40, dim);
  h.data_type = f.get<int16_t>(70);
  h.bits = f.get<int16_t>(72);
  f.doubles<float>(76, h.pixdim);
  h.voxel_offset = static_cast<double>(f.get<float>(108));
  h.slope = static_cast<double>(f.get<float>(112));
  h.intercept = static_cast<double>(f.get<float>(116));
  h.units = f.get<uint8_t>(123);
  h.time_offset = static_cast<double>(f.get<float>(136));
  h.qform_code = f.get<int16_t>(252);
  h.sform_code = f.get<int16_t>(254);
  f.doubles<float>(256, h.quaternion);
  f.doubles<float>(268, h.qoffset);
  f.doubles<float>(280, h.srow);
  auto sizes = sizes_of(path, dim);
  if (!sizes) return tl::unexpected(sizes.error());
  h.sizes = *std::move(sizes);
  return h;
}

/// Reads a NIfTI-2 header. `bytes` has at least 540 bytes; `f`: its fields in their byte order.
Result<NiftiHeader> parse_nifti2(const std::filesystem::path& path,
                                 std::span<const std::byte> bytes, const Fields& f) {
  NiftiHeader h;
  h.version = 2;
  h.is_pair = has_bytes(bytes, 4, "ni2\0\r\n\032\n"sv);
  if (!h.is_pair && !has_bytes(bytes, 4, "n+2\0\r\n\032\n"sv)) {
    return malformed_nifti(path,
                           "expected the magic 'n+2' or 'ni2' of NIfTI-2 with its line ends, found "
                           "others");
  }
  std::array<double, 8> dim{};
  for (size_t i = 0; i < 8; ++i) {
    const auto value = f.get<int64_t>(16 + 8 * i);
    if (std::abs(value) > int64_t{1} << 40)
      return malformed_nifti(path, fmt::format("a size of {}", value));
    dim[i] = static_cast<double>(value);
  }
  h.data_type = f.get<int16_t>(12);
  h.bits = f.get<int16_t>(14);
  f.doubles<double>(104, h.pixdim);
  h.voxel_offset = static_cast<double>(f.get<int64_t>(168));
  h.slope = f.get<double>(176);
  h.intercept = f.get<double>(184);
  h.time_offset = f.get<double>(216);
  h.qform_code = f.get<int32_t>(344);
  h.sform_code = f.get<int32_t>(348);
  f.doubles<double>(352, h.quaternion);
  f.doubles<double>(376, h.qoffset);
  f.doubles<double>(400, h.srow);
  h.units = f.get<int32_t>(500);
  auto sizes = sizes_of(path, dim);
  if (!sizes) return tl::unexpected(sizes.error());
  h.sizes = *std::move(sizes);
  return h;
}

}  // namespace

tl::unexpected<Error> malformed_nifti(const std::filesystem::path& path, const std::string& what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the NIfTI header is damaged; export the volume again",
                          path.string(), what));
}

Result<NiftiHeader> parse_nifti(const std::filesystem::path& path,
                                std::span<const std::byte> bytes) {
  const auto size = bytes.size() < 4 ? 0 : Fields(bytes, false).get<int32_t>(0);
  const auto swapped = static_cast<int32_t>(__builtin_bswap32(static_cast<uint32_t>(size)));
  const bool swap = size != 348 && size != 540;
  const int32_t header_bytes = swap ? swapped : size;
  const bool is_nifti1 = header_bytes == 348 && bytes.size() >= 348;
  const bool is_nifti2 = header_bytes == 540 && bytes.size() >= 540;
  if (!is_nifti1 && !is_nifti2) {
    return malformed_nifti(
        path, fmt::format("expected a header of 348 or 540 bytes (NIfTI-1, NIfTI-2), found "
                          "size {}",
                          size));
  }
  const Fields fields(bytes, swap);
  auto header = is_nifti1 ? parse_nifti1(path, bytes, fields) : parse_nifti2(path, bytes, fields);
  if (header) header->big_endian = swap != (std::endian::native == std::endian::big);
  return header;
}

std::optional<VoxelType> nifti_type(int16_t code) {
  switch (code) {
    case 2:
      return VoxelType::u8;
    case 4:
      return VoxelType::i16;
    case 8:
      return VoxelType::i32;
    case 16:
      return VoxelType::f32;
    case 64:
      return VoxelType::f64;
    case 256:
      return VoxelType::i8;
    case 512:
      return VoxelType::u16;
    case 768:
      return VoxelType::u32;
    case 1024:
      return VoxelType::i64;
    case 1280:
      return VoxelType::u64;
    default:
      return std::nullopt;
  }
}

TimeAxis nifti_times(const NiftiHeader& header) {
  if (header.sizes.size() < 4) return {};
  const auto times = [&](const char* unit) {
    return TimeAxis::regular(header.time_offset, header.pixdim[4], header.sizes[3], unit);
  };
  switch (header.units & 0x38) {
    case 8:
      return times("s");
    case 16:
      return times("ms");
    case 24:
      return times("µs");
    default:
      return {};
  }
}

/// The frame of reference of a transform's code (NIFTI_XFORM_…). Codes 2 and 5 (aligned, another
/// template) do not say to which volume.
std::string_view nifti_frame(int32_t code) {
  constexpr std::array<std::string_view, 5> kFrames{"", "scanner", "", "talairach", "mni152"};
  return code >= 0 && code < 5 ? kFrames[static_cast<size_t>(code)] : "";
}

Result<HeaderGeometry> nifti_geometry(const std::filesystem::path& path, const NiftiHeader& h,
                                      std::vector<std::string>& notes) {
  const bool says_sform = h.sform_code > 0, says_qform = h.qform_code > 0;
  const Affine sform = sform_of(h), qform = qform_of(h);
  const bool has_sform = says_sform && is_basis(sform);
  const bool has_qform = says_qform && has_unit_quaternion(h) && is_basis(qform);
  HeaderGeometry geometry;
  std::string_view frame_of_reference;
  if (has_sform) {
    geometry = geometry_of_steps(sform.steps, sform.origin);
    frame_of_reference = nifti_frame(h.sform_code);
    const double voxel =
        std::min({length(sform.steps[0]), length(sform.steps[1]), length(sform.steps[2])});
    if (has_qform && is_left_handed(sform) != is_left_handed(qform)) {
      notes.push_back(
          "one of the header's two transforms mirrors the volume, and the other does not: the "
          "sform is used; left and right may be swapped");
    } else if (has_qform && h.sform_code == h.qform_code) {
      if (const double apart = disagreement(sform, qform, h.sizes); apart > voxel) {
        notes.push_back(
            fmt::format("the header's two transforms differ by up to {:.3g} voxels at the volume's "
                        "corners: the sform is used",
                        apart / voxel));
      }
    }
  } else if (has_qform) {
    if (says_sform) {
      notes.push_back("the header's sform is singular: the qform is used");
    }
    if (std::min({h.pixdim[1], h.pixdim[2], h.pixdim[3]}) < 0) {
      notes.push_back(
          "the header has negative spacings (pixdim), which have no meaning beside the qform: "
          "their absolute values are used");
    }
    geometry = geometry_of_steps(qform.steps, qform.origin);
    frame_of_reference = nifti_frame(h.qform_code);
  } else if (says_sform || says_qform) {
    return malformed_nifti(path, "its transforms (sform, qform) are singular");
  } else {
    notes.push_back(
        "the header has no orientation: x to the left, y forwards and z up are assumed, as in "
        "ANALYZE; left and right may be "
        "swapped");
    geometry = geometry_of_spacing(
        {-std::abs(h.pixdim[1]), std::abs(h.pixdim[2]), std::abs(h.pixdim[3])}, {0, 0, 0});
  }
  geometry.frame_of_reference = frame_of_reference;
  to_lps(Frame::ras, geometry);
  switch (h.units & 7) {
    case 1:
      scale_lengths(1000, geometry);
      break;
    case 2:
      break;
    case 3:
      scale_lengths(1e-3, geometry);
      break;
    case 0:
      notes.push_back("the header has no unit of lengths: millimetres are assumed");
      break;
    default:
      notes.push_back(fmt::format(
          "the header's unit of lengths has the unknown code {}: millimetres are assumed",
          h.units & 7));
  }
  return geometry;
}

}  // namespace isosplat::import
