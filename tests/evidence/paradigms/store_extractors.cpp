// Paradigms (A) and (B): samples were generated when the store was built.
#include "native/builder/array_source.h"
#include "native/extract/chunk_reading.h"
#include "native/extract/extract.h"
#include "tests/evidence/paradigms/extractors.h"

namespace isosplat {
namespace {

class StoreExtractor : public Extractor {
 public:
  StoreExtractor(std::shared_ptr<StoreFile> store, bool count_cells)
      : store_(std::move(store)), count_cells_(count_cells) {}

  uint64_t prepared_bytes() const override { return std::filesystem::file_size(store_->path()); }

 protected:
  /// Counts the active ones of the cells of a chunk.
  void count(const DecodedCells& cells, BlockKey block, float quantized_isovalue,
             Extraction& extraction) const {
    for (size_t i = 0; i < cells.cell.size(); ++i) {
      if (!is_active(cells.interval[i], quantized_isovalue)) continue;
      ++extraction.active_cells;
      const uint32_t at = cells.cell[i];
      const auto place = [&](int32_t index, uint32_t in_block) {
        return index * kBlockCells + static_cast<int32_t>(in_block & 63);
      };
      extraction.cells_hash += hash_of({place(block.index.x, at), place(block.index.y, at >> 6),
                                        place(block.index.z, at >> 12)});
    }
  }

  std::shared_ptr<StoreFile> store_;
  bool count_cells_;
};

/// Decodes samples, and projects them.
class StorePoints : public StoreExtractor {
 public:
  using StoreExtractor::StoreExtractor;

  Extraction extract(double isovalue) override {
    points_.clear();
    Extraction extraction;
    const StoreInfo& info = store_->info();
    const float quantized = info.mapping.quantized_isovalue(isovalue);
    const auto chunks = expect(chunks_of(*store_, isovalue, {}));
    expect(for_each_chunk(*store_, chunks, 1,
                          [&](unsigned, ChunkDecoder& decoder, std::span<const std::byte> bytes,
                              size_t i) -> Result<void> {
                            auto decoded = decoder.decode(bytes, shape_of(info, chunks[i]), cells_);
                            if (!decoded) return decoded;
                            const BlockKey block = chunks[i].block;
                            points_.push_back(project_samples(
                                cells_, {&info.grid, &info.mapping, block}, quantized, {}));
                            extraction.bytes += bytes_of(points_.back());
                            if (count_cells_) {
                              count(cells_, block, quantized, extraction);
                            } else {
                              extraction.active_cells += points_.back().positions.size();
                            }
                            return {};
                          }));
    return extraction;
  }

 private:
  DecodedCells cells_;
  std::vector<PointArrays> points_;
};

/// Decodes samples into the layout of the GPU.
class StoreSamples : public StoreExtractor {
 public:
  using StoreExtractor::StoreExtractor;

  Extraction extract(double isovalue) override {
    expect(extract_samples(*store_, isovalue, {.threads = 1}, chunks_));
    Extraction extraction;
    const float quantized = store_->info().mapping.quantized_isovalue(isovalue);
    for (const ChunkSamples& chunk : chunks_) {
      extraction.bytes += chunk.samples.size() * sizeof(PackedSample);
      if (!count_cells_) continue;
      count(cells_of(chunk.samples, RegionMask::all()), chunk.chunk.block, quantized, extraction);
    }
    return extraction;
  }

 private:
  std::vector<ChunkSamples> chunks_;
};

}  // namespace

std::unique_ptr<Extractor> make_store_extractor(Paradigm paradigm, const TestVolume& volume,
                                                const std::filesystem::path& folder,
                                                bool count_cells) {
  const auto path = folder / "paradigms.isosplat";
  if (!std::filesystem::exists(path)) {
    expect(build_store_file<QuantizedValue>(volume.grid, volume.quantized_values, path));
  }
  auto store = expect(StoreFile::open(path));
  if (paradigm == Paradigm::a) return std::make_unique<StorePoints>(std::move(store), count_cells);
  return std::make_unique<StoreSamples>(std::move(store), count_cells);
}

}  // namespace isosplat
