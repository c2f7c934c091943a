#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "shared/core/adaptive/drawn_cells.h"
#include "shared/core/adaptive/level_source.h"

// Random adaptive grids, and their leaf cells and function by brute force: one entry for each cell
// of the finest level, without the bricks and rules of shared/core/adaptive.
namespace isosplat::adaptive_test {

struct Patch {
  uint32_t level = 0;
  CellBox box;
  std::vector<double> values;
};

struct Case {
  Index3 cells;
  std::vector<int32_t> ratios;
  std::vector<Patch> patches;
  Centring centring = Centring::cells;

  int32_t edge(size_t coarse, size_t fine) const {
    int32_t product = 1;
    for (size_t i = coarse; i < fine; ++i) product *= ratios[i];
    return product;
  }
};

inline size_t flat(Index3 at, Index3 size) {
  return (static_cast<size_t>(at.z) * static_cast<size_t>(size.y) + static_cast<size_t>(at.y)) *
             static_cast<size_t>(size.x) +
         static_cast<size_t>(at.x);
}

inline size_t volume(Index3 size) {
  return static_cast<size_t>(size.x) * static_cast<size_t>(size.y) * static_cast<size_t>(size.z);
}

inline Index3 quotient(Index3 a, int32_t b) {
  return {a.x / b, a.y / b, a.z / b};
}

template <class Visit>
void for_each_index(Index3 size, const Visit& visit) {
  for (int32_t z = 0; z < size.z; ++z) {
    for (int32_t y = 0; y < size.y; ++y) {
      for (int32_t x = 0; x < size.x; ++x) visit(Index3{x, y, z});
    }
  }
}

/// Patches of 1 to 3 levels with ratios from 2 to 4: they overlap, touch the border, have holes,
/// and most but not all are aligned with coarser cells and lie in coarser patches.
inline Case random_case(uint32_t seed, Centring centring = Centring::cells) {
  std::mt19937 random(seed);
  const auto below = [&](int32_t n) {
    return static_cast<int32_t>(random() % static_cast<uint32_t>(n));
  };
  Case made;
  made.centring = centring;
  made.cells = {1 + below(5), 1 + below(5), 1 + below(5)};
  const int32_t finer = below(3);
  for (int32_t i = 0; i < finer; ++i) made.ratios.push_back(2 + below(i == 0 ? 3 : 2));
  const bool has_holes = below(3) == 0, is_whole = below(4) != 0;
  for (size_t level = 0; level <= made.ratios.size(); ++level) {
    const Index3 domain = made.cells * made.edge(0, level);
    const int32_t count = level == 0 && is_whole ? 1 : 1 + below(4);
    for (int32_t i = 0; i < count; ++i) {
      Patch patch;
      patch.level = static_cast<uint32_t>(level);
      const int32_t step = level > 0 && below(8) != 0 ? made.ratios[level - 1] : 1;
      const auto range = [&](int32_t cells, int32_t& low, int32_t& high) {
        const int32_t steps = cells / step;
        low = below(steps);
        high = (low + 1 + below(std::min(steps - low, 4))) * step;
        low *= step;
      };
      range(domain.x, patch.box.low.x, patch.box.high.x);
      range(domain.y, patch.box.low.y, patch.box.high.y);
      range(domain.z, patch.box.low.z, patch.box.high.z);
      if (level == 0 && is_whole) patch.box = {{0, 0, 0}, domain};
      const int32_t more = centring == Centring::nodes ? 1 : 0;
      Index3 size = patch.box.high - patch.box.low + Index3{more, more, more};
      patch.values.resize(volume(size));
      for (double& value : patch.values) {
        value = has_holes && below(12) == 0 ? std::numeric_limits<double>::quiet_NaN()
                                            : below(1 << 20) / 1024.0 - 500;
      }
      made.patches.push_back(std::move(patch));
    }
  }
  return made;
}

/// A leaf cell by brute force.
struct Leaf {
  size_t level;
  Index3 cell;
  friend bool operator==(const Leaf&, const Leaf&) = default;
};

/// The leaf cells and the function of a case.
class BruteForce {
 public:
  explicit BruteForce(const Case& of) : case_(of), levels_(of.ratios.size() + 1) {
    finest_ = of.cells * of.edge(0, levels_ - 1);
    cells_.resize(levels_);
    nodes_.resize(levels_);
    for (size_t level = 0; level < levels_; ++level) {
      cells_[level].resize(volume(size(level)));
      nodes_[level].resize(volume(size(level) + Index3{1, 1, 1}));
    }
    for (const Patch& patch : of.patches) add(patch);
    leaves_.reserve(volume(finest_));
    for_each_index(finest_, [&](Index3 at) { leaves_.push_back(find_leaf(at)); });
    known_nodes_.resize(volume(finest_ + Index3{1, 1, 1}));
  }

  Index3 size(size_t level) const { return case_.cells * case_.edge(0, level); }

  /// The leaf cell at a cell of the finest level. Nothing: none, or one without a value.
  const std::optional<Leaf>& leaf(Index3 at) const { return leaves_[flat(at, finest_)]; }

  /// The value at a node of the finest level. Nothing if no leaf cell touches it.
  std::optional<double> node(Index3 at) const {
    auto& known = known_nodes_[flat(at, finest_ + Index3{1, 1, 1})];
    if (!known) known = find_node(at);
    return known;
  }

  /// The function of a leaf cell at a point of it, in cells of the finest level.
  double in_cell(const Leaf& leaf, Vec3d at) const {
    const int32_t edge = case_.edge(leaf.level, levels_ - 1);
    double sum = 0;
    for_each_index({2, 2, 2}, [&](Index3 o) {
      const auto along = [&](double x, int32_t low, int32_t side) {
        const double t = x / edge - low;
        return side ? t : 1 - t;
      };
      const double weight = along(at.x, leaf.cell.x, o.x) * along(at.y, leaf.cell.y, o.y) *
                            along(at.z, leaf.cell.z, o.z);
      if (weight != 0) sum += weight * *node((leaf.cell + o) * edge);
    });
    return sum;
  }

 private:
  std::optional<Leaf> find_leaf(Index3 at) const {
    for (size_t level = 0; level < levels_; ++level) {
      const Index3 cell = quotient(at, case_.edge(level, levels_ - 1));
      const auto& value = cells_[level][flat(cell, size(level))];
      if (!value || is_covered(level, cell)) continue;
      if (!std::isfinite(*value)) return std::nullopt;
      return Leaf{level, cell};
    }
    return std::nullopt;
  }

  std::optional<double> find_node(Index3 at) const {
    std::vector<Leaf> leaves;
    size_t coarsest = levels_, finest = 0;
    for_each_index({2, 2, 2}, [&](Index3 o) {
      const Index3 cell = at - Index3{1, 1, 1} + o;
      if (std::min({cell.x, cell.y, cell.z}) < 0 || cell.x >= finest_.x || cell.y >= finest_.y ||
          cell.z >= finest_.z) {
        return;
      }
      const auto& found = leaf(cell);
      if (!found) return;
      leaves.push_back(*found);
      coarsest = std::min(coarsest, found->level);
      finest = std::max(finest, found->level);
    });
    if (leaves.empty()) return std::nullopt;
    const int32_t edge = case_.edge(coarsest, levels_ - 1);
    if (at.x % edge != 0 || at.y % edge != 0 || at.z % edge != 0) {
      const auto owner = std::find_if(leaves.begin(), leaves.end(),
                                      [&](const Leaf& each) { return each.level == coarsest; });
      return in_cell(*owner, {at.x * 1.0, at.y * 1.0, at.z * 1.0});
    }
    if (case_.centring == Centring::nodes) {
      const Index3 there = quotient(at, case_.edge(finest, levels_ - 1));
      return nodes_[finest][flat(there, size(finest) + Index3{1, 1, 1})];
    }
    double sum = 0, weights = 0;
    for (const Leaf& each : leaves) {
      const double weight = 1.0 / case_.edge(each.level, levels_ - 1);
      sum += weight * *cells_[each.level][flat(each.cell, size(each.level))];
      weights += weight;
    }
    return sum / weights;
  }

  void add(const Patch& patch) {
    const Index3 n = patch.box.high - patch.box.low;
    const bool are_nodes = case_.centring == Centring::nodes;
    const Index3 more = are_nodes ? Index3{1, 1, 1} : Index3{0, 0, 0};
    if (are_nodes) {
      for_each_index(n + more, [&](Index3 i) {
        auto& node = nodes_[patch.level][flat(patch.box.low + i, size(patch.level) + more)];
        const double value = patch.values[flat(i, n + more)];
        if (!node && std::isfinite(value)) node = value;
      });
    }
    for_each_index(n, [&](Index3 i) {
      double value = are_nodes ? 0 : patch.values[flat(i, n)];
      if (are_nodes) {
        for_each_index({2, 2, 2}, [&](Index3 o) { value += patch.values[flat(i + o, n + more)]; });
      }
      auto& cell = cells_[patch.level][flat(patch.box.low + i, size(patch.level))];
      if (!cell) cell = value;
    });
  }

  /// Whether data of finer levels cover a cell.
  bool is_covered(size_t level, Index3 cell) const {
    if (level + 1 == levels_) return false;
    bool all = true;
    const int32_t ratio = case_.ratios[level];
    for_each_index({ratio, ratio, ratio}, [&](Index3 o) {
      const Index3 child = cell * ratio + o;
      all =
          all && (cells_[level + 1][flat(child, size(level + 1))] || is_covered(level + 1, child));
    });
    return all;
  }

  const Case& case_;
  size_t levels_;
  Index3 finest_;
  std::vector<std::vector<std::optional<double>>> cells_, nodes_;  ///< by level
  std::vector<std::optional<Leaf>> leaves_;
  mutable std::vector<std::optional<double>> known_nodes_;
};

/// The grid of a case, with its drawn cells.
inline Result<AdaptiveGrid> make_grid(const Case& of, uint64_t memory_bytes = uint64_t{1} << 30) {
  auto grid = AdaptiveGrid::create(of.cells, of.ratios, of.centring, memory_bytes);
  if (!grid) return grid;
  for (const Patch& patch : of.patches) {
    if (auto added = grid->add(patch.level, patch.box, patch.values); !added) {
      return tl::unexpected(added.error());
    }
  }
  grid->resolve();
  if (auto drawn = choose_drawn_cells(*grid); !drawn) return tl::unexpected(drawn.error());
  return grid;
}

/// The lattice of a level, as its store has it.
struct Lattice {
  int32_t edge = 1;  ///< finest cells of the grid along an edge of a cell
  Index3 low, voxels;
  std::vector<double> values;

  /// Whether all corners of a cell of the level have values.
  bool has(Index3 cell) const {
    const Index3 i = cell - low;
    if (std::min({i.x, i.y, i.z}) < 0 || i.x + 1 >= voxels.x || i.y + 1 >= voxels.y ||
        i.z + 1 >= voxels.z) {
      return false;
    }
    bool all = true;
    for_each_index({2, 2, 2},
                   [&](Index3 o) { all = all && std::isfinite(values[flat(i + o, voxels)]); });
    return all;
  }

  /// The value in a cell, at a point in cells of the finest level.
  double in_cell(Index3 cell, Vec3d at) const {
    const Vec3d t{at.x / edge - cell.x, at.y / edge - cell.y, at.z / edge - cell.z};
    double sum = 0;
    for_each_index({2, 2, 2}, [&](Index3 o) {
      const double weight = (o.x ? t.x : 1 - t.x) * (o.y ? t.y : 1 - t.y) * (o.z ? t.z : 1 - t.z);
      sum += weight * values[flat(cell - low + o, voxels)];
    });
    return sum;
  }
};

/// The lattices of all levels, from `slices` slices at a time.
inline std::vector<Lattice> lattices_of(const AdaptiveGrid& grid, int32_t slices = 1) {
  std::vector<Lattice> lattices;
  for (uint32_t level = 0; level < grid.levels(); ++level) {
    auto source = LevelSource::create(grid, level, {});
    if (!source) continue;
    Lattice& lattice = lattices.emplace_back();
    lattice.edge = grid.cells_per_edge(level, grid.levels() - 1);
    lattice.low = source->low();
    lattice.voxels = source->header().grid.voxels;
    lattice.values.resize(volume(lattice.voxels));
    const size_t slice = volume({lattice.voxels.x, lattice.voxels.y, 1});
    for (int32_t z = 0; z < lattice.voxels.z; z += slices) {
      const int32_t count = std::min(slices, lattice.voxels.z - z);
      const std::span<double> out(lattice.values.data() + slice * static_cast<size_t>(z),
                                  slice * static_cast<size_t>(count));
      if (!source->read_slices(z, count, std::as_writable_bytes(out))) return {};
    }
  }
  return lattices;
}

}  // namespace isosplat::adaptive_test
