#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/store/store_reader.h"

namespace isosplat::server::test {

/// A chunk of a test store.
struct KnownChunk {
  BlockKey block;
  uint32_t band = 0;
  uint32_t band_begin = 0;
  uint32_t band_end = 0;
  uint32_t cells = 0;  ///< 0: a gap, without bytes
  std::vector<std::byte> bytes;
};

/// A store with chunks of random bytes (a server never decodes them), and a list of its content.
struct KnownStore {
  std::vector<std::byte> file;
  StoreInfo info;
  std::string content;             ///< hexadecimal content id
  std::vector<KnownChunk> chunks;  ///< in file order

  const KnownChunk& at(BlockKey block, uint32_t band) const;

  /// Finds by brute force every chunk of the level that has bytes, and whose band overlaps [low,
  /// high] (quantized isovalues).
  std::vector<const KnownChunk*> meeting(uint32_t level, float low, float high) const;
};

/// The same arguments give the same store. `largest_chunk`: bytes. `metadata`: "" for a title, a
/// source and a histogram.
KnownStore make_store(uint32_t seed, Index3 voxels = {200, 140, 70}, uint32_t largest_chunk = 3000,
                      std::string_view metadata = "");

/// A new folder, which is removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Writes a new file and renames it to `path`, as a build does.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace isosplat::server::test
