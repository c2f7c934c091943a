// Extracts isosurfaces from an open store:
// isosplat_extract_bench STORE THREADS
// For each isovalue, a line of standard input, the program prints a line of JSON: the seconds from
// the directory look-up to samples in the GPU's layout, and their number.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "native/extract/extract.h"

namespace {

int run(const char* path, unsigned threads) {
  const auto store = isosplat::StoreFile::open(path);
  if (!store) {
    std::fprintf(stderr, "%s\n", store.error().message.c_str());
    return 1;
  }
  std::vector<isosplat::ChunkSamples> chunks;
  char line[64];
  while (std::fgets(line, sizeof line, stdin)) {
    const double isovalue = std::atof(line);
    const auto begin = std::chrono::steady_clock::now();
    const auto done = isosplat::extract_samples(**store, isovalue, {0, threads}, chunks);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    if (!done) {
      std::fprintf(stderr, "%s\n", done.error().message.c_str());
      return 1;
    }
    size_t samples = 0, fetched = 0;
    for (const auto& chunk : chunks) {
      samples += chunk.samples.size();
      fetched += chunk.chunk.bytes;
    }
    std::printf(
        "{\"seconds\": %.9f, \"chunks\": %zu, \"samples\": %zu, \"bytes\": %zu, \"read\": %zu}\n",
        seconds.count(), chunks.size(), samples, samples * sizeof(isosplat::PackedSample), fetched);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) {
    std::fprintf(stderr, "usage: isosplat_extract_bench STORE THREADS\n");
    return 2;
  }
  return run(arguments[1], static_cast<unsigned>(std::atoi(arguments[2])));
}
