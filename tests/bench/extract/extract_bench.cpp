// Extracts isosurfaces from an open store:
// isosplat_extract_bench STORE THREADS [mesh | points | smooth_points]
// Reads isovalues from standard input, one a line, and prints a line of JSON for each: the seconds
// from the directory look-up to samples in the GPU's layout, and the number of samples. With
// "mesh": to triangles with normals, and their number. With "points": to points with the normals of
// their cells, and with "smooth_points" to points with smooth normals; and their number.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "native/extract/extract.h"
#include "native/extract/extract_mesh.h"

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::shared_ptr<isosplat::StoreFile> open_store(const char* path) {
  auto store = isosplat::StoreFile::open(path);
  if (store) return std::move(*store);
  std::fprintf(stderr, "%s\n", store.error().message.c_str());
  std::exit(1);
}

int run_meshes(const char* path, unsigned threads) {
  const auto store = open_store(path);
  char line[64];
  while (std::fgets(line, sizeof line, stdin)) {
    const double isovalue = std::atof(line);
    std::vector<isosplat::MeshPart> parts;
    const auto begin = Clock::now();
    const auto counts =
        isosplat::extract_mesh(*store, isovalue, {0, threads}, [&](isosplat::MeshPart&& part) {
          parts.push_back(std::move(part));
          return isosplat::Result<void>{};
        });
    const double seconds = seconds_since(begin);
    if (!counts) {
      std::fprintf(stderr, "%s\n", counts.error().message.c_str());
      return 1;
    }
    const uint64_t bytes = counts->vertices * (sizeof(isosplat::Vec3d) + sizeof(isosplat::Vec3f)) +
                           counts->triangles * 12;
    std::printf("{\"seconds\": %.9f, \"vertices\": %llu, \"triangles\": %llu, \"bytes\": %llu}\n",
                seconds, static_cast<unsigned long long>(counts->vertices),
                static_cast<unsigned long long>(counts->triangles),
                static_cast<unsigned long long>(bytes));
    std::fflush(stdout);
  }
  return 0;
}

int run_points(const char* path, unsigned threads, bool smooth_normals) {
  const auto store = open_store(path);
  char line[64];
  while (std::fgets(line, sizeof line, stdin)) {
    const double isovalue = std::atof(line);
    std::vector<isosplat::PointArrays> parts;
    isosplat::ExtractOptions options;
    options.threads = threads;
    options.smooth_normals = smooth_normals;
    const auto begin = Clock::now();
    const auto count =
        isosplat::extract_points(*store, isovalue, {}, options, [&](isosplat::PointArrays&& part) {
          parts.push_back(std::move(part));
          return isosplat::Result<void>{};
        });
    const double seconds = seconds_since(begin);
    if (!count) {
      std::fprintf(stderr, "%s\n", count.error().message.c_str());
      return 1;
    }
    const uint64_t bytes = *count * (sizeof(isosplat::Vec3d) + sizeof(isosplat::Vec3f));
    std::printf("{\"seconds\": %.9f, \"points\": %llu, \"bytes\": %llu}\n", seconds,
                static_cast<unsigned long long>(*count), static_cast<unsigned long long>(bytes));
    std::fflush(stdout);
  }
  return 0;
}

int run(const char* path, unsigned threads) {
  const auto store = open_store(path);
  std::vector<isosplat::ChunkSamples> chunks;
  char line[64];
  while (std::fgets(line, sizeof line, stdin)) {
    const double isovalue = std::atof(line);
    const auto begin = Clock::now();
    const auto done = isosplat::extract_samples(*store, isovalue, {0, threads}, chunks);
    const double seconds = seconds_since(begin);
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
        seconds, chunks.size(), samples, samples * sizeof(isosplat::PackedSample), fetched);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  const std::string_view form = count == 4 ? arguments[3] : "";
  const bool is_known = form == "mesh" || form == "points" || form == "smooth_points";
  if (count != 3 && !is_known) {
    std::fprintf(stderr,
                 "usage: isosplat_extract_bench STORE THREADS [mesh | points | smooth_points]\n");
    return 2;
  }
  const auto threads = static_cast<unsigned>(std::atoi(arguments[2]));
  if (form == "mesh") return run_meshes(arguments[1], threads);
  if (is_known) return run_points(arguments[1], threads, form == "smooth_points");
  return run(arguments[1], threads);
}
