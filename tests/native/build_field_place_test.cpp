#include <gtest/gtest.h>

#include "native/builder/field_place.h"

namespace isosplat {
namespace {

VolumeGrid grid(Index3 voxels, double spacing, Vec3d origin) {
  VolumeGrid made;
  made.voxels = voxels;
  made.spacing = {spacing, spacing, spacing};
  made.origin = origin;
  return made;
}

const VolumeGrid kVolume = grid({32, 32, 32}, 2, {-31, -31, -31});

TEST(BuildFieldPlace, TheSameVoxelsAreNotResampledAndTurnedOnesAre) {
  const auto same = find_field_place("a", kVolume, kVolume);
  ASSERT_TRUE(same);
  EXPECT_FALSE(same->is_assumed);
  // The axes of a cube in another order: its first and its last voxel are at the same places.
  VolumeGrid turned = kVolume;
  turned.direction = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  const auto place = find_field_place("a", kVolume, turned);
  ASSERT_TRUE(place);
  EXPECT_FALSE(place->is_assumed);
  EXPECT_EQ(place->grid.direction, turned.direction);
  turned.origin = {};  // not stated, but the axes are
  EXPECT_FALSE(find_field_place("a", kVolume, turned)->is_assumed);
}

TEST(BuildFieldPlace, VoxelsWithoutAPlaceAreThoseOfTheVolume) {
  for (const VolumeGrid& field : {grid({32, 32, 32}, 1, {}), grid({32, 32, 32}, 2, {})}) {
    const auto place = find_field_place("a", kVolume, field);
    ASSERT_TRUE(place) << place.error().message;
    EXPECT_TRUE(place->is_assumed);
    EXPECT_EQ(place->grid.origin, kVolume.origin);
  }
  const auto refused = find_field_place("a", kVolume, grid({5, 5, 5}, 1, {}));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("states no place"), std::string::npos);
  // Unless it is certain that the volume has one.
  const VolumeGrid plain = grid({17, 17, 17}, 1, {});
  EXPECT_FALSE(find_field_place("a", plain, kVolume));
  EXPECT_TRUE(find_field_place("a", plain, kVolume, true));
}

TEST(BuildFieldPlace, FieldsElsewhereAreRefused) {
  const auto elsewhere = find_field_place("a", kVolume, grid({9, 9, 9}, 2, {33.1, 0, 0}));
  ASSERT_FALSE(elsewhere);
  EXPECT_NE(elsewhere.error().message.find("places it elsewhere"), std::string::npos);
  EXPECT_TRUE(find_field_place("a", kVolume, grid({9, 9, 9}, 2, {31, 0, 0})));
}

}  // namespace
}  // namespace isosplat
