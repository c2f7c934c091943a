// Builds a store from a volume in memory, and prints time, sizes and the bytes that isovalues need
// as one line of JSON:
// isosplat_build_bench VOLUME [--u8 LOW HIGH] [--fetch-weight W] [--threads N] [--runs N]
//                      [isovalue…]
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "native/builder/builder.h"
#include "shared/core/store/store_reader.h"
#include "shared/import/open_volume.h"
#include "tests/bench/build/held_volume.h"

namespace isosplat {
namespace {

/// Converts 16-bit voxels to 8 bits: [low, high] becomes [0, 255].
void squeeze(HeldVolume& volume, double low, double high) {
  const auto* from = reinterpret_cast<const int16_t*>(volume.voxels.data());
  std::vector<std::byte> to(volume.voxels.size() / 2);
  for (size_t i = 0; i < to.size(); ++i) {
    const double v = std::clamp((from[i] - low) / (high - low) * 255, 0.0, 255.0);
    to[i] = static_cast<std::byte>(v);
  }
  volume.voxels = std::move(to);
  volume.header_.type = VoxelType::u8;
}

/// CPU time of this process so far.
double user_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         static_cast<double>(usage.ru_utime.tv_usec) * 1e-6;
}

int generate(const char* path, int32_t nx, int32_t ny, int32_t nz) {
  FILE* file = std::fopen(path, "wb");
  if (!file) return std::perror(path), 1;
  std::vector<uint8_t> slice(static_cast<size_t>(nx) * static_cast<size_t>(ny));
  uint32_t noise = 1;
  for (int32_t z = 0; z < nz; ++z) {
    size_t i = 0;
    for (int32_t y = 0; y < ny; ++y) {
      for (int32_t x = 0; x < nx; ++x, ++i) {
        // Balls on a lattice with a distance of 256 voxels, each with a shell around it, in a noisy
        // background.
        const int32_t dx = (x & 255) - 128, dy = (y & 255) - 128, dz = (z & 255) - 128;
        const int32_t r = (dx * dx + dy * dy + dz * dz) >> 7;
        noise = noise * 1664525u + 1013904223u;
        const int32_t grain = static_cast<int32_t>(noise >> 30);
        slice[i] = static_cast<uint8_t>(r < 80    ? 200 - r / 2 + grain
                                        : r < 110 ? 90 + grain
                                                  : 20 + grain);
      }
    }
    if (std::fwrite(slice.data(), 1, slice.size(), file) != slice.size()) {
      return std::perror(path), 1;
    }
  }
  return std::fclose(file) == 0 ? 0 : 1;
}

struct Options {
  BuildOptions build;
  std::vector<double> isovalues;
  int runs = 1;
  double low = 0, high = 0;  ///< the range of values that becomes 8 bits, if low < high
};

Options parse_options(int count, char** arguments) {
  Options options;
  for (int i = 2; i < count; ++i) {
    const std::string option = arguments[i];
    const auto next = [&] { return std::atof(arguments[++i]); };
    if (option == "--fetch-weight")
      options.build.fetch_weight = next();
    else if (option == "--threads")
      options.build.threads = static_cast<unsigned>(next());
    else if (option == "--runs")
      options.runs = static_cast<int>(next());
    else if (option == "--u8")
      options.low = next(), options.high = next();
    else
      options.isovalues.push_back(std::atof(option.c_str()));
  }
  return options;
}

/// Prints bytes, cells and chunks as the member `name` of a JSON object.
void print_chunks(const std::string& name, const std::vector<ChunkRef>& chunks) {
  size_t bytes = 0, cells = 0;
  for (const ChunkRef& chunk : chunks) {
    bytes += chunk.bytes;
    cells += chunk.cells;
  }
  std::printf(", \"%s\": {\"bytes\": %zu, \"cells\": %zu, \"chunks\": %zu}", name.c_str(), bytes,
              cells, chunks.size());
}

/// Prints the bytes of each level, and those of level 0 for each isovalue.
void print_store(std::span<const std::byte> store, const std::vector<double>& isovalues) {
  auto reader = StoreReader::open(store);
  for (uint32_t i = 0; i < reader->pages().size(); ++i) {
    const PageRef page = reader->pages()[i];
    (void)reader->add_page(i, store.subspan(page.offset, page.bytes));
  }
  for (const LevelRef& level : reader->levels()) {
    print_chunks("level_" + std::to_string(level.grid.level),
                 *reader->chunks_for(level.grid.level, 0, 65535));
  }
  for (const double isovalue : isovalues) {
    const float quantized_isovalue = reader->info().mapping.quantized_isovalue(isovalue);
    char name[40];
    std::snprintf(name, sizeof name, "isovalue_%g", isovalue);
    print_chunks(name, *reader->chunks_for(0, quantized_isovalue, quantized_isovalue));
  }
}

int run(int count, char** arguments) {
  const Options options = parse_options(count, arguments);
  auto held = hold_volume(arguments[1]);
  if (!held) return std::fprintf(stderr, "%s\n", held.error().message.c_str()), 1;
  HeldVolume& volume = *held;
  const Index3 n = volume.header_.grid.voxels;
  if (options.low < options.high) squeeze(volume, options.low, options.high);
  std::vector<double> seconds;
  double user = user_seconds();
  MemorySink sink;
  BuildReport report;
  for (int i = 0; i < options.runs; ++i) {
    sink.bytes.clear();
    auto built = build_store(volume, sink, options.build);
    if (!built) return std::fprintf(stderr, "%s\n", built.error().message.c_str()), 1;
    report = *built;
    seconds.push_back(report.seconds);
  }
  user = (user_seconds() - user) / options.runs;
  const double voxels = static_cast<double>(n.x) * n.y * n.z;
  std::printf("{\"raw_bytes\": %zu, \"store_bytes\": %zu, \"ratio\": %.4f, ", volume.voxels.size(),
              sink.bytes.size(),
              static_cast<double>(sink.bytes.size()) / static_cast<double>(volume.voxels.size()));
  std::printf("\"content_id\": \"");
  for (const uint8_t byte : report.info.content_id) std::printf("%02x", byte);
  std::printf("\", \"user_seconds\": %.3f, \"megavoxels_per_second\": [", user);
  for (size_t i = 0; i < seconds.size(); ++i) {
    std::printf("%s%.2f", i > 0 ? ", " : "", voxels / 1e6 / seconds[i]);
  }
  std::printf("]");
  print_store(sink.bytes, options.isovalues);
  std::printf("}\n");
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int count, char** arguments) {
  if (count < 2) return 2;
  if (count == 6 && std::string_view(arguments[1]) == "--generate") {
    return isosplat::generate(arguments[2], std::atoi(arguments[3]), std::atoi(arguments[4]),
                              std::atoi(arguments[5]));
  }
  return isosplat::run(count, arguments);
}
