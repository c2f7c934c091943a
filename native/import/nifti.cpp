#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "native/import/array_source.h"
#include "native/import/formats.h"

// NIfTI-1 (.nii, .nii.gz). ITK reads the geometry (of the header's two transforms it chooses the
// right one, and turns RAS into LPS), but for sheared grids, which it does not know; where the
// voxels are, and their scaling, is read here, so that they can be streamed.
//
//   bytes 0–3     348: tells the byte order        108–111  f32: the first voxel's offset
//         40–55   i16[8]: dimension, sizes         112–115  f32: slope    116–119  f32: intercept
//         70–71   i16: data type                   344–347  "n+1\0" (one file)
namespace isosplat {
namespace {

constexpr size_t kHeaderBytes = 348;

class Fields {
 public:
  explicit Fields(std::span<const std::byte, kHeaderBytes> bytes) : bytes_(bytes) {
    swap_ = get<int32_t>(0) != static_cast<int32_t>(kHeaderBytes);
  }

  template <class T>
  T get(size_t offset) const {
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
    if (swap_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  bool big_endian() const { return swap_ != (std::endian::native == std::endian::big); }

 private:
  std::span<const std::byte, kHeaderBytes> bytes_;
  bool swap_ = false;
};

std::optional<StoredType> type_of(int16_t code) {
  switch (code) {
    case 2:
      return StoredType::u8;
    case 4:
      return StoredType::i16;
    case 8:
      return StoredType::i32;
    case 16:
      return StoredType::f32;
    case 64:
      return StoredType::f64;
    case 256:
      return StoredType::i8;
    case 512:
      return StoredType::u16;
    case 768:
      return StoredType::u32;
    case 1024:
      return StoredType::i64;
    case 1280:
      return StoredType::u64;
    default:
      return std::nullopt;
  }
}

/// The geometry of the header's affine transform ("sform"), which may be sheared. Nothing where the
/// header has none.
std::optional<HeaderGeometry> affine_geometry(const Fields& fields) {
  if (fields.get<int16_t>(254) <= 0) return std::nullopt;
  HeaderGeometry geometry;
  double* const spacing[] = {&geometry.spacing.x, &geometry.spacing.y, &geometry.spacing.z};
  double* const origin[] = {&geometry.origin.x, &geometry.origin.y, &geometry.origin.z};
  for (size_t row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -1 : 1;  // RAS → LPS
    for (size_t axis = 0; axis < 4; ++axis) {
      const double value = sign * static_cast<double>(fields.get<float>(280 + 16 * row + 4 * axis));
      if (!std::isfinite(value)) return std::nullopt;
      (axis < 3 ? geometry.direction[3 * row + axis] : *origin[row]) = value;
    }
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto& d = geometry.direction;
    *spacing[axis] = std::hypot(d[axis], d[3 + axis], d[6 + axis]);
  }
  return geometry;
}

}  // namespace

Result<OpenVolume> open_nifti(const std::filesystem::path& path, const ImportOptions& options) {
  const bool deflated = is_gzip(path);
  auto bytes = deflated ? open_deflated(path) : open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  std::array<std::byte, kHeaderBytes> raw{};
  if (auto read = (*bytes)->read(0, raw); !read) return tl::unexpected(read.error());
  const Fields fields(raw);
  if (fields.get<int32_t>(0) != static_cast<int32_t>(kHeaderBytes) ||
      std::memcmp(raw.data() + 344, "n+1", 4) != 0) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected a NIfTI-1 header (size 348, magic 'n+1'), found size {}: "
                            "the file is damaged, or NIfTI-2 or a .hdr/.img pair; save it as "
                            ".nii.gz (NIfTI-1)",
                            path.string(), fields.get<int32_t>(0)));
  }
  const int16_t dimension = fields.get<int16_t>(40);
  if (dimension < 1 || dimension > 7) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected 1 to 7 dimensions, found {}: the header is damaged; "
                            "export the volume again",
                            path.string(), dimension));
  }
  std::vector<int64_t> sizes;
  for (int16_t i = 1; i <= dimension; ++i) {
    sizes.push_back(fields.get<int16_t>(40 + 2 * static_cast<size_t>(i)));
  }
  const int16_t code = fields.get<int16_t>(70);
  if (code == 128 || code == 2304) return not_scalar(path, code == 128 ? 3 : 4);
  if (code == 32 || code == 1792) return not_scalar(path, 2);
  const auto type = type_of(code);
  if (!type) return unknown_type(path, fmt::format("NIfTI data type {}", code));
  if (sizes.size() > 4 && sizes[4] > 1) {
    return not_scalar(path, static_cast<int>(sizes[4]));
  }
  const auto step = choose_time_step(path, sizes, options);
  if (!step) return tl::unexpected(step.error());

  // Where the affine transform is sheared, ITK takes the other one, a rotation, or refuses the
  // file.
  HeaderGeometry geometry;
  const auto affine = affine_geometry(fields);
  if (affine && shear_degrees(affine->direction) >= kLeastShearDegrees) {
    geometry = *affine;
  } else if (const auto itk_header = read_itk_header(ItkFormat::nifti, path)) {
    geometry = itk_header->geometry;
  } else if (affine) {
    geometry = *affine;
  } else {
    return tl::unexpected(itk_header.error());
  }

  ArrayVolume array = make_array("NIfTI", path, sizes, geometry, options);
  array.stored.type = *type;
  array.stored.big_endian = fields.big_endian();
  const auto slope = static_cast<double>(fields.get<float>(112));
  const auto intercept = static_cast<double>(fields.get<float>(116));
  if (std::isfinite(slope) && slope != 0 && std::isfinite(intercept)) {
    array.stored.slope = slope;
    array.stored.intercept = intercept;
  }
  const float offset = fields.get<float>(108);
  if (!(offset >= 348 && offset < 1e9f)) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected the voxels' offset to be 352 or so, found {}: the header "
                            "is damaged; export the volume again",
                            path.string(), offset));
  }
  array.offset = static_cast<uint64_t>(offset);
  array.time_step = *step;
  array.plain = !deflated;
  return open_array(std::move(array), std::move(*bytes));
}

}  // namespace isosplat
