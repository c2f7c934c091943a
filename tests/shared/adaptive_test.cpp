#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/shared/adaptive_fixture.h"

// The lattices of adaptive grids, compared with brute force over leaf cells.
namespace isosplat::adaptive_test {
namespace {

/// The number of random grids; ISOSPLAT_ADAPTIVE_CASES sets another one.
uint32_t case_count() {
  const char* const text = std::getenv("ISOSPLAT_ADAPTIVE_CASES");
  return text ? static_cast<uint32_t>(std::atoi(text)) : 100;
}

/// The only lattice with a cell at a cell of the finest level. Null if none; a failure if several.
const Lattice* only_lattice(const std::vector<Lattice>& lattices, Index3 at) {
  const Lattice* found = nullptr;
  for (const Lattice& lattice : lattices) {
    if (!lattice.has(quotient(at, lattice.edge))) continue;
    EXPECT_EQ(found, nullptr) << "two lattices draw a cell";
    found = &lattice;
  }
  return found;
}

void check_case(uint32_t seed, Centring centring) {
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const Case made = random_case(seed, centring);
  const BruteForce brute(made);
  const auto grid = make_grid(made);
  ASSERT_TRUE(grid) << grid.error().message;
  const auto lattices = lattices_of(*grid, 1 + static_cast<int32_t>(seed % 3));
  const uint32_t finest = grid->levels() - 1;
  // Thin holes may have added a level.
  const int32_t more = grid->cells_per_edge(static_cast<uint32_t>(made.ratios.size()), finest);
  const Index3 n = grid->cells(finest);
  std::mt19937 random(seed);
  const auto fraction = [&] { return static_cast<double>(random() % 1024) / 1023; };
  for_each_index(n, [&](Index3 at) {
    if (testing::Test::HasFailure()) return;
    const Lattice* const lattice = only_lattice(lattices, at);
    const auto leaf = brute.leaf(quotient(at, more));
    ASSERT_EQ(lattice != nullptr, leaf.has_value()) << "at " << at.x << ' ' << at.y << ' ' << at.z;
    if (!lattice) return;
    const Index3 cell = quotient(at, lattice->edge);
    const Vec3d point{at.x + fraction(), at.y + fraction(), at.z + fraction()};
    ASSERT_NEAR(lattice->in_cell(cell, point), brute.in_cell(*leaf, point * (1.0 / more)), 1e-9);
    // On the faces towards greater x, y and z, both sides have the same value.
    for (const Index3 step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}}) {
      const Index3 next = at + step;
      if (next.x >= n.x || next.y >= n.y || next.z >= n.z) continue;
      const Lattice* const other = only_lattice(lattices, next);
      if (!other) continue;
      Vec3d face{at.x + fraction(), at.y + fraction(), at.z + fraction()};
      if (step.x) face.x = next.x;
      if (step.y) face.y = next.y;
      if (step.z) face.z = next.z;
      ASSERT_NEAR(lattice->in_cell(cell, face), other->in_cell(quotient(next, other->edge), face),
                  1e-9);
    }
  });
}

TEST(AdaptiveGrid, LatticesOfRandomPatchesAreContinuousAndCoverEachPointOnce) {
  for (uint32_t seed = 0; seed < case_count() && !HasFailure(); ++seed) {
    check_case(seed, Centring::cells);
  }
}

TEST(AdaptiveGrid, ValuesAtNodesAreKept) {
  for (uint32_t seed = 0; seed < case_count() && !HasFailure(); ++seed) {
    check_case(seed, Centring::nodes);
  }
}

TEST(AdaptiveGrid, ActiveCellsAreThoseOfTheLeaves) {
  for (uint32_t seed = 0; seed < case_count() / 3; ++seed) {
    const Case made = random_case(seed);
    const BruteForce brute(made);
    const auto grid = make_grid(made);
    ASSERT_TRUE(grid) << grid.error().message;
    const auto lattices = lattices_of(*grid);
    const uint32_t finest = grid->levels() - 1;
    const int32_t more = grid->cells_per_edge(static_cast<uint32_t>(made.ratios.size()), finest);
    // A part of a leaf cell that is drawn on a finer level is active if the isosurface passes
    // through the part, so the part's corners decide: by brute force, from the leaf.
    for_each_index(grid->cells(finest), [&](Index3 at) {
      const Lattice* const lattice = only_lattice(lattices, at);
      if (!lattice) return;
      const auto leaf = *brute.leaf(quotient(at, more));
      const Index3 cell = quotient(at, lattice->edge);
      double low = 1e300, high = -1e300, brute_low = 1e300, brute_high = -1e300;
      for_each_index({2, 2, 2}, [&](Index3 o) {
        const double value = lattice->values[flat(cell - lattice->low + o, lattice->voxels)];
        const Index3 corner = (cell + o) * lattice->edge;
        const double expected = brute.in_cell(
            leaf, {corner.x * 1.0 / more, corner.y * 1.0 / more, corner.z * 1.0 / more});
        low = std::min(low, value);
        high = std::max(high, value);
        brute_low = std::min(brute_low, expected);
        brute_high = std::max(brute_high, expected);
      });
      ASSERT_NEAR(low, brute_low, 1e-9);
      ASSERT_NEAR(high, brute_high, 1e-9);
    });
  }
}

/// One cell in the middle of 3³ cells is refined: its corners belong to its neighbours too.
TEST(AdaptiveGrid, SingleRefinedCellsAreNotDrawnTwice) {
  Case made;
  made.cells = {3, 3, 3};
  made.ratios = {2};
  made.patches.push_back({0, {{0, 0, 0}, {3, 3, 3}}, std::vector<double>(27, 1)});
  made.patches.push_back({1, {{2, 2, 2}, {4, 4, 4}}, std::vector<double>(8, 2)});
  const auto grid = make_grid(made);
  ASSERT_TRUE(grid);
  const auto lattices = lattices_of(*grid);
  ASSERT_EQ(lattices.size(), 2u);
  EXPECT_FALSE(lattices[0].has({1, 1, 1}));
  EXPECT_TRUE(lattices[1].has({2, 2, 2}));
  // Seven neighbours at one of its corners are drawn on the finer level; the other 19 stay.
  size_t coarse = 0;
  for_each_index({3, 3, 3}, [&](Index3 cell) { coarse += lattices[0].has(cell) ? 1 : 0; });
  EXPECT_EQ(coarse, 19u);
}

TEST(AdaptiveGrid, ThinHolesStayOpen) {
  Case made;
  made.cells = {3, 3, 3};
  std::vector<double> values(27, 1);
  values[13] = std::numeric_limits<double>::quiet_NaN();
  made.patches.push_back({0, {{0, 0, 0}, {3, 3, 3}}, values});
  const auto grid = make_grid(made);
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->levels(), 2u);
  EXPECT_EQ(only_lattice(lattices_of(*grid), {2, 2, 2}), nullptr);
}

/// Averages at nodes are exact for linear functions, also between levels. Within a cell of the
/// coarsest level of the domain's border they are not: there are no cells on its other side.
TEST(AdaptiveGrid, LinearFunctionsAreExactOnBordersOfLevels) {
  for (uint32_t seed = 0; seed < case_count() / 3 && !HasFailure(); ++seed) {
    Case made = random_case(seed);
    made.patches.front() = {0, {{0, 0, 0}, made.cells}, std::vector<double>(volume(made.cells))};
    const auto linear = [](Vec3d p) { return 3 * p.x - 2 * p.y + p.z; };
    for (Patch& patch : made.patches) {
      const double edge = 1.0 / made.edge(0, patch.level);
      const Index3 size = patch.box.high - patch.box.low;
      for_each_index(size, [&](Index3 i) {
        const Index3 cell = patch.box.low + i;
        patch.values[flat(i, size)] =
            linear(Vec3d{cell.x + 0.5, cell.y + 0.5, cell.z + 0.5} * edge);
      });
    }
    const auto grid = make_grid(made);
    ASSERT_TRUE(grid);
    for (const Lattice& lattice : lattices_of(*grid)) {
      const double edge =
          static_cast<double>(lattice.edge) / grid->cells_per_edge(0, grid->levels() - 1);
      for_each_index(lattice.voxels, [&](Index3 i) {
        const double value = lattice.values[flat(i, lattice.voxels)];
        const Vec3d p =
            Vec3d{0.0 + lattice.low.x + i.x, 0.0 + lattice.low.y + i.y, 0.0 + lattice.low.z + i.z} *
            edge;
        const bool is_inside = std::min({p.x, p.y, p.z}) >= 1 && p.x <= made.cells.x - 1 &&
                               p.y <= made.cells.y - 1 && p.z <= made.cells.z - 1;
        if (is_inside && std::isfinite(value)) {
          EXPECT_NEAR(value, linear(p), 1e-9);
        }
      });
    }
  }
}

TEST(AdaptiveGrid, RefusesWhatDoesNotFit) {
  const std::vector<int32_t> none, two{2}, one{1}, large{17}, many(10, 16);
  const auto status = [](const auto& result) {
    return result ? Status::ok : result.error().status;
  };
  const auto create = [&](Index3 cells, std::span<const int32_t> ratios) {
    return AdaptiveGrid::create(cells, ratios, Centring::cells, 1 << 20);
  };
  EXPECT_EQ(status(create({0, 1, 1}, none)), Status::invalid_argument);
  EXPECT_EQ(status(create({1, 1, 1}, one)), Status::invalid_argument);
  EXPECT_EQ(status(create({1, 1, 1}, large)), Status::invalid_argument);
  EXPECT_EQ(status(create({1, 1, 1}, many)), Status::volume_too_large);
  EXPECT_EQ(status(create({1 << 20, 1, 1}, none)), Status::volume_too_large);
  auto grid = create({4, 4, 4}, two);
  ASSERT_TRUE(grid);
  const std::vector<double> values(512);
  const auto add = [&](uint32_t level, Index3 low, Index3 high) {
    return status(grid->add(level, {low, high}, values));
  };
  EXPECT_EQ(add(2, {0, 0, 0}, {1, 1, 1}), Status::malformed_volume);
  EXPECT_EQ(add(0, {-1, 0, 0}, {1, 1, 1}), Status::malformed_volume);
  EXPECT_EQ(add(0, {0, 0, 0}, {5, 4, 4}), Status::malformed_volume);
  EXPECT_EQ(add(1, {1, 1, 1}, {1, 2, 2}), Status::malformed_volume);
  EXPECT_EQ(add(1, {2, 2, 2}, {1, 3, 3}), Status::malformed_volume);
  EXPECT_EQ(add(1, {0, 0, 0}, {8, 8, 8}), Status::ok);
}

TEST(AdaptiveGrid, ChecksMemoryBeforeItAllocates) {
  Case made;
  made.cells = {1 << 19, 1 << 19, 1 << 19};
  made.patches.push_back({0, {{0, 0, 0}, {1 << 19, 1 << 19, 1 << 19}}, {}});
  const auto grid = make_grid(made, 1 << 20);
  ASSERT_FALSE(grid);
  EXPECT_EQ(grid.error().status, Status::out_of_memory);
  // Also where cells between thin refined ones are drawn on a finer level.
  made = {};
  made.cells = {18, 18, 18};
  made.ratios = {16, 16};
  made.patches.push_back({0, {{0, 0, 0}, {18, 18, 18}}, std::vector<double>(18 * 18 * 18)});
  for_each_index({6, 6, 6}, [&](Index3 i) {
    const Index3 low = i * 48;
    made.patches.push_back({1, {low, low + Index3{16, 16, 16}}, std::vector<double>(4096)});
  });
  const auto thin = make_grid(made, 32 << 20);
  ASSERT_FALSE(thin);
  EXPECT_EQ(thin.error().status, Status::out_of_memory);
}

}  // namespace
}  // namespace isosplat::adaptive_test
