// Paradigms (C) and (D), and marching cubes: an interval tree finds the active cells of a volume in
// memory.
#include "shared/core/mesh/cell_surface.h"
#include "shared/core/points/chunk_samples.h"
#include "tests/evidence/paradigms/extractors.h"
#include "tests/evidence/paradigms/interval_tree.h"

namespace isosplat {
namespace {

class TreeExtractor : public Extractor {
 public:
  TreeExtractor(const TestVolume& volume, bool count_cells)
      : volume_(volume), count_cells_(count_cells), tree_(cells_of_volume(volume)) {}

  uint64_t prepared_bytes() const override { return tree_.memory(); }

 protected:
  static Index3 cells_of_grid(const TestVolume& volume) {
    const Index3 n = volume.grid.voxels;
    return {n.x - 1, n.y - 1, n.z - 1};
  }

  static std::vector<IntervalTree::Cell> cells_of_volume(const TestVolume& volume) {
    const Index3 n = cells_of_grid(volume);
    std::vector<IntervalTree::Cell> cells;
    uint32_t id = 0;
    for (int32_t z = 0; z < n.z; ++z) {
      for (int32_t y = 0; y < n.y; ++y) {
        for (int32_t x = 0; x < n.x; ++x, ++id) {
          const CellInterval interval = corner_interval(corners_at(volume, x, y, z));
          if (interval.min < interval.max) cells.push_back({interval, id});
        }
      }
    }
    return cells;
  }

  Index3 index_of(uint32_t id) const {
    const Index3 n = cells_of_grid(volume_);
    const auto nx = static_cast<uint32_t>(n.x), ny = static_cast<uint32_t>(n.y);
    return {static_cast<int32_t>(id % nx), static_cast<int32_t>(id / nx % ny),
            static_cast<int32_t>(id / nx / ny)};
  }

  /// Calls use(index) for each active cell, and counts it.
  template <class Use>
  void for_each_active(float isovalue, Extraction& extraction, const Use& use) const {
    tree_.for_each_active(isovalue, [&](uint32_t id) {
      const Index3 cell = index_of(id);
      ++extraction.active_cells;
      if (count_cells_) extraction.cells_hash += hash_of(cell);
      use(cell);
    });
  }

  CellCorners corners_of(Index3 cell) const { return corners_at(volume_, cell.x, cell.y, cell.z); }

  const TestVolume& volume_;
  bool count_cells_;
  IntervalTree tree_;
};

size_t block_number(const LevelGrid& level, Index3 cell) {
  const auto block = [](int32_t i) { return static_cast<size_t>(i / kBlockCells); };
  return block(cell.x) + static_cast<size_t>(level.blocks.x) *
                             (block(cell.y) + static_cast<size_t>(level.blocks.y) * block(cell.z));
}

/// Makes samples of the active cells, and projects them, like (A), which does so block by block.
class TreePoints : public TreeExtractor {
 public:
  using TreeExtractor::TreeExtractor;

  Extraction extract(double isovalue) override {
    const LevelGrid level = level_grid(volume_.grid.voxels, 0);
    blocks_.resize(level.block_count());
    for (DecodedCells& block : blocks_) {
      block.cell.clear();
      block.corners.clear();
      block.interval.clear();
    }
    points_.clear();
    Extraction extraction;
    const auto quantized = static_cast<float>(isovalue);
    for_each_active(quantized, extraction, [&](Index3 cell) {
      DecodedCells& block = blocks_[block_number(level, cell)];
      const CellCorners corners = corners_of(cell);
      block.cell.push_back(static_cast<uint32_t>(cell.x & 63) |
                           static_cast<uint32_t>(cell.y & 63) << 6 |
                           static_cast<uint32_t>(cell.z & 63) << 12);
      block.corners.push_back(corners);
      block.interval.push_back(corner_interval(corners));
    });
    size_t number = 0;
    for (int32_t z = 0; z < level.blocks.z; ++z) {
      for (int32_t y = 0; y < level.blocks.y; ++y) {
        for (int32_t x = 0; x < level.blocks.x; ++x) {
          const ChunkFrame frame{&volume_.grid, &mapping_, {0, {x, y, z}}};
          points_.push_back(project_samples(blocks_[number++], frame, quantized, {}));
          extraction.bytes += bytes_of(points_.back());
        }
      }
    }
    return extraction;
  }

 private:
  ValueMapping mapping_;
  std::vector<DecodedCells> blocks_;
  std::vector<PointArrays> points_;
};

/// Makes samples of the active cells in the layout of the GPU.
class TreeSamples : public TreeExtractor {
 public:
  using TreeExtractor::TreeExtractor;

  Extraction extract(double isovalue) override {
    const LevelGrid level = level_grid(volume_.grid.voxels, 0);
    blocks_.resize(level.block_count());
    for (auto& block : blocks_) block.clear();
    Extraction extraction;
    for_each_active(static_cast<float>(isovalue), extraction, [&](Index3 cell) {
      const CellCorners corners = corners_of(cell);
      blocks_[block_number(level, cell)].push_back(
          pack_sample({cell.x & 63, cell.y & 63, cell.z & 63}, corner_interval(corners), corners));
    });
    extraction.bytes = extraction.active_cells * sizeof(PackedSample);
    return extraction;
  }

 private:
  std::vector<std::vector<PackedSample>> blocks_;
};

/// Straightforward marching cubes (W. Lorensen, H. Cline, 1987; ambiguous cells as in
/// shared/core/mesh): each triangle has three separate vertices, with positions on the edges of its
/// cell, and normals from central differences at the voxels.
class TreeTriangles : public TreeExtractor {
 public:
  using TreeExtractor::TreeExtractor;

  Extraction extract(double isovalue) override {
    vertices_.clear();
    Extraction extraction;
    for_each_active(static_cast<float>(isovalue), extraction,
                    [&](Index3 cell) { add_cell(cell, isovalue); });
    extraction.bytes = vertices_.size() * sizeof(Vertex);
    return extraction;
  }

 private:
  struct Vertex {
    Vec3f position, normal;
  };

  void add_cell(Index3 cell, double isovalue) {
    const CellCorners corners = corners_of(cell);
    std::array<double, 8> values;
    for (size_t i = 0; i < 8; ++i) values[i] = corners[i] - isovalue;
    const CellTriangles& surface = cell_surface(values);
    for (const CellTriangle& triangle : surface.triangles) {
      for (const uint8_t v : triangle) vertices_.push_back(vertex(cell, values, surface, v));
    }
  }

  Vertex vertex(Index3 cell, const std::array<double, 8>& values, const CellTriangles& surface,
                uint8_t v) const {
    if (v < kCellEdges) return on_edge(cell, values, v);
    const std::vector<CellEdge>& edges = surface.means[v - kCellEdges];
    Vertex sum{};
    for (const CellEdge edge : edges) {
      const Vertex end = on_edge(cell, values, edge);
      sum.position = sum.position + end.position;
      sum.normal = sum.normal + end.normal;
    }
    sum.position = sum.position * (1 / static_cast<float>(edges.size()));
    return normalised(sum);
  }

  Vertex on_edge(Index3 cell, const std::array<double, 8>& values, int edge) const {
    const int low = low_corner(edge), high = high_corner(edge);
    const double from = values[static_cast<size_t>(low)], to = values[static_cast<size_t>(high)];
    const auto t = static_cast<float>(from / (from - to));
    const Index3 a = corner(cell, low), b = corner(cell, high);
    const Vec3f at{static_cast<float>(a.x) + t * static_cast<float>(b.x - a.x),
                   static_cast<float>(a.y) + t * static_cast<float>(b.y - a.y),
                   static_cast<float>(a.z) + t * static_cast<float>(b.z - a.z)};
    const Vec3f gradient = central_difference(a) * (1 - t) + central_difference(b) * t;
    return normalised({at, gradient * -1.0f});
  }

  static Index3 corner(Index3 cell, int i) {
    return {cell.x + (i & 1), cell.y + (i >> 1 & 1), cell.z + (i >> 2)};
  }

  static Vertex normalised(Vertex vertex) {
    const float size = length(vertex.normal);
    if (size > 0) vertex.normal = vertex.normal * (1 / size);
    return vertex;
  }

  Vec3f central_difference(Index3 p) const {
    const Index3 n = volume_.grid.voxels;
    const auto value = [&](int32_t x, int32_t y, int32_t z) {
      return static_cast<float>(volume_.at(std::clamp(x, 0, n.x - 1), std::clamp(y, 0, n.y - 1),
                                           std::clamp(z, 0, n.z - 1)));
    };
    return {value(p.x + 1, p.y, p.z) - value(p.x - 1, p.y, p.z),
            value(p.x, p.y + 1, p.z) - value(p.x, p.y - 1, p.z),
            value(p.x, p.y, p.z + 1) - value(p.x, p.y, p.z - 1)};
  }

  std::vector<Vertex> vertices_;
};

}  // namespace

std::unique_ptr<Extractor> make_tree_extractor(Paradigm paradigm, const TestVolume& volume,
                                               bool count_cells) {
  if (paradigm == Paradigm::c) return std::make_unique<TreePoints>(volume, count_cells);
  if (paradigm == Paradigm::d) return std::make_unique<TreeSamples>(volume, count_cells);
  return std::make_unique<TreeTriangles>(volume, count_cells);
}

std::unique_ptr<Extractor> make_extractor(Paradigm paradigm, const TestVolume& volume,
                                          const std::filesystem::path& folder, bool count_cells) {
  if (paradigm == Paradigm::a || paradigm == Paradigm::b) {
    return make_store_extractor(paradigm, volume, folder, count_cells);
  }
  return make_tree_extractor(paradigm, volume, count_cells);
}

}  // namespace isosplat
