// The isovalues that a store suggests: they show objects, not noise, padding or holders.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "native/builder/array_source.h"
#include "native/builder/survey.h"
#include "shared/core/builder/metadata.h"
#include "shared/import/open_volume.h"
#include "tests/native/test_files.h"

namespace isosplat {
namespace {

struct Interval {
  double low, high;
};

bool is_inside(double value, const std::vector<Interval>& intervals) {
  return std::any_of(intervals.begin(), intervals.end(), [&](const Interval& interval) {
    return interval.low <= value && value <= interval.high;
  });
}

std::vector<double> suggestions_for(VolumeSource& source) {
  const auto survey = survey_volume(source);
  EXPECT_TRUE(survey) << survey.error().message;
  return survey ? suggested_isovalues(survey->mapping, survey->statistics) : std::vector<double>{};
}

/// 1 in a ball about the middle of 96³ voxels, 0 outside, with a gradual change over two voxels, as
/// by a scanner.
double ball(Index3 p, double radius) {
  const double x = p.x - 47.5, y = p.y - 47.5, z = p.z - 47.5;
  return std::clamp(0.5 + 0.5 * (radius - std::sqrt(x * x + y * y + z * z)), 0.0, 1.0);
}

/// A volume of 96³ voxels, with normally distributed noise.
template <class T, class F>
std::vector<T> phantom(double noise, F&& value_at) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
  std::vector<T> voxels;
  for (int32_t z = 0; z < 96; ++z) {
    for (int32_t y = 0; y < 96; ++y) {
      for (int32_t x = 0; x < 96; ++x) {
        const double value = value_at(Index3{x, y, z}) + (noise > 0 ? normal(random) : 0);
        voxels.push_back(static_cast<T>(std::lround(value)));
      }
    }
  }
  return voxels;
}

template <class T>
std::vector<double> suggestions_for(const std::vector<T>& voxels) {
  VolumeGrid grid;
  grid.voxels = {96, 96, 96};
  ArraySource<T> source(grid, voxels);
  return suggestions_for(source);
}

TEST(Suggestions, AnObjectInNoiseComesBeforeTheNoise) {
  for (const double noise : {5.0, 15.0, 25.0}) {
    const auto found =
        suggestions_for(phantom<int16_t>(noise, [](Index3 p) { return 100 * ball(p, 30) + 20; }));
    ASSERT_FALSE(found.empty());
    EXPECT_TRUE(is_inside(found[0], {{45, 100}})) << found[0] << " at noise " << noise;
  }
}

TEST(Suggestions, TheBorderOfAPaddingIsNoObject) {
  // A scanner's field of view, and a fixed value outside of it.
  const auto found = suggestions_for(phantom<int16_t>(0, [](Index3 p) {
    const double x = p.x - 47.5, y = p.y - 47.5;
    if (x * x + y * y > 45 * 45) return -2000.0;
    static std::mt19937 random(4);
    return 1200 * ball(p, 25) + std::normal_distribution<double>(0, 20)(random);
  }));
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(is_inside(found[0], {{150, 1100}})) << found[0];
}

TEST(Suggestions, AFewOutliersDoNotHideAnObject) {
  auto voxels = phantom<int16_t>(10, [](Index3 p) { return 100 * ball(p, 30) + 20; });
  voxels[5000] = 32000;
  voxels[70000] = -32000;
  const auto found = suggestions_for(voxels);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(is_inside(found[0], {{45, 100}})) << found[0];
}

TEST(Suggestions, BothMaterialsAreAmongTheFirstThree) {
  const auto found = suggestions_for(phantom<int16_t>(
      10, [](Index3 p) { return -1000 + 1000 * ball(p, 40) + 800 * (ball(p, 30) - ball(p, 24)); }));
  ASSERT_GE(found.size(), 2u);
  const size_t first = std::min<size_t>(3, found.size());
  const auto shows = [&](Interval interval) {
    return std::any_of(found.begin(), found.begin() + static_cast<ptrdiff_t>(first),
                       [&](double isovalue) { return is_inside(isovalue, {interval}); });
  };
  EXPECT_TRUE(shows({-900, -100})) << ::testing::PrintToString(found);
  EXPECT_TRUE(shows({100, 780})) << ::testing::PrintToString(found);
}

TEST(Suggestions, LabelsHaveOneToo) {
  const auto found =
      suggestions_for(phantom<uint8_t>(0, [](Index3 p) { return std::floor(ball(p, 30)); }));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], 0.5);
}

TEST(Suggestions, AMaskIsCutInTheMiddle) {
  for (const double inside : {100.0, 255.0}) {
    for (const double radius : {20.0, 30.0, 41.0}) {
      const auto found = suggestions_for(
          phantom<uint8_t>(0, [&](Index3 p) { return inside * std::floor(ball(p, radius)); }));
      ASSERT_FALSE(found.empty());
      EXPECT_NEAR(found[0], inside / 2, 0.1 * inside) << radius;
    }
  }
}

TEST(Suggestions, AFewVoxelsInAnEmptyVolumeAreFound) {
  std::vector<uint8_t> voxels(96 * 96 * 96);
  for (const size_t z : {50, 51}) {
    for (const size_t y : {40, 41}) voxels[(z * 96 + y) * 96 + 30] = 200;
  }
  const auto found = suggestions_for(voxels);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(is_inside(found[0], {{20, 180}})) << found[0];
}

TEST(Suggestions, NoiseAloneIsShownForLackOfAnythingElse) {
  EXPECT_FALSE(suggestions_for(phantom<int16_t>(50, [](Index3) { return 0; })).empty());
  EXPECT_TRUE(suggestions_for(phantom<int16_t>(0, [](Index3) { return 7; })).empty());
}

/// What people would choose, seen in pictures.
const std::vector<std::pair<std::string, std::vector<Interval>>> kChosen{
    {"bonsai.nhdr", {{38, 100}}},  // the tree; below, a sheet of paper
    {"bunny_ct_i16.nrrd", {{700, 2300}}},
    {"engine.nhdr", {{25, 130}, {150, 240}}},
    {"chris_t1.nii.gz", {{5, 70}}},
    {"mr_t1_dicom", {{46, 72}}},
    {"lobster.nhdr", {{24, 75}}},
    {"CT_AVM.nii.gz", {{40, 250}}},
    {"cthead_tif", {{250, 900}, {1130, 1900}}},
    {"BostonTeapot.nhdr", {{15, 100}}},
    {"aneurysm.nhdr", {{25, 220}}},
    {"statueLeg.nhdr", {{15, 140}}},
    {"iron_protein.vtk", {{12, 200}}},
    {"mni152.nii.gz", {{25, 900}}},
    {"eun_brain.nii.gz", {{5, 70}}},
    {"ct_shear.nii.gz", {{-750, -100}, {120, 450}}},
    {"fetal_atlas_f32.nrrd", {{50, 330}}},
    {"fuel.nhdr", {{15, 180}}},
    {"hydrogenAtom.nhdr", {{5, 60}}},
    {"neghip.nhdr", {{15, 200}}},
    {"nucleon.nhdr", {{15, 180}}},
    {"shockwave.nhdr", {{60, 225}}},
    {"marschnerlobb.nhdr", {{70, 185}}},
};

TEST(Suggestions, AreWhatPeopleWouldChoose) {
  ISOSPLAT_NEEDS_VOLUMES(volumes);
  size_t first = 0;
  for (const auto& [name, intervals] : kChosen) {
    const auto opened = import::open_volume((volumes / name).string(), {});
    ASSERT_TRUE(opened) << opened.error().message;
    const auto found = suggestions_for(*opened->source);
    ASSERT_FALSE(found.empty()) << name;
    first += is_inside(found[0], intervals);
    const size_t three = std::min<size_t>(3, found.size());
    EXPECT_TRUE(std::any_of(found.begin(), found.begin() + static_cast<ptrdiff_t>(three),
                            [&](double isovalue) { return is_inside(isovalue, intervals); }))
        << name << ": " << ::testing::PrintToString(found);
  }
  // All but the test signal of Marschner and Lobb, whose waves are as long as those of noise.
  EXPECT_GE(first, kChosen.size() - 1);
}

}  // namespace
}  // namespace isosplat
