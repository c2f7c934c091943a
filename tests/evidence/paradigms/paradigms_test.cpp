// All paradigms must find the same active cells, and the interval tree the same cells as a scan.
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/evidence/paradigms/interval_tree.h"
#include "tests/evidence/paradigms/paradigms.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

std::set<uint32_t> active_of(const IntervalTree& tree, float isovalue) {
  std::set<uint32_t> found;
  tree.for_each_active(isovalue, [&](uint32_t id) { EXPECT_TRUE(found.insert(id).second) << id; });
  return found;
}

void expect_same_as_scan(const std::vector<IntervalTree::Cell>& cells,
                         const std::vector<float>& isovalues) {
  const IntervalTree tree(cells);
  for (const float isovalue : isovalues) {
    std::set<uint32_t> expected;
    for (const auto& cell : cells) {
      if (is_active(cell.interval, isovalue)) expected.insert(cell.id);
    }
    EXPECT_EQ(active_of(tree, isovalue), expected) << isovalue;
  }
}

TEST(IntervalTree, FindsWhatAScanFinds) {
  std::mt19937 random(7);
  for (const int largest : {3, 40, 65535}) {
    std::vector<IntervalTree::Cell> cells;
    for (uint32_t id = 0; id < 500; ++id) {
      const auto a = static_cast<QuantizedValue>(random() % unsigned(largest + 1));
      const auto b = static_cast<QuantizedValue>(random() % unsigned(largest + 1));
      cells.push_back({{std::min(a, b), std::max(a, b)}, id});
    }
    std::vector<float> isovalues{-1, 0, 0.5f, 1, 2, 2.5f, 3, 20.5f, 40, 65534.5f, 65535, 1e9f};
    for (int i = 0; i < 50; ++i)
      isovalues.push_back(float(random() % unsigned(largest + 1)) + 0.5f);
    expect_same_as_scan(cells, isovalues);
  }
}

TEST(IntervalTree, HoldsEqualIntervalsAndNone) {
  expect_same_as_scan({}, {0, 1});
  std::vector<IntervalTree::Cell> equal(1000, {{4, 5}, 0});
  for (uint32_t i = 0; i < equal.size(); ++i) equal[i].id = i;
  expect_same_as_scan(equal, {3, 4, 4.5f, 5});
}

TEST(Paradigms, FindTheSameActiveCells) {
  // Waves of several widths, in more than one block along each axis, with odd sizes.
  const TestVolume volume = sampled_volume({75, 67, 70}, {1, 1, 2}, [](Vec3d p) {
    return 300 + 150 * std::sin(p.x / 5) * std::cos(p.y / 3) + 90 * std::sin(p.z / 2 + p.x);
  });
  const TemporaryFolder folder;
  const int32_t nx = 74, ny = 66, nz = 69;
  for (const double isovalue : {120.0, 250.5, 300.0, 431.5, 900.0}) {
    uint64_t active = 0;
    for (int32_t z = 0; z < nz; ++z) {
      for (int32_t y = 0; y < ny; ++y) {
        for (int32_t x = 0; x < nx; ++x) {
          active +=
              is_active(corner_interval(corners_at(volume, x, y, z)), static_cast<float>(isovalue));
        }
      }
    }
    std::set<uint64_t> hashes;
    for (size_t i = 0; i < kParadigmNames.size(); ++i) {
      const auto extractor = make_extractor(static_cast<Paradigm>(i), volume, folder.path(), true);
      const Extraction extraction = extractor->extract(isovalue);
      EXPECT_EQ(extraction.active_cells, active) << kParadigmNames[i];
      EXPECT_EQ(extraction.bytes > 0, active > 0) << kParadigmNames[i];
      EXPECT_GT(extractor->prepared_bytes(), 0u);
      hashes.insert(extraction.cells_hash);
    }
    EXPECT_EQ(hashes.size(), 1u) << isovalue;
  }
}

}  // namespace
}  // namespace isosplat
