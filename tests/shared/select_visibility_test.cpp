#include <gtest/gtest.h>

#include <random>
#include <set>

#include "shared/core/select/visibility.h"
#include "tests/shared/select_fixture.h"

namespace isosplat {

using fixture::SelectTest;
using fixture::view_from;

namespace {

using CellId = std::tuple<int, int, int>;

/// The result that a renderer would return, by brute force: a cell of level 0 is visible if its
/// centre is the nearest one in its pixel.
class SelectVisibilityTest : public SelectTest {
 protected:
  static std::set<CellId> seen_cells(const StoreReader& store, const SelectionView& view) {
    std::map<std::pair<int, int>, std::pair<double, Index3>> nearest;
    for (const Index3 cell : active_cells(view.quantized_isovalues[0])) {
      const Vec3d p = store.info().grid.world({cell.x + 0.5, cell.y + 0.5, cell.z + 0.5});
      if (!in_frustum(view, p)) continue;
      const auto& m = view.view_projection;
      const double w = m[3] * p.x + m[7] * p.y + m[11] * p.z + m[15];
      const auto px = [&](size_t row) {
        const double clip = m[row] * p.x + m[4 + row] * p.y + m[8 + row] * p.z + m[12 + row];
        return static_cast<int>(std::floor((clip / w + 1) * 40));
      };
      const auto [place, added] = nearest.try_emplace({px(0), px(1)}, std::pair{w, cell});
      if (!added && w < place->second.first) place->second = {w, cell};
    }
    std::set<CellId> cells;
    for (const auto& [pixel, found] : nearest) {
      cells.insert({found.second.x, found.second.y, found.second.z});
    }
    return cells;
  }

  static std::vector<ChunkVisibility> answer(const Selector& selector, const Selection& selection,
                                             const std::set<CellId>& seen) {
    std::vector<ChunkVisibility> answers;
    for (const DrawnChunk& drawn : selection.draw) {
      if (std::find(selection.test.begin(), selection.test.end(), drawn.handle) ==
          selection.test.end()) {
        continue;
      }
      ChunkVisibility visibility{drawn.handle, drawn.regions, {}};
      const BlockKey block = selector.chunk(drawn.handle)->block;
      for (const auto& [x, y, z] : seen) {
        const Index3 c{x >> block.level, y >> block.level, z >> block.level};
        if (Index3{c.x >> 6, c.y >> 6, c.z >> 6} != block.index) continue;
        visibility.visible.insert({c.x >> 3 & 7, c.y >> 3 & 7, c.z >> 3 & 7});
      }
      visibility.visible &= drawn.regions;
      answers.push_back(visibility);
    }
    return answers;
  }

  static std::tuple<int, int, int> block_of(const CellId& cell) {
    return {std::get<0>(cell) >> 6, std::get<1>(cell) >> 6, std::get<2>(cell) >> 6};
  }
};

TEST_F(SelectVisibilityTest, FetchesVisibleChunksOnlyAndLeavesNoHole) {
  const StoreReader store = open();
  std::mt19937 random(5);
  for (const double azimuth : {0.3, 2.2}) {
    SelectionView view = view_from(260, azimuth, 0.4, 100.5f, 1024);
    view.occlusion = true;
    const std::set<CellId> seen = seen_cells(store, view);
    std::set<std::tuple<int, int, int>> seen_blocks;
    for (const CellId& cell : seen) seen_blocks.insert(block_of(cell));

    Selector selector(store);
    load_coarse(store, selector, 3);
    std::set<std::tuple<int, int, int>> fetched;
    size_t rounds = 0;
    for (;; ++rounds) {
      ASSERT_LT(rounds, 300u);
      Selection selection = *selector.select(view);
      for (const auto& [count, cells] : coverage(store, selector, view, selection)) {
        ASSERT_EQ(count, 1) << cells << " cells in round " << rounds;
      }
      ASSERT_TRUE(selector.set_visibility(answer(selector, selection, seen)));
      selection = *selector.select(view);
      EXPECT_EQ(selection.undecided == 0 || !selection.load.empty(), true);
      if (selection.complete()) break;
      ASSERT_FALSE(selection.load.empty());
      const ChunkHandle arrived = selection.load[random() % selection.load.size()];
      ASSERT_TRUE(selector.set_resident(arrived, true));
      const BlockKey block = selector.chunk(arrived)->block;
      if (block.level == 0) fetched.insert({block.index.x, block.index.y, block.index.z});
    }
    EXPECT_EQ(fetched, seen_blocks);

    // For comparison: without occlusion.
    SelectionView everything = view;
    everything.occlusion = false;
    EXPECT_GT(selector.select(everything)->load.size(), 0u);
  }
}

TEST_F(SelectVisibilityTest, RequestsNoFineChunksBeforeVisibilityIsKnown) {
  const StoreReader store = open();
  Selector selector(store);
  load_coarse(store, selector, 3);
  SelectionView view = view_from(260, 0.3, 0.4, 100.5f, 1024);
  view.occlusion = true;
  Selection selection = *selector.select(view);
  EXPECT_TRUE(selection.load.empty());
  EXPECT_GT(selection.undecided, 0u);
  EXPECT_FALSE(selection.complete());
  EXPECT_FALSE(selection.test.empty());

  std::vector<ChunkVisibility> nothing;
  for (const ChunkHandle handle : selection.test)
    nothing.push_back({handle, RegionMask::all(), {}});
  ASSERT_TRUE(selector.set_visibility(nothing));
  EXPECT_TRUE(selector.select(view)->complete());

  // Another camera: hidden blocks may be visible.
  SelectionView other = view_from(260, 0.4, 0.4, 100.5f, 1024);
  other.occlusion = true;
  EXPECT_GT(selector.select(other)->undecided, 0u);

  EXPECT_EQ(selector.set_visibility(std::vector<ChunkVisibility>{{9999, {}, {}}}).error().status,
            Status::not_found);
}

TEST_F(SelectVisibilityTest, FetchedChunksStayWhenTheyBecomeHidden) {
  const StoreReader store = open();
  Selector selector(store);
  load_coarse(store, selector, 2);
  SelectionView view = view_from(260, 0.3, 0.4, 100.5f, 1024);
  for (int step = 0; step < 20; ++step) {
    const Selection selection = *selector.select(view);
    for (const ChunkHandle handle : selection.load) (void)selector.set_resident(handle, true);
  }
  const Selection before = *selector.select(view);
  view.occlusion = true;
  EXPECT_EQ(selector.select(view)->draw, before.draw);
  EXPECT_TRUE(selector.select(view)->test.empty());
  EXPECT_TRUE(selector.select(view)->complete());
}

TEST_F(SelectVisibilityTest, CoarseChunksAreNotDrawnWhereAllFinerBlocksAreKnownToBeInactive) {
  const StoreReader store = open();
  Selector selector(store);
  load_coarse(store, selector, 2);
  const SelectionView view = view_from(260, 0.3, 0.4, 100.5f, 1024);
  const Selection selection = *selector.select(view);
  ASSERT_FALSE(selection.draw.empty());
  const Index3 blocks = level_grid(store.info().grid.voxels, 0).blocks;
  int active = 0, inactive = 0;
  for (int32_t z = 0; z < blocks.z; ++z) {
    for (int32_t y = 0; y < blocks.y; ++y) {
      for (int32_t x = 0; x < blocks.x; ++x) {
        const bool is_active = store.chunk_for({0, {x, y, z}}, 100.5f)->has_value();
        ++(is_active ? active : inactive);
        for (const DrawnChunk& drawn : selection.draw) {
          const BlockKey coarse = selector.chunk(drawn.handle)->block;
          const uint32_t levels = coarse.level;
          if (Index3{x >> levels, y >> levels, z >> levels} != coarse.index) continue;
          RegionMask both = RegionMask::of_block_below(
              {x - (coarse.index.x << levels), y - (coarse.index.y << levels),
               z - (coarse.index.z << levels)},
              levels);
          both &= drawn.regions;
          EXPECT_EQ(both.any(), is_active) << x << ' ' << y << ' ' << z << " level " << levels;
        }
      }
    }
  }
  EXPECT_GT(active, 5);
  EXPECT_GT(inactive, 5);
}

TEST(VisibilityMapTest, DerivesTheVisibilityOfCoarserAndFinerBlocks) {
  VisibilityMap visibility;
  EXPECT_EQ(visibility.of({0, {9, 9, 9}}), Visibility::untested);
  RegionMask seen;
  seen.insert({1, 0, 2});
  visibility.add({4, {1, 0, 0}}, RegionMask::all(), seen);
  EXPECT_EQ(visibility.of({1, {9, 0, 2}}), Visibility::visible);  // the region's own block
  EXPECT_EQ(visibility.of({2, {4, 0, 1}}), Visibility::visible);  // the block that contains it
  EXPECT_EQ(visibility.of({5, {0, 0, 0}}), Visibility::visible);
  EXPECT_EQ(visibility.of({0, {18, 1, 4}}), Visibility::ancestor_visible);  // a part of this block
  EXPECT_EQ(visibility.of({1, {8, 0, 2}}), Visibility::hidden);
  EXPECT_EQ(visibility.of({0, {16, 0, 4}}), Visibility::hidden);
  EXPECT_EQ(visibility.of({3, {3, 1, 1}}), Visibility::hidden);
  EXPECT_EQ(visibility.of({1, {7, 0, 2}}), Visibility::untested);  // in another block
  visibility.clear();
  EXPECT_EQ(visibility.of({1, {9, 0, 2}}), Visibility::untested);
}

TEST(VisibilityMapTest, RegionsOfFineBlocksArePartsOfBlocksOfLevelZero) {
  VisibilityMap visibility;
  RegionMask seen;
  seen.insert({7, 0, 0});
  visibility.add({1, {2, 3, 4}}, RegionMask::all(), seen);
  EXPECT_EQ(visibility.of({0, {5, 6, 8}}), Visibility::visible);
  EXPECT_EQ(visibility.of({0, {4, 6, 8}}), Visibility::hidden);
}

TEST(RegionMaskTest, BlocksBelowPartitionTheRegions) {
  for (uint32_t levels = 0; levels <= kRegionLevels; ++levels) {
    RegionMask together;
    for (int32_t i = 0; i < 1 << 3 * levels; ++i) {
      const int32_t side = (1 << levels) - 1;
      const RegionMask mask =
          RegionMask::of_block_below({i & side, i >> levels & side, i >> 2 * levels}, levels);
      RegionMask overlap = together;
      overlap &= mask;
      EXPECT_FALSE(overlap.any());
      together |= mask;
    }
    EXPECT_EQ(together, RegionMask::all());
    EXPECT_EQ(RegionMask::from_words(together.words().data()), together);
  }
}

}  // namespace
}  // namespace isosplat
