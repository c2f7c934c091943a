// Decodes chunks that are in memory to the 16-byte layout of the GPU, on one core:
// isosplat_decode_bench STORE LOW HIGH
// The chunks are those of level 0 that the isovalues from LOW to HIGH need. For each line of
// standard input the program decodes them once, and prints CPU time in seconds and the number of
// samples as a line of JSON.
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "shared/core/codec/chunk_codec.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {
namespace {

/// CPU time of this thread: other programs on the machine do not count.
double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

int report(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message.c_str());
  return 1;
}

int run(const char* path, double low, double high) {
  const auto store = StoreFile::open(path);
  if (!store) return report(store.error());
  const StoreInfo& info = (*store)->info();
  const auto found = (*store)->chunks_for(0, info.mapping.quantized_isovalue(low),
                                          info.mapping.quantized_isovalue(high));
  if (!found) return report(found.error());
  std::vector<std::byte> bytes;
  std::vector<size_t> begin;
  for (const ChunkRef& chunk : found->chunks) {
    begin.push_back(bytes.size());
    if (auto read = (*store)->read_chunk(chunk, bytes); !read) return report(read.error());
  }

  ChunkDecoder decoder;
  std::vector<PackedSample> samples;
  const LevelGrid level = level_grid(info.grid.voxels, 0);
  char line[64];
  while (std::fgets(line, sizeof line, stdin)) {
    size_t count = 0;
    const double before = cpu_seconds();
    for (size_t i = 0; i < begin.size(); ++i) {
      const ChunkRef& chunk = found->chunks[i];
      if (chunk.cells == 0) continue;
      const ChunkShape shape{block_cells(level, chunk.block.index), chunk.band_begin,
                             chunk.band_end, chunk.cells, false};
      const auto chunk_bytes = std::span(bytes).subspan(begin[i], chunk.bytes);
      if (auto done = decoder.decode_packed(chunk_bytes, shape, samples); !done) {
        return report(done.error());
      }
      count += samples.size();
    }
    std::printf("{\"seconds\": %.9f, \"samples\": %zu}\n", cpu_seconds() - before, count);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int count, char** arguments) {
  if (count != 4) {
    std::fprintf(stderr, "usage: isosplat_decode_bench STORE LOW HIGH\n");
    return 2;
  }
  return isosplat::run(arguments[1], std::atof(arguments[2]), std::atof(arguments[3]));
}
