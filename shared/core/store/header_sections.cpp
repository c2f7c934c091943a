#include "shared/core/store/header_sections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "shared/core/store/format.h"

namespace isosplat {
namespace {

tl::unexpected<Error> differs(const std::string& field, uint64_t expected, uint64_t found) {
  return malformed_header(field + ": expected " + std::to_string(expected) + ", found " +
                          std::to_string(found));
}

bool all_finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

uint64_t bytes_of_fields(const StoreInfo& info) {
  uint64_t bytes = 0;
  for (const FieldRef& field : info.fields) bytes += field.bytes;
  return bytes;
}

/// Errors: malformed_header where a value of section VOLU is outside its limits.
Result<void> check_volume(const StoreInfo& info) {
  const VolumeGrid& grid = info.grid;
  if (!all_finite({grid.spacing.x, grid.spacing.y, grid.spacing.z, grid.origin.x, grid.origin.y,
                   grid.origin.z, info.mapping.offset, info.mapping.scale,
                   info.mapping.max_error}) ||
      !std::all_of(grid.direction.begin(), grid.direction.end(),
                   [](double v) { return std::isfinite(v); })) {
    return malformed_header("spacing, origin, direction, offset or scale: expected finite numbers");
  }
  if (!(grid.spacing.x > 0 && grid.spacing.y > 0 && grid.spacing.z > 0)) {
    return malformed_header("spacing: expected numbers above 0");
  }
  if (!is_basis(grid.direction)) {
    return malformed_header(
        "direction: expected three columns of length 1 that do not lie in a plane, found the "
        "determinant " +
        std::to_string(determinant(grid.direction)));
  }
  if (!(info.mapping.scale > 0) || info.mapping.max_error < 0) {
    return malformed_header("scale or error bound of the values: expected numbers above 0");
  }
  if (info.range.min > info.range.max || (info.mapping.bits == 8 && info.range.max > 255)) {
    return malformed_header("range of the voxels: found " + std::to_string(info.range.min) +
                            " to " + std::to_string(info.range.max));
  }
  const uint64_t voxel_count = static_cast<uint64_t>(grid.voxels.x) *
                               static_cast<uint64_t>(grid.voxels.y) *
                               static_cast<uint64_t>(grid.voxels.z);
  if (info.missing_voxels > (info.mapping.has_missing ? voxel_count : 0)) {
    return malformed_header("voxels without a value: found " + std::to_string(info.missing_voxels));
  }
  return {};
}

}  // namespace

tl::unexpected<Error> malformed_header(const std::string& what) {
  return fail(Status::malformed_header, what + kHeaderRemedy);
}

Result<void> parse_volume_section(std::span<const std::byte> payload, StoreInfo& info) {
  if (payload.size() < kVolumeSectionBytes) {
    return differs("bytes of section VOLU", kVolumeSectionBytes, payload.size());
  }
  FieldReader field(payload.data());
  std::array<uint32_t, 3> voxels;
  for (uint32_t& n : voxels) {
    n = field.u32();
    if (n < 2 || n > static_cast<uint32_t>(kMaxVoxelsPerAxis)) {
      return malformed_header("voxels along an axis: expected 2 to " +
                              std::to_string(kMaxVoxelsPerAxis) + ", found " + std::to_string(n));
    }
  }
  info.grid.voxels = {static_cast<int32_t>(voxels[0]), static_cast<int32_t>(voxels[1]),
                      static_cast<int32_t>(voxels[2])};
  info.mapping.bits = field.u8();
  const uint8_t flags = field.u8();
  if (field.u16() != 0 || flags > 1 || (info.mapping.bits != 8 && info.mapping.bits != 16)) {
    return malformed_header("bits or flags of the voxels: found " +
                            std::to_string(info.mapping.bits) + " and " + std::to_string(flags));
  }
  info.mapping.has_missing = (flags & 1) != 0;
  VolumeGrid& grid = info.grid;
  for (double* v : {&grid.spacing.x, &grid.spacing.y, &grid.spacing.z, &grid.origin.x,
                    &grid.origin.y, &grid.origin.z}) {
    *v = field.f64();
  }
  for (double& v : grid.direction) v = field.f64();
  info.mapping.offset = field.f64();
  info.mapping.scale = field.f64();
  info.mapping.max_error = field.f64();
  info.missing_voxels = field.u64();
  info.range = {field.u16(), field.u16()};
  return check_volume(info);
}

void write_volume_section(const StoreInfo& info, FieldWriter& to) {
  to.field(4, kVolumeTag);
  to.field(4, kVolumeSectionBytes);
  for (int32_t n : {info.grid.voxels.x, info.grid.voxels.y, info.grid.voxels.z}) {
    to.field(4, static_cast<uint32_t>(n));
  }
  to.field(1, info.mapping.bits);
  to.field(1, info.mapping.has_missing ? 1 : 0);
  to.field(2, 0);
  for (double v : {info.grid.spacing.x, info.grid.spacing.y, info.grid.spacing.z,
                   info.grid.origin.x, info.grid.origin.y, info.grid.origin.z}) {
    to.f64(v);
  }
  for (double v : info.grid.direction) to.f64(v);
  for (double v : {info.mapping.offset, info.mapping.scale, info.mapping.max_error}) to.f64(v);
  to.field(8, info.missing_voxels);
  to.field(2, info.range.min);
  to.field(2, info.range.max);
  to.field(4, 0);
}

Result<void> parse_levels_section(std::span<const std::byte> payload, StoreHeader& header) {
  StoreInfo& info = header.info;
  const uint32_t levels = level_count(info.grid.voxels);
  const size_t bytes = kLevelSectionHeaderBytes + levels * kLevelRecordBytes;
  if (payload.size() != bytes) return differs("bytes of section LEVL", bytes, payload.size());
  FieldReader field(payload.data());
  if (const uint32_t found = field.u32(); found != levels) {
    return differs("number of levels", levels, found);
  }
  header.page_log2 = field.u32();
  if (header.page_log2 < kMinPageLog2 || header.page_log2 > kMaxPageLog2 ||
      total_pages(info.grid.voxels, header.page_log2) > kMaxPages) {
    return malformed_header("blocks of a page: found 2^" + std::to_string(header.page_log2) +
                            " along each axis");
  }
  info.levels = levels;
  uint64_t offset = header.info.header_bytes;
  for (uint32_t l = 0; l < levels; ++l) {
    LevelRef level;
    level.grid = level_grid(info.grid.voxels, l);
    level.chunks_offset = field.u64();
    level.chunks_bytes = field.u64();
    level.chunk_count = field.u64();
    level.interval = {field.u16(), field.u16()};
    level.page_count = field.u32();
    const std::string name = "level " + std::to_string(l);
    if (level.chunks_offset != offset) {
      return differs(name + ": offset of its chunks", offset, level.chunks_offset);
    }
    if (level.chunks_bytes > info.file_bytes - offset) {
      return malformed_header(name + ": its chunks end beyond the file, by their " +
                              std::to_string(level.chunks_bytes) + " bytes");
    }
    offset += level.chunks_bytes;
    if (l == 0) {  // the fields come first
      const uint64_t fields = bytes_of_fields(info);
      if (fields > level.chunks_bytes) {
        return malformed_header("the fields have more bytes than level 0, which contains them");
      }
      level.chunks_offset += fields;
      level.chunks_bytes -= fields;
    }
    if (level.chunk_count > level.chunks_bytes) {
      return malformed_header(name + ": " + std::to_string(level.chunk_count) + " chunks in " +
                              std::to_string(level.chunks_bytes) + " bytes");
    }
    // Coarse intervals may be rounded outwards, beyond the volume's range.
    const CellInterval allowed =
        l == 0
            ? info.range
            : CellInterval{0, info.mapping.bits == 8 ? QuantizedValue{255} : QuantizedValue{65535}};
    if (level.interval.min > level.interval.max ||
        (level.interval.min < level.interval.max &&
         (level.interval.min < allowed.min || level.interval.max > allowed.max))) {
      return malformed_header(name + ": its interval is not within the range of the voxels");
    }
    info.chunk_count += level.chunk_count;
    header.levels.push_back(level);
  }
  return {};
}

void write_levels_section(const StoreHeader& header, FieldWriter& to) {
  to.field(4, kLevelsTag);
  to.field(4, kLevelSectionHeaderBytes + header.levels.size() * kLevelRecordBytes);
  to.field(4, header.levels.size());
  to.field(4, header.page_log2);
  for (const LevelRef& level : header.levels) {
    const uint64_t fields = level.grid.level == 0 ? bytes_of_fields(header.info) : 0;
    to.field(8, level.chunks_offset - fields);
    to.field(8, level.chunks_bytes + fields);
    to.field(8, level.chunk_count);
    to.field(2, level.interval.min);
    to.field(2, level.interval.max);
    to.field(4, level.page_count);
  }
}

Result<void> parse_pages_section(std::span<const std::byte> payload, StoreHeader& header) {
  header.pages = list_pages(header.info.grid.voxels, header.page_log2);
  const size_t bytes = header.pages.size() * kPageRecordBytes;
  if (payload.size() != bytes) return differs("bytes of section PAGE", bytes, payload.size());
  FieldReader field(payload.data());
  const LevelRef& last = header.levels.back();
  uint64_t offset = last.chunks_offset + last.chunks_bytes;
  for (uint32_t i = 0; i < header.pages.size(); ++i) {
    PageRef& page = header.pages[i];
    page.offset = offset;
    page.bytes = field.u32();
    page.checksum = field.u32();
    page.interval = {field.u16(), field.u16()};
    const CellInterval of_level = header.levels[page.level].interval;
    if (page.bytes > header.info.file_bytes - offset) {
      return malformed_header("page " + std::to_string(i) + " ends beyond the file, by its " +
                              std::to_string(page.bytes) + " bytes");
    }
    if (page.interval.min > page.interval.max ||
        (page.interval.min < page.interval.max &&
         (page.interval.min < of_level.min || page.interval.max > of_level.max))) {
      return malformed_header("page " + std::to_string(i) +
                              ": its interval is not within that of its level");
    }
    offset += page.bytes;
  }
  if (offset != header.info.file_bytes)
    return differs("bytes of the file", offset, header.info.file_bytes);
  for (LevelRef& level : header.levels) {
    const auto of_level = [&](const PageRef& page) { return page.level == level.grid.level; };
    const auto first = std::find_if(header.pages.begin(), header.pages.end(), of_level);
    const auto count = static_cast<uint32_t>(std::count_if(first, header.pages.end(), of_level));
    if (count != level.page_count) {
      return differs("pages of level " + std::to_string(level.grid.level), count, level.page_count);
    }
    level.first_page = static_cast<uint32_t>(first - header.pages.begin());
  }
  return {};
}

void write_pages_section(const StoreHeader& header, FieldWriter& to) {
  to.field(4, kPagesTag);
  to.field(4, header.pages.size() * kPageRecordBytes);
  for (const PageRef& page : header.pages) {
    to.field(4, page.bytes);
    to.field(4, page.checksum);
    to.field(2, page.interval.min);
    to.field(2, page.interval.max);
  }
}

}  // namespace isosplat
