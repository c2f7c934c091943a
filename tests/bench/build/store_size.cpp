// Compares the size of a store, and of the chunks of one isovalue, with the size of the volume if
// it is compressed as a whole. Prints one line of JSON.
//
//   isosplat_store_size_bench VOLUME [--fetch-weight W] [--quantized-values FILE]
//
// Writes the quantized values of all voxels to FILE, as input for other compressors.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "native/builder/builder.h"
#include "native/builder/survey.h"
#include "shared/core/builder/scan_volume.h"
#include "shared/core/codec/cell_mask.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/preprocess/quantization.h"
#include "shared/core/store/store_reader.h"
#include "tests/bench/build/held_volume.h"

namespace isosplat {
namespace {

/// A sum for each quantized value. Call add() for ranges of values, then sum() once.
class PerValue {
 public:
  void add(uint32_t begin, uint32_t end, uint64_t amount) {
    change_[begin] += amount;
    change_[end] -= amount;
  }
  std::vector<uint64_t> sum() const {
    std::vector<uint64_t> sums(65536);
    uint64_t running = 0;
    for (size_t quantized = 0; quantized < sums.size(); ++quantized)
      sums[quantized] = running += change_[quantized];
    return sums;
  }

 private:
  std::vector<uint64_t> change_ = std::vector<uint64_t>(65537);
};

/// The first voxel of each piece of an axis. Pieces do not overlap. Each piece has 64 voxels,
/// except the last one, which has 2 to 65.
std::vector<int32_t> pieces(int32_t voxels) {
  std::vector<int32_t> begins{0};
  while (voxels - begins.back() > kBlockCells + 1) begins.push_back(begins.back() + kBlockCells);
  begins.push_back(voxels);
  return begins;
}

/// Bytes of the whole volume in chunks that contain all cells: pieces of 64³ voxels, each encoded
/// once with the store's predictor and entropy coder. Each mask consists of ones, and takes a few
/// bytes.
uint64_t lossless_bytes(const std::vector<QuantizedValue>& quantized_values, Index3 n) {
  ChunkEncoder encoder;
  std::vector<std::byte> out;
  uint64_t bytes = 0;
  const auto xs = pieces(n.x), ys = pieces(n.y), zs = pieces(n.z);
  std::vector<QuantizedValue> voxels;
  const auto mask = std::make_unique<CellMask>();
  for (size_t k = 0; k + 1 < zs.size(); ++k) {
    for (size_t j = 0; j + 1 < ys.size(); ++j) {
      for (size_t i = 0; i + 1 < xs.size(); ++i) {
        const Index3 cells{xs[i + 1] - xs[i] - 1, ys[j + 1] - ys[j] - 1, zs[k + 1] - zs[k] - 1};
        voxels.clear();
        QuantizedValue low = 65535, high = 0;
        for (int32_t z = zs[k]; z < zs[k + 1]; ++z) {
          for (int32_t y = ys[j]; y < ys[j + 1]; ++y) {
            for (int32_t x = xs[i]; x < xs[i + 1]; ++x) {
              const QuantizedValue quantized =
                  quantized_values[(static_cast<size_t>(z) * static_cast<size_t>(n.y) +
                                    static_cast<size_t>(y)) *
                                       static_cast<size_t>(n.x) +
                                   static_cast<size_t>(x)];
              voxels.push_back(quantized);
              low = std::min(low, quantized);
              high = std::max(high, quantized);
            }
          }
        }
        mask->clear();
        for (int32_t z = 0; z < cells.z; ++z) {
          for (int32_t y = 0; y < cells.y; ++y) mask->row(y, z) = valid_cells(cells.x);
        }
        out.clear();
        encoder.encode({cells, voxels.data(), nullptr, false, nullptr}, *mask, low, high + 1u, out);
        bytes += out.size();
      }
    }
  }
  return bytes;
}

int fail_with(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message.c_str());
  return 1;
}

/// Writes the quantized values of all voxels, as in the store.
template <class T>
std::vector<T> quantized_values_of(const HeldVolume& volume, const Quantization& quantization) {
  std::vector<T> quantized_values(volume.voxels.size() / voxel_bytes(volume.header_.type));
  quantization.encode(volume.voxels, quantized_values.data());
  return quantized_values;
}

/// Opens a store in memory, with all directory pages.
Result<StoreReader> open_store(std::span<const std::byte> store) {
  auto reader = StoreReader::open(store);
  if (!reader) return reader;
  for (uint32_t i = 0; i < reader->pages().size(); ++i) {
    const PageRef page = reader->pages()[i];
    const auto bytes = store.subspan(page.offset, page.bytes);
    if (auto added = reader->add_page(i, bytes); !added) return tl::unexpected(added.error());
  }
  return reader;
}

/// Means over the isovalues in the middle between two quantized values of the range.
struct Means {
  double even[2] = {};                       ///< bytes for an isovalue: level 0, coarser levels
  double by_active[2] = {};                  ///< the same, weighted by the number of active cells
  double fetched_cells_per_active_cell = 0;  ///< at level 0
  uint64_t coarse_bytes = 0;                 ///< chunks of coarser levels
};

/// active: cells of level 0 at each of these isovalues.
Result<Means> means_of(const StoreReader& reader, const std::vector<uint64_t>& active) {
  const uint32_t low = reader.info().range.min, high = reader.info().range.max;
  Means means;
  double all_active = 0, all_fetched = 0;
  for (uint32_t quantized = low; quantized < high; ++quantized)
    all_active += double(active[quantized - low]);
  for (const LevelRef& level : reader.levels()) {
    PerValue bytes, cells;
    const auto chunks = reader.chunks_for(level.grid.level, 0, 65535);
    if (!chunks) return tl::unexpected(chunks.error());
    for (const ChunkRef& chunk : *chunks) {
      bytes.add(chunk.band_begin, chunk.band_end, chunk.bytes);
      cells.add(chunk.band_begin, chunk.band_end, chunk.cells);
    }
    const bool is_coarse = level.grid.level > 0;
    if (is_coarse) means.coarse_bytes += level.chunks_bytes;
    const auto bytes_at = bytes.sum(), cells_at = cells.sum();
    for (uint32_t quantized = low; quantized < high; ++quantized) {
      means.even[is_coarse] += double(bytes_at[quantized]) / (high - low);
      means.by_active[is_coarse] +=
          double(bytes_at[quantized]) * double(active[quantized - low]) / all_active;
      if (!is_coarse) all_fetched += double(cells_at[quantized]);
    }
  }
  means.fetched_cells_per_active_cell = all_fetched / all_active;
  return means;
}

/// The quantized values of all voxels: as they are stored, and as 16-bit numbers.
struct Quantized {
  std::vector<std::byte> stored;
  std::vector<QuantizedValue> values;
};

Result<Quantized> quantize(HeldVolume& source, uint8_t bits) {
  SerialExecutor executor;
  const auto scan = scan_volume(source, executor, true, [](uint64_t) {});
  if (!scan) return tl::unexpected(scan.error());
  const auto quantization = choose_quantization(source.header(), *scan);
  if (!quantization) return tl::unexpected(quantization.error());
  Quantized result;
  const auto keep = [&](const auto& values) {
    const auto bytes = std::as_bytes(std::span(values));
    result.stored.assign(bytes.begin(), bytes.end());
    result.values.assign(values.begin(), values.end());
  };
  if (bits == 8) {
    keep(quantized_values_of<uint8_t>(source, *quantization));
  } else {
    keep(quantized_values_of<QuantizedValue>(source, *quantization));
  }
  return result;
}

bool write_bytes(const char* path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  if (file.flush()) return true;
  std::fprintf(stderr, "%s: cannot be written\n", path);
  return false;
}

int run(int count, char** arguments) {
  BuildOptions options;
  const char* quantized_file = nullptr;
  for (int i = 2; i + 1 < count; i += 2) {
    const std::string option = arguments[i];
    if (option == "--fetch-weight") options.fetch_weight = std::atof(arguments[i + 1]);
    if (option == "--quantized-values") quantized_file = arguments[i + 1];
  }
  const auto volume = hold_volume(arguments[1]);
  if (!volume) return fail_with(volume.error());
  HeldVolume source = *volume;
  MemorySink sink;
  if (auto built = build_store(source, sink, options); !built) return fail_with(built.error());
  const auto survey = survey_volume(source);
  if (!survey) return fail_with(survey.error());
  const auto reader = open_store(sink.bytes);
  if (!reader) return fail_with(reader.error());
  const StoreInfo& info = reader->info();
  const uint32_t low = info.range.min, high = info.range.max;
  if (low == high) return std::fprintf(stderr, "the volume has a single value\n"), 1;
  const auto means = means_of(*reader, survey->statistics.active_cells({low, 1, high - low + 1}));
  if (!means) return fail_with(means.error());
  const auto quantized = quantize(source, info.mapping.bits);
  if (!quantized) return fail_with(quantized.error());
  if (quantized_file && !write_bytes(quantized_file, quantized->stored)) return 1;
  std::printf(
      "{\"raw_bytes\": %zu, \"store_bytes\": %zu, \"coarse_bytes\": %llu, \"isovalue_bytes\": "
      "%.0f, \"isovalue_bytes_of_level_0\": %.0f, \"isovalue_bytes_by_active_cells\": %.0f, "
      "\"fetched_cells_per_active_cell\": %.3f, \"whole_bytes\": %llu}\n",
      quantized->stored.size(), sink.bytes.size(),
      static_cast<unsigned long long>(means->coarse_bytes), means->even[0] + means->even[1],
      means->even[0], means->by_active[0] + means->by_active[1],
      means->fetched_cells_per_active_cell,
      static_cast<unsigned long long>(lossless_bytes(quantized->values, info.grid.voxels)));
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int count, char** arguments) {
  return count < 2 ? 2 : isosplat::run(count, arguments);
}
