// Hostile stores: headers and pages with wrong fields, but correct checksums.
#include <cstdlib>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/field_sections.h"
#include "shared/core/store/store_header.h"
#include "tests/fuzz/edits.h"
#include "tests/shared/store_fixture.h"

namespace isosplat {
namespace {

std::vector<std::byte> make_valid_store() {
  constexpr Index3 kVoxels{70, 9, 6};
  const auto levels = fixture::make_levels(kVoxels, [&](int32_t x, int32_t y, int32_t z) {
    return fixture::rough_ball(kVoxels, x, y, z);
  });
  return fixture::make_store(levels, 40);
}

/// The header of a store with two fields of `bytes` bytes each, before its other bytes.
StoreHeader with_fields(StoreHeader header, uint64_t bytes) {
  StoreInfo& info = header.info;
  for (const char* name : {"temperature", "t"}) {
    FieldRef field;
    field.info.name = name;
    field.info.range = {3, 200};
    field.bytes = bytes;
    info.fields.push_back(field);
  }
  const auto added = static_cast<uint32_t>(field_sections_bytes(info));
  info.header_bytes += added;
  info.file_bytes += added + 2 * bytes;
  for (LevelRef& level : header.levels) level.chunks_offset += added + 2 * bytes;
  return header;
}

/// Does what clients do with a store: reads the header, adds all pages, searches and decodes
/// chunks; and the same with its fields.
void read_store(std::span<const std::byte> header, std::span<const std::byte> file,
                StoreKind kind = StoreKind::store) {
  auto reader = StoreReader::open(header, kind);
  if (!reader) return;
  for (const FieldRef& field : reader->info().fields) {
    if (field.offset > file.size() || field.bytes > file.size() - field.offset) continue;
    const auto of_field = file.subspan(field.offset, field.bytes);
    read_store(of_field.first(std::min(of_field.size(), kMaxStoreHeaderBytes)), of_field,
               StoreKind::field);
  }
  for (uint32_t p = 0; p < reader->pages().size(); ++p) {
    const PageRef page = reader->pages()[p];
    if (page.offset > file.size() || page.bytes > file.size() - page.offset) continue;
    if (!reader->add_page(p, file.subspan(page.offset, page.bytes))) continue;
    static ChunkDecoder decoder;
    static DecodedCells cells;
    const BlockKey key{page.level, page.first_block};
    for (const float quantized_isovalue : {0.0f, 50.5f, 99.5f, 65535.0f}) {
      const auto chunk = reader->chunk_for(key, quantized_isovalue);
      if (!chunk || !*chunk) continue;
      const ChunkRef& ref = **chunk;
      if (!(quantized_isovalue >= float(ref.band_begin) &&
            quantized_isovalue < float(ref.band_end)))
        std::abort();
      if (ref.offset > file.size() || ref.bytes > file.size() - ref.offset) continue;
      const LevelGrid grid = level_grid(reader->info().grid.voxels, page.level);
      const ChunkShape shape{block_cells(grid, key.index), ref.band_begin, ref.band_end, ref.cells,
                             page.level > 0};
      static_cast<void>(decoder.decode(file.subspan(ref.offset, ref.bytes), shape, cells));
    }
  }
  for (uint32_t level = 0; level < reader->info().levels; ++level) {
    const auto chunks = reader->chunks_for(level, 20.5f, 70.5f);
    if (chunks.has_value() != reader->missing_pages(level, 20.5f, 70.5f).empty()) std::abort();
  }
}

}  // namespace
}  // namespace isosplat

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isosplat;
  static const std::vector<std::byte> valid = make_valid_store();
  static const StoreHeader header = *parse_store_header(valid);
  fuzz::Input input(data, size);
  std::vector<std::byte> store = valid;
  switch (input.number(1) % 5) {
    case 0:  // any bytes
      read_store(input.rest(), valid);
      break;
    case 1: {  // a header with wrong fields and a correct checksum
      const std::span<std::byte> bytes(store.data(), header.info.header_bytes);
      fuzz::edit(bytes.first(bytes.size() - 8), input);
      const uint64_t checksum = checksum64(bytes.first(bytes.size() - 8));
      for (size_t i = 0; i < 8; ++i) {
        bytes[bytes.size() - 8 + i] = static_cast<std::byte>(checksum >> (8 * i));
      }
      read_store(bytes, store);
      break;
    }
    case 2: {  // a page with wrong fields and a correct checksum
      StoreHeader changed = header;
      PageRef& page = changed.pages[input.number(1) % changed.pages.size()];
      const std::span<std::byte> bytes(store.data() + page.offset, page.bytes);
      fuzz::edit(bytes, input);
      page.checksum = checksum32(bytes);
      const auto written = write_store_header(changed);
      if (written) read_store(*written, store);
      break;
    }
    case 3: {  // a list of fields with wrong entries and a correct checksum
      std::vector<std::byte> bytes = *write_store_header(with_fields(header, 100));
      fuzz::edit(std::span(bytes).first(bytes.size() - 8), input);
      const uint64_t checksum = checksum64(std::span(bytes).first(bytes.size() - 8));
      for (size_t i = 0; i < 8; ++i) {
        bytes[bytes.size() - 8 + i] = static_cast<std::byte>(checksum >> (8 * i));
      }
      read_store(bytes, store);
      break;
    }
    default:  // damage at any position, which the checksums detect
      store.resize(store.size() - input.number(2) % store.size());
      fuzz::edit(store, input);
      read_store(std::span(store).first(std::min(store.size(), kMaxStoreHeaderBytes)), store);
  }
  return 0;
}
