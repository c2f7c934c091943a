#include "native/extract/extract_mesh.h"

#include <fmt/format.h>

#include <optional>

#include "native/extract/chunk_reading.h"
#include "shared/core/mesh/mesh_assembly.h"

namespace isosplat {
namespace {

class MeshExtraction {
 public:
  MeshExtraction(const StoreFile& store, float quantized_isovalue, const ExtractOptions& options,
                 std::vector<ChunkRef> chunks)
      : store_(store),
        quantized_isovalue_(quantized_isovalue),
        options_(options),
        chunks_(std::move(chunks)),
        threads_(thread_count(options, chunks_.size())),
        workers_(threads_),
        assembly_(grid_of(store, options), options.level) {
    for (Worker& worker : workers_) {
      worker.mesher.keep_off_lattice_points(options.least_distance);
      if (!options.fields.empty()) worker.fields.emplace(options.fields);
    }
    std::ranges::sort(chunks_, {}, [](const ChunkRef& chunk) {
      const Index3 at = chunk.block.index;
      return std::array{at.z, at.y, at.x};
    });
  }

  Result<MeshCounts> run(const std::function<Result<void>(MeshPart&&)>& write) {
    for (size_t first = 0; first < chunks_.size();) {
      size_t end = first;
      const int32_t z = chunks_[first].block.index.z;
      while (end < chunks_.size() && chunks_[end].block.index.z == z) ++end;
      std::vector<MeshedBlock> layer(end - first);
      if (auto ok = mesh_blocks(first, layer); !ok) return tl::unexpected(ok.error());
      if (auto ok = add(std::move(layer), write); !ok) return tl::unexpected(ok.error());
      first = end;
    }
    if (auto ok = add({}, write); !ok) return tl::unexpected(ok.error());
    return assembly_.counts();
  }

 private:
  struct Worker {
    BlockMesher mesher;
    DecodedCells cells;
    std::optional<FieldReader> fields;  ///< none if no fields are wanted
  };

  /// Meshes the blocks of a layer, whose chunks begin at `first`.
  Result<void> mesh_blocks(size_t first, std::vector<MeshedBlock>& layer) {
    const auto chunks = std::span(chunks_).subspan(first, layer.size());
    return for_each_chunk(store_, chunks, threads_,
                          [&](unsigned thread, ChunkDecoder& decoder,
                              std::span<const std::byte> bytes, size_t i) -> Result<void> {
                            Worker& worker = workers_[thread];
                            const ChunkShape shape = shape_of(store_.info(), chunks[i]);
                            auto decoded = decode_cells(decoder, bytes, chunks[i], shape, options_,
                                                        worker.cells,
                                                        worker.fields ? &*worker.fields : nullptr);
                            if (!decoded) return decoded;
                            MeshedBlock& block = layer[i];
                            block.origin = origin_of(chunks[i].block);
                            worker.mesher.run(worker.cells, shape.block_cells, block.origin,
                                              quantized_isovalue_, block.mesh);
                            if (worker.fields) {
                              block.mesh.fields = worker.fields->at(block.mesh.vertices);
                            }
                            return {};
                          });
  }

  /// Adds a layer, and writes the previous one.
  Result<void> add(std::vector<MeshedBlock> layer,
                   const std::function<Result<void>(MeshPart&&)>& write) {
    if (auto added = assembly_.add_layer(std::move(layer)); !added) {
      return fail(added.error().status,
                  fmt::format("{}: {}", store_.path().string(), added.error().message));
    }
    std::vector<MeshPart> parts(assembly_.complete_parts());
    parallel_for(threads_, parts.size(),
                 [&](unsigned, size_t i) { parts[i] = assembly_.take_part(i); });
    assembly_.drop_complete();
    for (MeshPart& part : parts) {
      if (auto written = write(std::move(part)); !written) return written;
    }
    return {};
  }

  const StoreFile& store_;
  float quantized_isovalue_;
  const ExtractOptions& options_;
  std::vector<ChunkRef> chunks_;
  unsigned threads_;
  std::vector<Worker> workers_;
  MeshAssembly assembly_;
};

}  // namespace

Result<MeshCounts> extract_mesh(const StoreFile& store, double isovalue,
                                const ExtractOptions& options,
                                const std::function<Result<void>(MeshPart&&)>& write) {
  return catch_out_of_memory(store, [&]() -> Result<MeshCounts> {
    auto chunks = chunks_of(store, isovalue, options);
    if (!chunks) return tl::unexpected(chunks.error());
    MeshExtraction extraction(store, store.info().mapping.quantized_isovalue(isovalue), options,
                              std::move(*chunks));
    return extraction.run(write);
  });
}

}  // namespace isosplat
