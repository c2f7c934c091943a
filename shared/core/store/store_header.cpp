#include "shared/core/store/store_header.h"

#include <algorithm>
#include <cmath>

#include "shared/core/store/byte_order.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/format.h"

namespace isosplat {
namespace {

constexpr const char* kRemedy = ": rebuild the store, or fetch it again";

tl::unexpected<Error> malformed(const std::string& what) {
  return fail(Status::malformed_header, what + kRemedy);
}

tl::unexpected<Error> differs(const std::string& field, uint64_t expected, uint64_t found) {
  return malformed(field + ": expected " + std::to_string(expected) + ", found " +
                   std::to_string(found));
}

/// The payloads of the sections that version 1 defines; empty if a section is absent.
struct Sections {
  std::span<const std::byte> volume, levels, pages, metadata;
};

Result<Sections> find_sections(std::span<const std::byte> body, uint32_t count) {
  Sections sections;
  size_t at = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (body.size() - at < kSectionHeaderBytes) {
      return malformed("section " + std::to_string(i) + " begins beyond the header's end");
    }
    const auto tag = static_cast<uint32_t>(read_le(body.data() + at, 4));
    const auto bytes = static_cast<size_t>(read_le(body.data() + at + 4, 4));
    at += kSectionHeaderBytes;
    if (bytes > body.size() - at || padded_to_8(bytes) > body.size() - at) {
      return malformed("section " + std::to_string(i) + " announces " + std::to_string(bytes) +
                       " bytes, the header has " + std::to_string(body.size() - at));
    }
    const std::span<const std::byte> payload = body.subspan(at, bytes);
    at += padded_to_8(bytes);
    std::span<const std::byte>* known = tag == kVolumeTag     ? &sections.volume
                                        : tag == kLevelsTag   ? &sections.levels
                                        : tag == kPagesTag    ? &sections.pages
                                        : tag == kMetadataTag ? &sections.metadata
                                                              : nullptr;
    if (known) {
      if (known->data()) return malformed("section " + std::to_string(i) + " appears twice");
      *known = payload;
    } else if (!is_optional_section(tag)) {
      return fail(Status::unsupported_version,
                  "section " + std::to_string(i) +
                      " is required, but of a type that this version does not support: "
                      "open the store with a newer Isosplat");
    }
  }
  return sections;
}

bool all_finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Errors: malformed_header where a value of section VOLU is outside its limits.
Result<void> check_volume(const StoreInfo& info) {
  const VolumeGrid& grid = info.grid;
  if (!all_finite({grid.spacing.x, grid.spacing.y, grid.spacing.z, grid.origin.x, grid.origin.y,
                   grid.origin.z, info.mapping.offset, info.mapping.scale,
                   info.mapping.max_error}) ||
      !std::all_of(grid.direction.begin(), grid.direction.end(),
                   [](double v) { return std::isfinite(v); })) {
    return malformed("spacing, origin, direction, offset or scale: expected finite numbers");
  }
  if (!(grid.spacing.x > 0 && grid.spacing.y > 0 && grid.spacing.z > 0)) {
    return malformed("spacing: expected numbers above 0");
  }
  if (!is_basis(grid.direction)) {
    return malformed(
        "direction: expected three columns of length 1 that do not lie in a plane, found the "
        "determinant " +
        std::to_string(determinant(grid.direction)));
  }
  if (!(info.mapping.scale > 0) || info.mapping.max_error < 0) {
    return malformed("scale or error bound of the values: expected numbers above 0");
  }
  if (info.range.min > info.range.max || (info.mapping.bits == 8 && info.range.max > 255)) {
    return malformed("range of the voxels: found " + std::to_string(info.range.min) + " to " +
                     std::to_string(info.range.max));
  }
  const uint64_t voxel_count = static_cast<uint64_t>(grid.voxels.x) *
                               static_cast<uint64_t>(grid.voxels.y) *
                               static_cast<uint64_t>(grid.voxels.z);
  if (info.missing_voxels > (info.mapping.has_missing ? voxel_count : 0)) {
    return malformed("voxels without a value: found " + std::to_string(info.missing_voxels));
  }
  return {};
}

Result<void> parse_volume(std::span<const std::byte> payload, StoreInfo& info) {
  if (payload.size() < kVolumeSectionBytes) {
    return differs("bytes of section VOLU", kVolumeSectionBytes, payload.size());
  }
  FieldReader field(payload.data());
  std::array<uint32_t, 3> voxels;
  for (uint32_t& n : voxels) {
    n = field.u32();
    if (n < 2 || n > static_cast<uint32_t>(kMaxVoxelsPerAxis)) {
      return malformed("voxels along an axis: expected 2 to " + std::to_string(kMaxVoxelsPerAxis) +
                       ", found " + std::to_string(n));
    }
  }
  info.grid.voxels = {static_cast<int32_t>(voxels[0]), static_cast<int32_t>(voxels[1]),
                      static_cast<int32_t>(voxels[2])};
  info.mapping.bits = field.u8();
  const uint8_t flags = field.u8();
  if (field.u16() != 0 || flags > 1 || (info.mapping.bits != 8 && info.mapping.bits != 16)) {
    return malformed("bits or flags of the voxels: found " + std::to_string(info.mapping.bits) +
                     " and " + std::to_string(flags));
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

Result<void> parse_levels(std::span<const std::byte> payload, StoreHeader& header) {
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
    return malformed("blocks of a page: found 2^" + std::to_string(header.page_log2) +
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
      return malformed(name + ": its chunks end beyond the file, by their " +
                       std::to_string(level.chunks_bytes) + " bytes");
    }
    offset += level.chunks_bytes;
    if (level.chunk_count > level.chunks_bytes) {
      return malformed(name + ": " + std::to_string(level.chunk_count) + " chunks in " +
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
      return malformed(name + ": its interval is not within the range of the voxels");
    }
    info.chunk_count += level.chunk_count;
    header.levels.push_back(level);
  }
  return {};
}

Result<void> parse_pages(std::span<const std::byte> payload, StoreHeader& header) {
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
      return malformed("page " + std::to_string(i) + " ends beyond the file, by its " +
                       std::to_string(page.bytes) + " bytes");
    }
    if (page.interval.min > page.interval.max ||
        (page.interval.min < page.interval.max &&
         (page.interval.min < of_level.min || page.interval.max > of_level.max))) {
      return malformed("page " + std::to_string(i) +
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

}  // namespace

std::vector<PageRef> list_pages(Index3 voxels, uint32_t page_log2) {
  std::vector<PageRef> pages;
  for (uint32_t l = level_count(voxels); l-- > 0;) {
    const Index3 blocks = level_grid(voxels, l).blocks;
    const Index3 boxes = pages_of_level(blocks, page_log2);
    for (int32_t z = 0; z < boxes.z; ++z) {
      for (int32_t y = 0; y < boxes.y; ++y) {
        for (int32_t x = 0; x < boxes.x; ++x) {
          PageRef page;
          page.level = l;
          page.first_block = {x << page_log2, y << page_log2, z << page_log2};
          page.end_block = {std::min((x + 1) << page_log2, blocks.x),
                            std::min((y + 1) << page_log2, blocks.y),
                            std::min((z + 1) << page_log2, blocks.z)};
          pages.push_back(page);
        }
      }
    }
  }
  return pages;
}

size_t header_bytes_for(Index3 voxels, uint32_t page_log2, size_t metadata_bytes) {
  const size_t levels = kLevelSectionHeaderBytes + level_count(voxels) * kLevelRecordBytes;
  return kFixedHeaderBytes + 4 * kSectionHeaderBytes + kVolumeSectionBytes + padded_to_8(levels) +
         padded_to_8(static_cast<size_t>(total_pages(voxels, page_log2)) * kPageRecordBytes) +
         padded_to_8(metadata_bytes) + kHeaderChecksumBytes;
}

namespace {

/// Checks magic, version, lengths and checksum, and reads the fixed part of the header. Returns the
/// number of sections.
Result<uint32_t> parse_fixed_header(std::span<const std::byte> bytes, StoreInfo& info) {
  if (bytes.size() < kStoreMagic.size() ||
      !std::equal(kStoreMagic.begin(), kStoreMagic.end(), bytes.begin(),
                  [](uint8_t a, std::byte b) { return a == static_cast<uint8_t>(b); })) {
    return fail(Status::not_a_store,
                "expected a file that begins with 89 'ISOS' 0D 0A 1A, found other bytes: build a "
                "store of the volume first (isosplat build)");
  }
  if (bytes.size() < kFixedHeaderBytes) {
    return fail(Status::truncated, "header: expected at least " +
                                       std::to_string(kFixedHeaderBytes) + " bytes, found " +
                                       std::to_string(bytes.size()) + kRemedy);
  }
  FieldReader field(bytes.data() + kStoreMagic.size());
  const uint16_t major = field.u16(), minor = field.u16();
  if (major != kStoreMajor) {
    return fail(Status::unsupported_version,
                "expected a store of version " + std::to_string(kStoreMajor) + ", found " +
                    std::to_string(major) + "." + std::to_string(minor) +
                    ": open it with a newer Isosplat, or rebuild it with this one");
  }
  info.header_bytes = field.u32();
  info.file_bytes = field.u64();
  const uint32_t section_count = field.u32();
  if (info.header_bytes < kFixedHeaderBytes + kHeaderChecksumBytes || info.header_bytes % 8 != 0 ||
      info.header_bytes > kMaxStoreHeaderBytes) {
    return malformed("bytes of the header: expected a multiple of 8 up to " +
                     std::to_string(kMaxStoreHeaderBytes) + ", found " +
                     std::to_string(info.header_bytes));
  }
  if (bytes.size() < info.header_bytes) {
    return fail(Status::truncated, "header: expected " + std::to_string(info.header_bytes) +
                                       " bytes, found " + std::to_string(bytes.size()) + kRemedy);
  }
  const size_t hashed = info.header_bytes - kHeaderChecksumBytes;
  if (checksum64(bytes.first(hashed)) != read_le(bytes.data() + hashed, 8)) {
    return fail(Status::checksum_mismatch,
                std::string("header: its checksum differs from the recorded one") + kRemedy);
  }
  if (info.file_bytes < info.header_bytes || info.file_bytes > kMaxFileBytes) {
    return malformed("bytes of the file: found " + std::to_string(info.file_bytes));
  }
  std::transform(bytes.begin() + kContentIdOffset, bytes.begin() + kContentIdOffset + 16,
                 info.content_id.begin(), [](std::byte b) { return static_cast<uint8_t>(b); });
  return section_count;
}

}  // namespace

Result<StoreHeader> parse_store_header(std::span<const std::byte> bytes) {
  StoreHeader header;
  const auto section_count = parse_fixed_header(bytes, header.info);
  if (!section_count) return tl::unexpected(section_count.error());
  const size_t body_bytes = header.info.header_bytes - kFixedHeaderBytes - kHeaderChecksumBytes;
  auto sections = find_sections(bytes.subspan(kFixedHeaderBytes, body_bytes), *section_count);
  if (!sections) return tl::unexpected(sections.error());
  if (auto parsed = parse_volume(sections->volume, header.info); !parsed) {
    return tl::unexpected(parsed.error());
  }
  if (auto parsed = parse_levels(sections->levels, header); !parsed) {
    return tl::unexpected(parsed.error());
  }
  if (auto parsed = parse_pages(sections->pages, header); !parsed) {
    return tl::unexpected(parsed.error());
  }
  if (sections->metadata.size() > kMaxMetadataBytes) {
    return malformed("metadata: expected at most " + std::to_string(kMaxMetadataBytes) +
                     " bytes, found " + std::to_string(sections->metadata.size()));
  }
  header.info.metadata.assign(reinterpret_cast<const char*>(sections->metadata.data()),
                              sections->metadata.size());
  return header;
}

namespace {

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

void write_levels_section(const StoreHeader& header, FieldWriter& to) {
  to.field(4, kLevelsTag);
  to.field(4, kLevelSectionHeaderBytes + header.levels.size() * kLevelRecordBytes);
  to.field(4, header.levels.size());
  to.field(4, header.page_log2);
  for (const LevelRef& level : header.levels) {
    to.field(8, level.chunks_offset);
    to.field(8, level.chunks_bytes);
    to.field(8, level.chunk_count);
    to.field(2, level.interval.min);
    to.field(2, level.interval.max);
    to.field(4, level.page_count);
  }
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

}  // namespace

Result<std::vector<std::byte>> write_store_header(const StoreHeader& header) {
  const StoreInfo& info = header.info;
  const size_t needed = header_bytes_for(info.grid.voxels, header.page_log2, info.metadata.size());
  if (needed > header.info.header_bytes || header.info.header_bytes % 8 != 0 ||
      header.info.header_bytes > kMaxStoreHeaderBytes || info.metadata.size() > kMaxMetadataBytes) {
    return fail(Status::invalid_argument, "metadata: " + std::to_string(info.metadata.size()) +
                                              " bytes do not fit in a header of " +
                                              std::to_string(header.info.header_bytes));
  }
  std::vector<std::byte> out;
  out.reserve(header.info.header_bytes);
  FieldWriter to(out);
  for (uint8_t byte : kStoreMagic) to.field(1, byte);
  to.field(2, kStoreMajor);
  to.field(2, kStoreMinor);
  to.field(4, header.info.header_bytes);
  to.field(8, info.file_bytes);
  to.field(4, 4);  // sections
  to.field(4, 0);
  for (uint8_t byte : info.content_id) to.field(1, byte);

  write_volume_section(info, to);
  write_levels_section(header, to);
  write_pages_section(header, to);
  out.resize(padded_to_8(out.size()));

  to.field(4, kMetadataTag);
  to.field(4, info.metadata.size());
  const auto* text = reinterpret_cast<const std::byte*>(info.metadata.data());
  out.insert(out.end(), text, text + info.metadata.size());

  const size_t hashed = header.info.header_bytes - kHeaderChecksumBytes;
  out.resize(hashed);
  to.field(8, checksum64(std::span(out).first(hashed)));
  return out;
}

}  // namespace isosplat
