#include "shared/import/mgh/mgh.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/geometry/conventions.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"

// Reads volumes of FreeSurfer, also compressed by gzip. Numbers are big-endian.
//
//   0  i32      version, 1
//   4  i32[3]   voxels along x, y and z
//  16  i32      frames: time steps
//  20  i32      type
//  24  i32      degrees of freedom
//  28  i16      1 if the following fields are valid
//  30  f32[3]   spacing in mm
//  42  f32[9]   directions of x, y and z in RAS
//  78  f32[3]   position in RAS of the index (voxels / 2)
//  90           unused
// 284           voxels, x fastest; then the parameters of the scan
namespace isosplat::import {
namespace {

constexpr size_t kHeaderBytes = 284;
constexpr size_t kUsedBytes = 90;

struct Header {
  std::array<int32_t, 7> words{};  ///< version to degrees of freedom
  bool has_geometry = false;
  std::array<float, 15> geometry{};

  int32_t frames() const { return words[4]; }
  int32_t type() const { return words[5]; }
};

std::optional<Header> parse(std::string_view bytes) {
  if (bytes.size() < kUsedBytes) return std::nullopt;
  const auto big_endian = [&](size_t at, size_t count) {
    uint32_t value = 0;
    for (size_t i = 0; i < count; ++i) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
    return value;
  };
  Header header;
  for (size_t i = 0; i < header.words.size(); ++i) {
    header.words[i] = static_cast<int32_t>(big_endian(4 * i, 4));
  }
  header.has_geometry = static_cast<int16_t>(big_endian(28, 2)) > 0;
  for (size_t i = 0; i < header.geometry.size(); ++i) {
    const uint32_t bits = big_endian(30 + 4 * i, 4);
    std::memcpy(&header.geometry[i], &bits, 4);
  }
  return header;
}

std::optional<VoxelType> type_of(int32_t code) {
  switch (code) {
    case 0:
      return VoxelType::u8;
    case 1:
      return VoxelType::i32;
    case 3:
      return VoxelType::f32;
    case 4:
      return VoxelType::i16;
    case 10:
      return VoxelType::u16;
    default:
      return std::nullopt;
  }
}

tl::unexpected<Error> malformed(const std::filesystem::path& path, const std::string& what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the file is damaged, or not from FreeSurfer; convert the volume "
                          "again",
                          path.string(), what));
}

HeaderGeometry geometry_of(const Header& header, std::vector<std::string>& notes) {
  // The axes of a coronal slice, which FreeSurfer assumes too.
  std::array<float, 15> fields{1, 1, 1, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0};
  if (header.has_geometry) {
    fields = header.geometry;
  } else {
    notes.push_back(
        "the header has no voxel spacing and orientation: 1,1,1 is assumed; --spacing sets "
        "another; coronal slices are assumed, as FreeSurfer does");
  }
  std::array<Vec3d, 3> steps;
  Vec3d origin{fields[12], fields[13], fields[14]};
  for (size_t axis = 0; axis < 3; ++axis) {
    const float* const direction = &fields[3 + 3 * axis];
    steps[axis] = Vec3d{direction[0], direction[1], direction[2]} * double{fields[axis]};
    origin = origin - steps[axis] * (header.words[1 + axis] * 0.5);
  }
  HeaderGeometry geometry = geometry_of_steps(steps, origin);
  to_lps(Frame::ras, geometry);
  return geometry;
}

}  // namespace

bool is_mgh(std::string_view head, bool by_name) {
  const auto header = parse(head);
  if (!header || header->words[0] != 1) return false;
  if (by_name) return true;
  for (size_t i = 1; i < 5; ++i) {
    if (header->words[i] < 1 || header->words[i] > 1 << 16) return false;
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    const float* const d = &header->geometry[3 + 3 * axis];
    if (!(std::abs(std::hypot(d[0], d[1], d[2]) - 1) < 1e-3)) return false;
  }
  return header->has_geometry && type_of(header->type());
}

Result<OpenVolume> open_mgh(const FileHead& head, const ImportOptions& options) {
  const std::filesystem::path& path = head.path;
  auto bytes = head.is_gzip() ? open_deflated(path) : open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  std::string raw(kHeaderBytes, '\0');
  if (auto read = (*bytes)->read(0, std::as_writable_bytes(std::span(raw))); !read) {
    return tl::unexpected(read.error());
  }
  const auto header = parse(raw);
  const auto type = type_of(header->type());
  if (!type) return unknown_type(path, fmt::format("FreeSurfer's type {}", header->type()));
  if (header->frames() < 1) {
    return malformed(path, fmt::format("expected at least one frame, found {}", header->frames()));
  }
  const auto step = choose_step(path, header->frames(), options);
  if (!step) return tl::unexpected(step.error());
  std::vector<std::string> notes;
  const HeaderGeometry geometry = geometry_of(*header, notes);
  ArrayVolume array = make_array(
      "MGH", path, {header->words[1], header->words[2], header->words[3]}, geometry, options);
  array.stored.type = *type;
  array.stored.big_endian = true;
  array.steps = static_cast<uint64_t>(header->frames());
  array.step = *step;
  array.offset = kHeaderBytes;
  array.plain = !head.is_gzip();
  array.ends_with_file = false;  // parameters of the scan follow
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat::import
