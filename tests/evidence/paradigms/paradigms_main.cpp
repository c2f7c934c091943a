// Extracts isosurfaces in one of the paper's paradigms, on one thread:
// isosplat_paradigms VOLUME a|b|c|d|mc FOLDER RUNS ISOVALUE…
// Prints a line of JSON for each isovalue, with the seconds of each run except the first, and then
// a line with the peak memory since preprocessing. FOLDER: for the store of (A) and (B). It is
// built before the measurement.
#include <malloc.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>

#include "tests/bench/render/volume.h"
#include "tests/evidence/paradigms/paradigms.h"

namespace isosplat {
namespace {

std::optional<Paradigm> paradigm_of(std::string_view name) {
  for (size_t i = 0; i < kParadigmNames.size(); ++i) {
    if (kParadigmNames[i] == name) return static_cast<Paradigm>(i);
  }
  return std::nullopt;
}

/// Resets the peak memory: peak_bytes() then covers only later allocations (proc(5), clear_refs).
void forget_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;
}

uint64_t peak_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::strtoull(line.c_str() + 6, nullptr, 10) * 1024;
  }
  return 0;
}

int run(int argc, char** argv) {
  const auto paradigm = argc > 5 ? paradigm_of(argv[2]) : std::nullopt;
  if (!paradigm) {
    std::fprintf(stderr, "usage: isosplat_paradigms VOLUME a|b|c|d|mc FOLDER RUNS ISOVALUE…\n");
    return 2;
  }
  TestVolume volume = load_volume(argv[1]);
  const double offset = volume.mapping.offset;
  const auto extractor = make_extractor(*paradigm, volume, argv[3], false);
  const bool has_store = *paradigm == Paradigm::a || *paradigm == Paradigm::b;
  if (has_store) volume.quantized_values = {};
  forget_peak();
  const int runs = std::atoi(argv[4]);
  for (int i = 5; i < argc; ++i) {
    const double isovalue = std::atof(argv[i]);
    Extraction extraction;
    std::printf("{\"isovalue\": %g, \"seconds\": [", isovalue);
    for (int repeat = -1; repeat < runs; ++repeat) {
      const auto begin = std::chrono::steady_clock::now();
      extraction = extractor->extract(isovalue - offset);
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      if (repeat >= 0) std::printf("%s%.6f", repeat > 0 ? ", " : "", seconds.count());
    }
    std::printf("], \"active\": %llu, \"bytes\": %llu}\n",
                static_cast<unsigned long long>(extraction.active_cells),
                static_cast<unsigned long long>(extraction.bytes));
  }
  std::printf("{\"prepared\": %llu, \"peak\": %llu}\n",
              static_cast<unsigned long long>(extractor->prepared_bytes()),
              static_cast<unsigned long long>(peak_bytes()));
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
