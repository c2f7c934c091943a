#include "tests/server/test_store.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <stdexcept>

#include "shared/core/store/store_writer.h"

namespace isosplat::server::test {
namespace {

template <class T>
T required(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

}  // namespace

const KnownChunk& KnownStore::at(BlockKey block, uint32_t band) const {
  for (const KnownChunk& chunk : chunks) {
    if (chunk.block == block && chunk.band == band) return chunk;
  }
  throw std::runtime_error("no such chunk");
}

std::vector<const KnownChunk*> KnownStore::meeting(uint32_t level, float low, float high) const {
  std::vector<const KnownChunk*> found;
  for (const KnownChunk& chunk : chunks) {
    if (chunk.block.level == level && chunk.cells > 0 &&
        static_cast<float>(chunk.band_begin) <= high && low < static_cast<float>(chunk.band_end)) {
      found.push_back(&chunk);
    }
  }
  return found;
}

KnownStore make_store(uint32_t seed, Index3 voxels, uint32_t largest_chunk,
                      std::string_view metadata) {
  std::mt19937 random(seed);
  const auto number = [&](uint32_t low, uint32_t high) {
    return low + static_cast<uint32_t>(random() % (high - low + 1));
  };
  MemorySink sink;
  KnownStore store;
  StoreWriter writer = required(StoreWriter::create(voxels, 8192, sink));
  for (uint32_t level = 0; level < level_count(voxels); ++level) {
    const LevelGrid grid = level_grid(voxels, level);
    for (int32_t z = 0; z < grid.blocks.z; ++z) {
      for (int32_t y = 0; y < grid.blocks.y; ++y) {
        for (int32_t x = 0; x < grid.blocks.x; ++x) {
          std::vector<BandChunk> bands;
          std::vector<std::byte> bytes;
          const uint32_t min = number(0, 120);
          uint32_t end = min;
          // Some blocks are homogeneous, and have no band.
          const uint32_t count = number(0, 6);
          for (uint32_t band = 0; band < count; ++band) {
            const uint32_t begin = end;
            end += number(1, 20);
            KnownChunk chunk{{level, {x, y, z}}, band, begin, end, 0, {}};
            // The first and last band of a block hold cells; between them there may be gaps.
            if (band == 0 || band + 1 == count || number(0, 4) != 0) {
              const Index3 cells = block_cells(grid, {x, y, z});
              chunk.cells = number(1, static_cast<uint32_t>(cells.x * cells.y * cells.z));
              chunk.bytes.resize(number(1, largest_chunk));
              for (size_t i = 0; i < chunk.bytes.size(); i += 4) {
                const auto four = static_cast<uint32_t>(random());
                std::memcpy(&chunk.bytes[i], &four, std::min<size_t>(4, chunk.bytes.size() - i));
              }
            }
            bytes.insert(bytes.end(), chunk.bytes.begin(), chunk.bytes.end());
            bands.push_back({end, chunk.cells, static_cast<uint32_t>(chunk.bytes.size())});
            store.chunks.push_back(std::move(chunk));
          }
          const CellInterval interval{static_cast<QuantizedValue>(min),
                                      static_cast<QuantizedValue>(end)};
          if (auto added = writer.add_block(interval, bands, bytes); !added) {
            throw std::runtime_error(added.error().message);
          }
        }
      }
    }
  }
  StoreInfo info;
  info.grid.voxels = voxels;
  info.grid.spacing = {1, 1, 2};
  info.mapping = {.offset = -100, .scale = 0.5, .max_error = 0, .bits = 8, .has_missing = false};
  info.range = {0, 255};
  info.metadata = R"({"title":"Test )" + std::to_string(seed) +
                  R"(","source":{"type":"u8"},"histogram":{"low":-100,"high":27.5,"counts":[)";
  for (int i = 0; i < 256; ++i) {
    if (i > 0) info.metadata += ',';
    info.metadata += std::to_string(i);
  }
  info.metadata += "]}}";
  if (!metadata.empty()) info.metadata = metadata;
  store.info = required(writer.finish(info));
  for (const uint8_t byte : store.info.content_id) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    store.content += digits;
  }
  store.file = std::move(sink.bytes);
  return store;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "isosplat-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const std::filesystem::path temporary = path.string() + ".tmp";
  {
    std::ofstream file(temporary, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    if (!file) throw std::runtime_error("cannot write " + temporary.string());
  }
  std::filesystem::rename(temporary, path);
}

void write_file(const std::filesystem::path& path, std::string_view text) {
  write_file(path, std::as_bytes(std::span(text)));
}

}  // namespace isosplat::server::test
