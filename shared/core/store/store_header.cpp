#include "shared/core/store/store_header.h"

#include <algorithm>

#include "shared/core/store/byte_order.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/field_sections.h"
#include "shared/core/store/format.h"
#include "shared/core/store/header_sections.h"

namespace isosplat {
namespace {

/// The payloads of the sections that this version defines; empty if a section is absent.
struct Sections {
  std::span<const std::byte> volume, levels, pages, metadata, fields, own_field;
};

Result<Sections> find_sections(std::span<const std::byte> body, uint32_t count) {
  Sections sections;
  size_t at = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (body.size() - at < kSectionHeaderBytes) {
      return malformed_header("section " + std::to_string(i) + " begins beyond the header's end");
    }
    const auto tag = static_cast<uint32_t>(read_le(body.data() + at, 4));
    const auto bytes = static_cast<size_t>(read_le(body.data() + at + 4, 4));
    at += kSectionHeaderBytes;
    if (bytes > body.size() - at || padded_to_8(bytes) > body.size() - at) {
      return malformed_header("section " + std::to_string(i) + " announces " +
                              std::to_string(bytes) + " bytes, the header has " +
                              std::to_string(body.size() - at));
    }
    const std::span<const std::byte> payload = body.subspan(at, bytes);
    at += padded_to_8(bytes);
    std::span<const std::byte>* known = tag == kVolumeTag      ? &sections.volume
                                        : tag == kLevelsTag    ? &sections.levels
                                        : tag == kPagesTag     ? &sections.pages
                                        : tag == kMetadataTag  ? &sections.metadata
                                        : tag == kFieldListTag ? &sections.fields
                                        : tag == kOwnFieldTag  ? &sections.own_field
                                                               : nullptr;
    if (known) {
      if (known->data()) return malformed_header("section " + std::to_string(i) + " appears twice");
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
                                       std::to_string(bytes.size()) + kHeaderRemedy);
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
    return malformed_header("bytes of the header: expected a multiple of 8 up to " +
                            std::to_string(kMaxStoreHeaderBytes) + ", found " +
                            std::to_string(info.header_bytes));
  }
  if (bytes.size() < info.header_bytes) {
    return fail(Status::truncated, "header: expected " + std::to_string(info.header_bytes) +
                                       " bytes, found " + std::to_string(bytes.size()) +
                                       kHeaderRemedy);
  }
  const size_t hashed = info.header_bytes - kHeaderChecksumBytes;
  if (checksum64(bytes.first(hashed)) != read_le(bytes.data() + hashed, 8)) {
    return fail(Status::checksum_mismatch,
                std::string("header: its checksum differs from the recorded one") + kHeaderRemedy);
  }
  if (info.file_bytes < info.header_bytes || info.file_bytes > kMaxFileBytes) {
    return malformed_header("bytes of the file: found " + std::to_string(info.file_bytes));
  }
  std::transform(bytes.begin() + kContentIdOffset, bytes.begin() + kContentIdOffset + 16,
                 info.content_id.begin(), [](std::byte b) { return static_cast<uint8_t>(b); });
  return section_count;
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

Result<StoreHeader> parse_store_header(std::span<const std::byte> bytes) {
  StoreHeader header;
  const auto section_count = parse_fixed_header(bytes, header.info);
  if (!section_count) return tl::unexpected(section_count.error());
  const size_t body_bytes = header.info.header_bytes - kFixedHeaderBytes - kHeaderChecksumBytes;
  auto sections = find_sections(bytes.subspan(kFixedHeaderBytes, body_bytes), *section_count);
  if (!sections) return tl::unexpected(sections.error());
  if (auto parsed = parse_volume_section(sections->volume, header.info); !parsed) {
    return tl::unexpected(parsed.error());
  }
  if (sections->fields.data()) {
    if (auto parsed = parse_field_list(sections->fields, header.info); !parsed) {
      return tl::unexpected(parsed.error());
    }
  }
  if (sections->own_field.data()) {
    if (auto parsed = parse_own_field(sections->own_field, header.info); !parsed) {
      return tl::unexpected(parsed.error());
    }
  }
  if (auto parsed = parse_levels_section(sections->levels, header); !parsed) {
    return tl::unexpected(parsed.error());
  }
  if (auto parsed = parse_pages_section(sections->pages, header); !parsed) {
    return tl::unexpected(parsed.error());
  }
  if (sections->metadata.size() > kMaxMetadataBytes) {
    return malformed_header("metadata: expected at most " + std::to_string(kMaxMetadataBytes) +
                            " bytes, found " + std::to_string(sections->metadata.size()));
  }
  header.info.metadata.assign(reinterpret_cast<const char*>(sections->metadata.data()),
                              sections->metadata.size());
  return header;
}

Result<std::vector<std::byte>> write_store_header(const StoreHeader& header) {
  const StoreInfo& info = header.info;
  const size_t needed = header_bytes_for(info.grid.voxels, header.page_log2, info.metadata.size()) +
                        field_sections_bytes(info);
  const bool has_fields = !info.fields.empty() || info.field;
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
  to.field(2, has_fields ? kStoreFieldsMinor : kStoreMinor);
  to.field(4, header.info.header_bytes);
  to.field(8, info.file_bytes);
  to.field(4, 4 + !info.fields.empty() + info.field.has_value());  // sections
  to.field(4, 0);
  for (uint8_t byte : info.content_id) to.field(1, byte);

  write_volume_section(info, to);
  write_levels_section(header, to);
  write_pages_section(header, to);
  out.resize(padded_to_8(out.size()));
  write_field_sections(info, to);

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
