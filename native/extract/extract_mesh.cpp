#include "native/extract/extract_mesh.h"

#include <fmt/format.h>

#include <boost/unordered/unordered_flat_map.hpp>
#include <limits>

#include "native/extract/chunk_reading.h"
#include "shared/mesh/block_mesh.h"

namespace isosplat {
namespace {

/// The number of a vertex at the border of blocks in the whole mesh, and its gradient so far.
struct SharedVertex {
  uint32_t number = 0;
  Vec3f gradient;
};

/// A vertex of a block that an earlier block has as well, or that later ones may have.
struct BorderNumber {
  uint32_t vertex = 0;  ///< in the block
  uint32_t shared = 0;  ///< index of its SharedVertex in the layer
  bool is_new = false;  ///< this block has it first
};

struct NumberedBlock {
  Index3 origin;
  BlockMesh mesh;
  std::vector<BorderNumber> border;
  uint32_t first_number = 0;  ///< of its new vertices, which are numbered in order
};

/// One layer of blocks. Its vertices on the lattice plane above it are shared with the next layer.
struct MeshLayer {
  std::vector<NumberedBlock> blocks;
  std::vector<SharedVertex> shared;
  boost::unordered_flat_map<uint64_t, uint32_t> found;  ///< index in `shared` by LatticeEdge::key
};

/// The new vertices of a block, in order, each with its index in the block.
template <class Use>
void for_each_new_vertex(const NumberedBlock& block, const Use& use) {
  size_t next = 0;
  for (uint32_t v = 0; v < block.mesh.vertices.size(); ++v) {
    const BorderNumber* border = nullptr;
    if (next < block.border.size() && block.border[next].vertex == v)
      border = &block.border[next++];
    if (!border || border->is_new) use(v, border);
  }
}

class MeshExtraction {
 public:
  MeshExtraction(const StoreFile& store, float quantized_isovalue, const ExtractOptions& options,
                 std::vector<ChunkRef> chunks)
      : store_(store),
        grid_(store.info().grid),
        is_mirrored_(determinant(grid_.direction) < 0),
        quantized_isovalue_(quantized_isovalue),
        level_(options.level),
        chunks_(std::move(chunks)),
        threads_(thread_count(options, chunks_.size())),
        workers_(threads_) {
    std::ranges::sort(chunks_, {}, [](const ChunkRef& chunk) {
      const Index3 at = chunk.block.index;
      return std::array{at.z, at.y, at.x};
    });
  }

  Result<MeshCounts> run(const std::function<Result<void>(MeshPart&&)>& write) {
    MeshLayer below;
    for (size_t first = 0; first < chunks_.size();) {
      size_t end = first;
      const int32_t z = chunks_[first].block.index.z;
      while (end < chunks_.size() && chunks_[end].block.index.z == z) ++end;
      MeshLayer layer;
      if (auto ok = mesh_blocks(first, end, layer); !ok) return tl::unexpected(ok.error());
      if (auto ok = number(layer, below, z); !ok) return tl::unexpected(ok.error());
      if (auto ok = write_layer(below, write); !ok) return tl::unexpected(ok.error());
      below = std::move(layer);
      first = end;
    }
    if (auto ok = write_layer(below, write); !ok) return tl::unexpected(ok.error());
    return counts_;
  }

 private:
  struct Worker {
    BlockMesher mesher;
    DecodedCells cells;
  };

  Result<void> mesh_blocks(size_t first, size_t end, MeshLayer& layer) {
    const auto chunks = std::span(chunks_).subspan(first, end - first);
    layer.blocks.resize(chunks.size());
    return for_each_chunk(
        store_, chunks, threads_,
        [&](unsigned thread, ChunkDecoder& decoder, std::span<const std::byte> bytes,
            size_t i) -> Result<void> {
          Worker& worker = workers_[thread];
          const ChunkShape shape = shape_of(store_.info(), chunks[i]);
          auto decoded = decoder.decode(bytes, shape, worker.cells);
          if (!decoded) return decoded;
          NumberedBlock& block = layer.blocks[i];
          const Index3 at = chunks[i].block.index;
          block.origin = {at.x * kBlockCells, at.y * kBlockCells, at.z * kBlockCells};
          worker.mesher.run(worker.cells, shape.block_cells, block.origin, quantized_isovalue_,
                            block.mesh);
          return {};
        });
  }

  /// Numbers the vertices of a layer, and adds its gradients to those of vertices that the layer
  /// below has as well.
  Result<void> number(MeshLayer& layer, MeshLayer& below, int32_t z) {
    for (NumberedBlock& block : layer.blocks) {
      block.first_number = static_cast<uint32_t>(counts_.vertices);
      uint32_t known = 0;
      for (const BorderVertex& border : block.mesh.border) {
        const Vec3f gradient = block.mesh.vertices[border.vertex].gradient;
        const auto new_number = static_cast<uint32_t>(counts_.vertices + border.vertex - known);
        const bool may_be_below = border.edge.axis != 2 && border.edge.low.z == z * kBlockCells;
        if (const auto found = below.found.find(border.edge.key());
            may_be_below && found != below.found.end()) {
          // The vertex is written with the layer below; this layer only refers to its number.
          SharedVertex& vertex = below.shared[found->second];
          vertex.gradient = vertex.gradient + gradient;
          block.border.push_back(
              {border.vertex, static_cast<uint32_t>(layer.shared.size()), false});
          layer.shared.push_back({vertex.number, {}});
          ++known;
          continue;
        }
        const auto [entry, is_new] =
            layer.found.emplace(border.edge.key(), static_cast<uint32_t>(layer.shared.size()));
        if (is_new) layer.shared.push_back({new_number, {}});
        SharedVertex& vertex = layer.shared[entry->second];
        vertex.gradient = vertex.gradient + gradient;
        block.border.push_back({border.vertex, entry->second, is_new});
        if (!is_new) ++known;
      }
      counts_.vertices += block.mesh.vertices.size() - known;
      counts_.triangles += block.mesh.triangles.size();
      if (counts_.vertices > std::numeric_limits<uint32_t>::max()) {
        return fail(
            Status::out_of_memory,
            fmt::format("{}: expected an isosurface of less than 2^32 vertices, found more: "
                        "choose a coarser --level",
                        store_.path().string()));
      }
    }
    return {};
  }

  Result<void> write_layer(const MeshLayer& layer,
                           const std::function<Result<void>(MeshPart&&)>& write) {
    if (layer.blocks.empty()) return {};
    std::vector<MeshPart> parts(layer.blocks.size());
    parallel_for(threads_, parts.size(),
                 [&](unsigned, size_t i) { make_part(layer, layer.blocks[i], parts[i]); });
    for (MeshPart& part : parts) {
      if (auto written = write(std::move(part)); !written) return written;
    }
    return {};
  }

  void make_part(const MeshLayer& layer, const NumberedBlock& block, MeshPart& part) const {
    std::vector<uint32_t> numbers(block.mesh.vertices.size());
    for (const BorderNumber& border : block.border) {
      numbers[border.vertex] = layer.shared[border.shared].number;
    }
    const double cells = std::ldexp(1.0, static_cast<int>(level_));
    uint32_t next = block.first_number;
    for_each_new_vertex(block, [&](uint32_t v, const BorderNumber* border) {
      numbers[v] = next++;
      const MeshVertex& vertex = block.mesh.vertices[v];
      const Vec3f at = vertex.position;
      const Index3 low = block.origin;
      part.vertices.positions.push_back(
          grid_.world({cells * (low.x + double{at.x}), cells * (low.y + double{at.y}),
                       cells * (low.z + double{at.z})}));
      const Vec3f g = border ? layer.shared[border->shared].gradient : vertex.gradient;
      const Vec3d gradient = grid_.world_gradient({g.x, g.y, g.z});
      const double steepness = length(gradient);
      const double factor = steepness > 0 ? -1 / steepness : 0;
      part.vertices.normals.push_back({static_cast<float>(gradient.x * factor),
                                       static_cast<float>(gradient.y * factor),
                                       static_cast<float>(gradient.z * factor)});
    });
    part.triangles = block.mesh.triangles;
    for (auto& triangle : part.triangles) {
      for (uint32_t& vertex : triangle) vertex = numbers[vertex];
      if (is_mirrored_) std::swap(triangle[1], triangle[2]);
    }
  }

  const StoreFile& store_;
  const VolumeGrid& grid_;
  bool is_mirrored_;  ///< the volume's axes are left-handed in the world
  float quantized_isovalue_;
  uint32_t level_;
  std::vector<ChunkRef> chunks_;
  unsigned threads_;
  std::vector<Worker> workers_;
  MeshCounts counts_;
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
