// The paper's projections (section 3) and samplings (section 4) compared on a volume:
// isosplat_sampling_study VOLUME ISOVALUE
// Prints a line of JSON for each combination. Lengths are in cells of the volume, whose spacing
// counts as 1 along each axis:
//   samples    active boxes
//   seconds    to make and project them, median
//   dropped    share of samples without a point
//   outside    share of points outside of their cell
//   error_*    distance from points to the trilinear surface (|f − isovalue| / |∇f|)
//   gap_*      distance from the trilinear surface to the nearest point
//   hole       share of the surface farther from every point than half a cell's diagonal
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <unordered_map>

#include "shared/core/mesh/cell_surface.h"
#include "shared/core/sampling/exact_projection.h"
#include "tests/bench/render/volume.h"
#include "tests/evidence/sampling/methods.h"

namespace isosplat {
namespace {

struct ActiveCell {
  Index3 index;
  std::array<float, 8> corners;
};

std::vector<ActiveCell> active_cells(const TestVolume& volume, float isovalue) {
  const Index3 n = volume.grid.voxels;
  std::vector<ActiveCell> cells;
  for (int32_t z = 0; z + 1 < n.z; ++z) {
    for (int32_t y = 0; y + 1 < n.y; ++y) {
      for (int32_t x = 0; x + 1 < n.x; ++x) {
        const CellCorners corners = corners_at(volume, x, y, z);
        if (!is_active(corner_interval(corners), isovalue)) continue;
        cells.push_back({{x, y, z}, Trilinear::as_floats(corners)});
      }
    }
  }
  return cells;
}

Vec3f to_float(Index3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Points of the trilinear surface, in cells of the volume: the middles of a cell's triangles, each
/// moved along the gradient onto the surface.
std::vector<Vec3f> surface_points(const std::vector<ActiveCell>& cells, float isovalue) {
  std::vector<Vec3f> points;
  for (const ActiveCell& cell : cells) {
    std::array<double, 8> values;
    for (size_t i = 0; i < 8; ++i) values[i] = double(cell.corners[i]) - double(isovalue);
    const auto on_edge = [&](int edge) {
      const auto low = static_cast<size_t>(low_corner(edge)),
                 high = static_cast<size_t>(high_corner(edge));
      const auto t = static_cast<float>(values[low] / (values[low] - values[high]));
      const auto at = [](size_t i) {
        return Vec3f{float(i & 1), float(i >> 1 & 1), float(i >> 2)};
      };
      return at(low) * (1 - t) + at(high) * t;
    };
    const CellTriangles& surface = cell_surface(values);
    const auto vertex = [&](uint8_t v) {
      if (v < kCellEdges) return on_edge(v);
      const auto& edges = surface.means[v - kCellEdges];
      Vec3f sum;
      for (const CellEdge edge : edges) sum = sum + on_edge(edge);
      return sum * (1 / static_cast<float>(edges.size()));
    };
    const Trilinear f(cell.corners);
    for (const auto& [a, b, c] : surface.triangles) {
      const Vec3f middle = (vertex(a) + vertex(b) + vertex(c)) * (1.0f / 3);
      const auto root = project_exactly(f, middle, f.at(middle).gradient, isovalue);
      if (root) points.push_back(to_float(cell.index) + *root);
    }
  }
  return points;
}

/// Finds the nearest of a set of points, within one cell.
class PointGrid {
 public:
  void add(Vec3f p) { cells_[key(p, {})].push_back(p); }

  /// The distance to the nearest point; 1 if none is closer.
  float nearest(Vec3f p) const {
    float best = 1;
    for (int32_t i = 0; i < 27; ++i) {
      const auto found = cells_.find(key(p, {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1}));
      if (found == cells_.end()) continue;
      for (const Vec3f& q : found->second) best = std::min(best, length(p - q));
    }
    return best;
  }

 private:
  static uint64_t key(Vec3f p, Index3 offset) {
    const auto part = [](float v, int32_t by) {
      return static_cast<uint64_t>(static_cast<int64_t>(std::floor(v)) + by + 2);
    };
    return part(p.x, offset.x) | part(p.y, offset.y) << 21 | part(p.z, offset.z) << 42;
  }

  std::unordered_map<uint64_t, std::vector<Vec3f>> cells_;
};

struct Spread {
  double mean = 0, p95 = 0, most = 0;
};

Spread spread_of(std::vector<float>& values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  double sum = 0;
  for (const float value : values) sum += double(value);
  return {sum / double(values.size()), double(values[values.size() * 95 / 100]),
          double(values.back())};
}

constexpr int kRounds = 5;

/// A way to sample cells and to project the samples.
struct Combination {
  const char* sampling;
  const char* projection;
  Subdivision subdivision;
  ProjectionMethod method;
  std::vector<double> seconds = {};  ///< of each round
};

struct SampledCells {
  std::vector<Vec3f> points;      ///< in their cell, 0 to 1
  std::vector<uint32_t> cell_of;  ///< of each point
  uint64_t samples = 0;           ///< with those that were dropped
};

/// Replaces the content of `sampled`, but keeps its memory, because allocation is not part of any
/// method.
void sample_cells(const std::vector<ActiveCell>& cells, float isovalue, float max_interval,
                  const Combination& how, SampledCells& sampled) {
  std::vector<SampleBox> boxes;
  sampled.points.clear();
  sampled.cell_of.clear();
  sampled.samples = 0;
  for (uint32_t i = 0; i < cells.size(); ++i) {
    const Trilinear f(cells[i].corners);
    subdivide(cells[i].corners, isovalue, how.subdivision, max_interval, boxes);
    sampled.samples += boxes.size();
    for (const SampleBox& box : boxes) {
      if (const auto p = project_sample(f, box, isovalue, how.method)) {
        sampled.points.push_back(*p);
        sampled.cell_of.push_back(i);
      }
    }
  }
}

/// Times all combinations in turn, so that other work on the machine affects all of them alike.
void time_combinations(const std::vector<ActiveCell>& cells, float isovalue, float max_interval,
                       std::vector<Combination>& combinations, SampledCells& sampled) {
  // Otherwise the first combination would include the allocation of memory.
  sampled.points.reserve(8 * cells.size());
  sampled.cell_of.reserve(8 * cells.size());
  for (int round = 0; round <= kRounds; ++round) {
    for (Combination& how : combinations) {
      const auto begin = std::chrono::steady_clock::now();
      sample_cells(cells, isovalue, max_interval, how, sampled);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
      if (round > 0) how.seconds.push_back(took.count());  // the first round warms the caches
    }
  }
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void print_combination(const Combination& how, const std::vector<ActiveCell>& cells,
                       const std::vector<Vec3f>& surface, float isovalue, float max_interval,
                       SampledCells& sampled) {
  sample_cells(cells, isovalue, max_interval, how, sampled);
  const auto& [points, cell_of, samples] = sampled;
  uint64_t outside = 0;
  PointGrid grid;
  std::vector<float> errors, gaps;
  for (size_t i = 0; i < points.size(); ++i) {
    const ActiveCell& cell = cells[cell_of[i]];
    const Vec3f p = points[i];
    const auto [value, gradient] = Trilinear(cell.corners).at(p);
    const float slope = length(gradient);
    errors.push_back(slope > 0 ? std::min(1.0f, std::abs(value - isovalue) / slope) : 1);
    constexpr float kRounding = 1e-4f;
    const auto is_outside = [](float x) { return x < -kRounding || x > 1 + kRounding; };
    outside += is_outside(p.x) || is_outside(p.y) || is_outside(p.z);
    grid.add(to_float(cell.index) + p);
  }
  uint64_t holes = 0;
  for (const Vec3f& p : surface) {
    gaps.push_back(grid.nearest(p));
    holes += gaps.back() > 0.5f * std::numbers::sqrt3_v<float>;
  }
  const Spread error = spread_of(errors), gap = spread_of(gaps);
  const auto share = [](uint64_t part, size_t whole) {
    return whole > 0 ? double(part) / double(whole) : 0.0;
  };
  std::printf(
      "{\"sampling\": \"%s\", \"projection\": \"%s\", \"samples\": %llu, \"seconds\": %.7f, "
      "\"dropped\": %.6f, \"outside\": %.6f, \"error_mean\": %.5f, \"error_95\": %.5f, "
      "\"error_max\": %.5f, \"gap_mean\": %.5f, \"gap_95\": %.5f, \"gap_max\": %.5f, "
      "\"hole\": %.7f}\n",
      how.sampling, how.projection, static_cast<unsigned long long>(samples), median(how.seconds),
      share(samples - points.size(), samples), share(outside, points.size()), error.mean, error.p95,
      error.most, gap.mean, gap.p95, gap.most, share(holes, surface.size()));
}

int run(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: isosplat_sampling_study VOLUME ISOVALUE\n");
    return 2;
  }
  const TestVolume volume = load_volume(argv[1]);
  const float isovalue = volume.mapping.quantized_isovalue(std::atof(argv[2]));
  const auto cells = active_cells(volume, isovalue);
  const auto surface = surface_points(cells, isovalue);
  // A quarter of the active cells has intervals wider than this.
  std::vector<float> widths;
  for (const ActiveCell& cell : cells) {
    const auto [low, high] = std::ranges::minmax(cell.corners);
    widths.push_back(high - low);
  }
  std::ranges::sort(widths);
  const float max_interval = widths.empty() ? 0 : widths[widths.size() * 3 / 4];

  const char* const samplings[] = {"centre", "isotropic", "adaptive"};
  const char* const projections[] = {"newton", "newton clamped", "two newton", "exact"};
  std::vector<Combination> combinations;
  for (int sampling = 0; sampling < 3; ++sampling) {
    for (int projection = 0; projection < 4; ++projection) {
      combinations.push_back({samplings[sampling], projections[projection],
                              static_cast<Subdivision>(sampling),
                              static_cast<ProjectionMethod>(projection)});
    }
  }
  SampledCells sampled;
  time_combinations(cells, isovalue, max_interval, combinations, sampled);
  for (const Combination& how : combinations) {
    print_combination(how, cells, surface, isovalue, max_interval, sampled);
  }
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
