#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "tests/shared/select_fixture.h"

namespace isosplat {

using fixture::kVoxels;
using fixture::SelectTest;
using fixture::view_from;

namespace {

// No block of a sheared volume counts as outside of the frustum if any of it is inside.
TEST(ScreenProjection, SeesShearedBlocksWhereTheyAre) {
  VolumeGrid grid{kVoxels, {1, 1, 1.5}, {-10, 20, 30}};
  grid.direction = {1, 0.6, 0, 0, 0.8, 0.6, 0, 0, 0.8};
  const LevelGrid level = level_grid(grid.voxels, 0);
  int outside = 0, inside = 0;
  for (int step = 0; step < 24; ++step) {
    const SelectionView view =
        view_from(60 + 30 * (step % 5), 0.9 * step, 0.25 * (step % 7) - 0.7, 100);
    const ScreenProjection screen(grid, view);
    const auto& m = view.view_projection;
    const auto is_seen = [&](Vec3d p) {
      const auto row = [&](size_t r) {
        return m[r] * p.x + m[4 + r] * p.y + m[8 + r] * p.z + m[12 + r];
      };
      const double w = row(3);
      return std::abs(row(0)) < w && std::abs(row(1)) < w && std::abs(row(2)) < w;
    };
    for (int32_t b = 0; b < static_cast<int32_t>(level.block_count()); ++b) {
      const Index3 block{b % level.blocks.x, b / level.blocks.x % level.blocks.y,
                         b / (level.blocks.x * level.blocks.y)};
      const Index3 cells = block_cells(level, block);
      bool any = false;
      for (int32_t i = 0; i < 9 * 9 * 9 && !any; ++i) {
        any = is_seen(grid.world({block.x * 64 + cells.x * (i % 9) / 8.0,
                                  block.y * 64 + cells.y * (i / 9 % 9) / 8.0,
                                  block.z * 64 + cells.z * (i / 81) / 8.0}));
      }
      const bool counts_as_outside = screen.footprint(level, block).outside;
      EXPECT_FALSE(any && counts_as_outside) << "block " << b << " at step " << step;
      outside += counts_as_outside;
      inside += any;
    }
  }
  EXPECT_GT(outside, 100);
  EXPECT_GT(inside, 100);
}

TEST_F(SelectTest, NeverLeavesAHoleNorDrawsTwiceWhileLoading) {
  const StoreReader store = open();
  std::mt19937 random(7);
  for (const float quantized_isovalue : {100.5f, 340.25f, 20.0f}) {
    Selector selector(store);
    load_coarse(store, selector, 2);
    for (const double distance : {900.0, 320.0, 120.0, 400.0}) {
      const SelectionView view = view_from(distance, 0.4 + distance, 0.3, quantized_isovalue);
      for (int step = 0;; ++step) {
        const Selection selection = *selector.select(view);
        const auto times = coverage(store, selector, view, selection);
        ASSERT_FALSE(times.empty());
        for (const auto& [count, cells] : times) {
          ASSERT_EQ(count, 1) << cells << " cells at step " << step << ", distance " << distance;
        }
        if (selection.complete()) break;
        ASSERT_LT(step, 500);
        // Chunks come in any order.
        const size_t arrived = random() % selection.load.size();
        ASSERT_TRUE(selector.set_resident(selection.load[arrived], true));
      }
    }
  }
}

TEST_F(SelectTest, LeavesNoHoleWhileChunksAreEvicted) {
  const StoreReader store = open();
  std::mt19937 random(11);
  Selector selector(store);
  load_coarse(store, selector, 2);
  std::vector<ChunkHandle> resident;
  for (int step = 0; step < 60; ++step) {
    const SelectionView view = view_from(150 + 50 * (step % 7), 0.2 * step, 0.3,
                                         100.5f + static_cast<float>(20 * (step / 20)));
    const Selection selection = *selector.select(view);
    for (const ChunkHandle handle : selection.load) {
      if (random() % 2) continue;
      ASSERT_TRUE(selector.set_resident(handle, true));
      if (selector.chunk(handle)->block.level < 2) resident.push_back(handle);
    }
    for (size_t i = 0; i < resident.size(); ++i) {
      if (random() % 3) continue;
      ASSERT_TRUE(selector.set_resident(resident[i], false));
      resident[i--] = resident.back();
      resident.pop_back();
    }
    const Selection now = *selector.select(view);
    for (const auto& [count, cells] : coverage(store, selector, view, now)) {
      ASSERT_EQ(count, 1) << cells << " cells at step " << step;
    }
  }
}

TEST_F(SelectTest, RefinesToTheErrorBound) {
  const StoreReader store = open();
  for (const double distance : {2000.0, 700.0, 250.0}) {
    for (const double target : {1.0, 3.0}) {
      SelectionView view = view_from(distance, 1.1, -0.4, 100.5f);
      view.load_cell_px = view.draw_cell_px = target;
      Selector selector(store);
      for (int step = 0; step < 20; ++step) {
        const Selection selection = *selector.select(view);
        for (const ChunkHandle handle : selection.load) {
          ASSERT_TRUE(selector.set_resident(handle, true));
        }
      }
      const Selection selection = *selector.select(view);
      ASSERT_TRUE(selection.complete());
      const ScreenProjection projection(store.info().grid, view);
      for (const DrawnChunk& drawn : selection.draw) {
        const BlockKey key = selector.chunk(drawn.handle)->block;
        const auto footprint =
            projection.footprint(level_grid(store.info().grid.voxels, key.level), key.index);
        EXPECT_FALSE(footprint.outside);
        if (key.level > 0) {
          EXPECT_LE(footprint.cell_px, target);
        }
      }
    }
  }
}

TEST_F(SelectTest, CellSizeOnScreenMatchesTheProjection) {
  const StoreReader store = open();
  const SelectionView view = view_from(500, 0, 0, 100.5f, 1000);
  const ScreenProjection projection(store.info().grid, view);
  const LevelGrid coarsest = level_grid(kVoxels, store.info().levels - 1);
  // Seen along −x: the block's nearest corner is a cell beyond the volume's high x.
  const double cell = std::ldexp(1.0, static_cast<int>(coarsest.level));
  const double nearest = 500 + 150 - (coarsest.cells.x + 1) * cell;
  const double focal_px = 500 / std::tan(std::numbers::pi / 8);
  EXPECT_NEAR(projection.footprint(coarsest, {0, 0, 0}).cell_px, cell * 1.5 * focal_px / nearest,
              1e-6);
}

TEST_F(SelectTest, RequestsOnlyActiveBlocksInTheView) {
  const StoreReader store = open();
  const SelectionView view = view_from(160, 2.0, 0.2, 340.25f);
  Selector selector(store);
  for (int step = 0; step < 30; ++step) {
    const Selection selection = *selector.select(view);
    for (const ChunkHandle handle : selection.load) {
      const ChunkRef chunk = *selector.chunk(handle);
      const auto needed = store.chunk_for(chunk.block, 340.25f);
      ASSERT_TRUE(needed && *needed);
      EXPECT_EQ((*needed)->band, chunk.band);
      const ScreenProjection projection(store.info().grid, view);
      EXPECT_FALSE(
          projection.footprint(level_grid(kVoxels, chunk.block.level), chunk.block.index).outside);
      ASSERT_TRUE(selector.set_resident(handle, true));
    }
  }
  // Away from the volume there is nothing to see.
  SelectionView away = view;
  away.view_projection[3] = away.view_projection[7] = away.view_projection[11] = 0;
  away.view_projection[15] = -1;
  const Selection selection = *Selector(store).select(away);
  EXPECT_TRUE(selection.complete());
  EXPECT_TRUE(selection.draw.empty());
}

TEST_F(SelectTest, LargerBudgetRefinesASuperset) {
  const StoreReader store = open();
  const SelectionView view = view_from(260, 0.7, 0.5, 100.5f);
  const auto leaves = [&](uint64_t budget) {
    SelectionView limited = view;
    limited.cell_budget = budget;
    Selector selector(store);
    for (int step = 0; step < 30; ++step) {
      const Selection selection = *selector.select(limited);
      EXPECT_LE(selection.target_cells, std::max<uint64_t>(budget, 5000));
      for (const ChunkHandle handle : selection.load) (void)selector.set_resident(handle, true);
    }
    const Selection selection = *selector.select(limited);
    EXPECT_TRUE(selection.complete());
    std::set<std::tuple<uint32_t, int, int, int>> blocks;
    for (const DrawnChunk& drawn : selection.draw) {
      const BlockKey key = selector.chunk(drawn.handle)->block;
      blocks.insert({key.level, key.index.x, key.index.y, key.index.z});
    }
    return std::pair{blocks, selection.limited_by_budget};
  };
  std::set<std::tuple<uint32_t, int, int, int>> before;
  for (uint64_t budget = 1000; budget < 4'000'000; budget = budget * 3 / 2) {
    const auto [blocks, limited] = leaves(budget);
    // Every block drawn with the smaller budget is drawn, or finer blocks in its place.
    for (auto [level, x, y, z] : blocks) {
      bool found = before.empty();
      for (uint32_t up = level; up < store.info().levels && !found; ++up) {
        found = before.contains({up, x >> (up - level), y >> (up - level), z >> (up - level)});
      }
      EXPECT_TRUE(found) << "level " << level << " budget " << budget;
    }
    if (blocks.size() > 8 && !limited) break;
    before = blocks;
  }
}

TEST_F(SelectTest, ACompleteSelectionDoesNotDependOnEarlierViews) {
  const StoreReader store = open();
  Selector selector(store);
  const auto complete = [&](double distance) {
    for (int step = 0; step < 30; ++step) {
      const Selection selection = *selector.select(view_from(distance, 0.7, 0.5, 100.5f));
      if (selection.complete()) return selection.draw;
      for (const ChunkHandle handle : selection.load) {
        EXPECT_TRUE(selector.set_resident(handle, true));
      }
    }
    ADD_FAILURE() << "not complete at distance " << distance;
    return std::vector<DrawnChunk>{};
  };
  std::map<double, std::vector<DrawnChunk>> first;
  for (const double distance : {900.0, 300.0, 310.0, 150.0, 310.0, 300.0, 600.0, 900.0}) {
    const auto drawn = complete(distance);
    EXPECT_FALSE(drawn.empty());
    const auto [before, added] = first.try_emplace(distance, drawn);
    EXPECT_EQ(drawn, before->second) << "at distance " << distance;
  }
}

TEST_F(SelectTest, FinerChunksStayWhileTheCameraMovesAndNoCoarserOnesAreRequested) {
  const StoreReader store = open();
  Selector selector(store);
  SelectionView view = view_from(300, 0.7, 0.5, 100.5f);
  for (int step = 0; step < 30; ++step) {
    const Selection selection = *selector.select(view);
    for (const ChunkHandle handle : selection.load) {
      ASSERT_TRUE(selector.set_resident(handle, true));
    }
  }
  const Selection still = *selector.select(view);
  view.load_cell_px = 8;
  const Selection moving = *selector.select(view);
  EXPECT_TRUE(moving.load.empty());
  EXPECT_EQ(moving.draw, still.draw);
}

TEST_F(SelectTest, ReportsMissingPagesAndCompletesOnceTheyAreAdded) {
  StoreReader store = *StoreReader::open(std::span(*bytes_).first(kMaxStoreHeaderBytes));
  const SelectionView view = view_from(200, 0.7, 0.5, 100.5f);
  Selector selector(store);
  for (int step = 0; step < 100; ++step) {
    const Selection selection = *selector.select(view);
    if (selection.complete()) break;
    if (!selection.pages.empty()) {
      const PageRef page = store.pages()[selection.pages[0]];
      ASSERT_FALSE(store.is_resident(selection.pages[0]));
      ASSERT_TRUE(
          store.add_page(selection.pages[0],
                         std::span(*bytes_).subspan(static_cast<size_t>(page.offset), page.bytes)));
    }
    for (const ChunkHandle handle : selection.load) {
      ASSERT_TRUE(selector.set_resident(handle, true));
    }
  }
  const Selection selection = *selector.select(view);
  EXPECT_TRUE(selection.complete());
  EXPECT_EQ(selection.finest_drawn_level, 0);
}

TEST_F(SelectTest, SeveralIsovaluesAreCoveredTogether) {
  const StoreReader store = open();
  Selector selector(store);
  load_coarse(store, selector, 2);
  SelectionView view = view_from(320, 0.7, 0.5, 100.5f);
  view.quantized_isovalues = {100.5f, 400.5f};
  std::mt19937 random(3);
  for (int step = 0; step < 500; ++step) {
    const Selection selection = *selector.select(view);
    for (const float quantized_isovalue : {100.5f, 400.5f}) {
      SelectionView one = view;
      one.quantized_isovalues = {quantized_isovalue};
      for (const auto& [count, cells] : coverage(store, selector, one, selection)) {
        ASSERT_EQ(count, 1) << cells << " cells of " << quantized_isovalue << " at step " << step;
      }
    }
    if (selection.complete()) return;
    ASSERT_TRUE(selector.set_resident(selection.load[random() % selection.load.size()], true));
  }
  FAIL() << "never complete";
}

TEST_F(SelectTest, SelectingAheadDoesNotChangeLaterSelections) {
  const StoreReader store = open();
  Selector selector(store), other(store);
  const SelectionView view = view_from(300, 0.7, 0.5, 100.5f);
  const SelectionView ahead = view_from(100, 0.1, 0.5, 300.5f);
  (void)*selector.select(view);
  (void)*other.select(view);
  EXPECT_FALSE(other.select_ahead(ahead)->load.empty());
  std::vector<BlockKey> first, second;
  const Selection after = *selector.select(view), other_after = *other.select(view);
  for (const ChunkHandle handle : after.load) first.push_back(selector.chunk(handle)->block);
  for (const ChunkHandle handle : other_after.load) second.push_back(other.chunk(handle)->block);
  EXPECT_EQ(first, second);
}

TEST_F(SelectTest, SelectsNothingWithoutIsovalues) {
  const StoreReader store = open();
  Selector selector(store);
  SelectionView view = view_from(300, 0, 0, 100.5f);
  view.quantized_isovalues.clear();
  const auto selection = selector.select(view);
  ASSERT_TRUE(selection) << selection.error().message;
  EXPECT_TRUE(selection->load.empty());
  EXPECT_TRUE(selection->draw.empty());
  EXPECT_TRUE(selection->pages.empty());
  EXPECT_FALSE(selection->limited_by_budget);
}

TEST_F(SelectTest, RefusesInvalidViews) {
  const StoreReader store = open();
  Selector selector(store);
  SelectionView view = view_from(300, 0, 0, 100.5f);
  view.view_projection[5] = NAN;
  EXPECT_EQ(selector.select(view).error().status, Status::invalid_argument);
  view = view_from(300, 0, 0, 100.5f);
  view.quantized_isovalues.assign(65, 1.0f);
  EXPECT_EQ(selector.select(view).error().status, Status::invalid_argument);
  view = view_from(300, 0, 0, 100.5f);
  view.width_px = 0;
  EXPECT_EQ(selector.select(view).error().status, Status::invalid_argument);
  EXPECT_EQ(selector.set_resident(99, true).error().status, Status::not_found);
}

}  // namespace
}  // namespace isosplat
