// Tests which regions of a lattice have pages of gradients.
#include <gtest/gtest.h>

#include <numeric>

#include "shared/render/passes/lattice_regions.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

FreePages pages_to(uint32_t last) {
  FreePages pages(last);
  std::iota(pages.rbegin(), pages.rend(), 1u);
  return pages;
}

LatticeChunk chunk(uint64_t serial, Index3 first_region) {
  return {serial, first_region, RegionMask::all()};
}

/// Needs these regions of a table of 17³.
bool assign(LatticeRegions& regions, FreePages& free, std::initializer_list<Index3> needed) {
  regions.begin({0, 0, 0}, {17, 17, 17});
  for (const Index3 region : needed) regions.need(region, region);
  return regions.assign(free);
}

TEST(RenderLattice, NeededRegionsHavePages) {
  LatticeRegions regions;
  FreePages free = pages_to(10);
  regions.begin({8, 0, 4}, {3, 2, 4});
  regions.need({9, 0, 5}, {10, 0, 6});
  regions.need({9, 0, 5}, {9, 1, 5});
  EXPECT_EQ(regions.needed(), size_t{5});
  ASSERT_TRUE(regions.assign(free));
  EXPECT_EQ(free.size(), size_t{5});
  EXPECT_EQ(regions.new_pages(), (std::vector<uint32_t>{1, 2, 3, 4, 5}));
  std::vector<uint32_t> expected(24);
  uint32_t page = 0;
  for (const size_t index : {7, 8, 10, 13, 14}) expected[index] = ++page | LATTICE_NEW_PAGE;
  EXPECT_EQ(regions.table(), expected);
  EXPECT_TRUE(regions.has_new({0, 0, 0}, {9, 1, 5}));
  EXPECT_FALSE(regions.has_new({8, 0, 4}, {8, 1, 7}));
}

TEST(RenderLattice, RegionsKeepTheirPages) {
  LatticeRegions regions;
  FreePages free = pages_to(3);
  ASSERT_TRUE(assign(regions, free, {{1, 1, 1}, {2, 1, 1}}));
  const uint32_t page = regions.table()[2 + 17 * (1 + 17)] & ~LATTICE_NEW_PAGE;
  ASSERT_TRUE(assign(regions, free, {{2, 1, 1}, {3, 1, 1}}));
  EXPECT_EQ(regions.table()[2 + 17 * (1 + 17)], page);
  EXPECT_EQ(regions.new_pages(), (std::vector<uint32_t>{3}));
  // There is no page for another region, unless that of a region that is not needed becomes free.
  ASSERT_TRUE(assign(regions, free, {{3, 1, 1}, {4, 1, 1}, {5, 1, 1}}));
  EXPECT_EQ(regions.new_pages().size(), size_t{2});
  EXPECT_TRUE(free.empty());
}

TEST(RenderLattice, TooFewPagesAreGivenToNone) {
  LatticeRegions regions;
  FreePages free = pages_to(2);
  ASSERT_TRUE(assign(regions, free, {{1, 1, 1}, {2, 1, 1}}));
  EXPECT_FALSE(assign(regions, free, {{1, 1, 1}, {2, 1, 1}, {3, 1, 1}}));
  EXPECT_EQ(free.size(), size_t{2});
  // The same regions can have pages of a larger texture.
  free = pages_to(3);
  ASSERT_TRUE(regions.assign(free));
  EXPECT_EQ(regions.new_pages().size(), size_t{3});
}

// The cells of a block reach the first lattice points of the next regions.
TEST(RenderLattice, ChangedChunksFreeThePagesAround) {
  const LatticeChunk one = chunk(1, {0, 0, 0}), two = chunk(2, {8, 0, 0});
  LatticeRegions regions;
  FreePages free = pages_to(4);
  regions.set_chunks(0, {two, one}, free);
  const auto assign_all = [&] {
    ASSERT_TRUE(assign(regions, free, {{1, 1, 1}, {7, 8, 0}, {8, 8, 0}, {9, 0, 0}}));
  };
  const auto new_pages = [&](uint32_t level, std::vector<LatticeChunk> chunks) {
    regions.set_chunks(level, std::move(chunks), free);
    assign_all();
    return regions.new_pages().size();
  };
  assign_all();
  EXPECT_EQ(new_pages(0, {one, two}), size_t{0});
  EXPECT_EQ(new_pages(0, {one}), size_t{2});
  EXPECT_EQ(new_pages(0, {one, two}), size_t{2});
  EXPECT_EQ(new_pages(0, {chunk(3, {0, 0, 0}), two}), size_t{3});
  LatticeChunk part = two;
  part.regions = RegionMask::of_block_below({0, 0, 0}, 1);
  EXPECT_EQ(new_pages(0, {chunk(3, {0, 0, 0}), part}), size_t{2});
  EXPECT_EQ(new_pages(1, {chunk(3, {0, 0, 0}), part}), size_t{4});
}

}  // namespace
}  // namespace isosplat::render
