// Compares the GLSL functions for thin structures in coarse cells (thin.glsl) with the C++ ones.
#include <algorithm>
#include <cmath>

#include "shared/render/pick/thin_structure.h"
#include "tests/native/cell_shader.h"

namespace isosplat::render {
namespace {

/// Coarse cells whose intervals reach beyond their corners, with random neighbours.
class RenderThinGlslGpu : public CellShaderTest {
 protected:
  void SetUp() override {
    CellShaderTest::SetUp();
    std::mt19937 random(2);
    for (PackedSample& sample : samples_) {
      CellCorners corners;
      const uint32_t range = 20 + random() % 300;
      for (QuantizedValue& corner : corners)
        corner = static_cast<QuantizedValue>(1000 + random() % range);
      const CellInterval interval{static_cast<QuantizedValue>(1000 - random() % 90),
                                  static_cast<QuantizedValue>(1000 + range + random() % 90)};
      sample = pack_sample({int32_t(random() % 64), 0, 0}, interval, corners);
      sample.word[0] |= (random() & 15) << 18 | (random() & 3) << 30;
    }
  }
};

constexpr const char* kIsovalue =
    "Cell cell = unpack_sample(bits);\n"
    "float isovalue = mix(cell.interval.x, cell.interval.y, cell.low.x / 64.0);\n";

TEST_F(RenderThinGlslGpu, LowersTheIsovalueWhereCornersReachLittleBeyondIt) {
  const auto found = run_shader(samples_, std::string(kIsovalue) +
                                              "o_0 = vec4(thickened(cell, isovalue), isovalue, "
                                              "0.0, 0.0);\no_1 = o_2 = o_3 = vec4(0.0);\n");
  int moved = 0, same = 0;
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample cell = unpack_sample(samples_[i]);
    const float isovalue = found[i][0][1], expected = thickened_isovalue(cell, isovalue);
    const float span = float(cell.interval.max - cell.interval.min);
    EXPECT_NEAR(found[i][0][0], expected, 1e-3f * span) << "sample " << i;
    (std::abs(expected - isovalue) > 1 ? moved : same) += 1;
  }
  EXPECT_GT(moved, 50);
  EXPECT_GT(same, 50);
}

TEST_F(RenderThinGlslGpu, BoundsThinStructuresByTheirNeighbours) {
  const auto found =
      run_shader(samples_, std::string(kIsovalue) +
                               "vec3 low, high, spanned;\n"
                               "thin_box(cell, isovalue, 0.25, low, high, spanned);\n"
                               "o_0 = vec4(low, isovalue);\no_1 = vec4(high, 0.0);\n"
                               "o_2 = vec4(spanned, 0.0);\no_3 = vec4(0.0);\n");
  int boxes[4] = {0, 0, 0, 0};
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample cell = unpack_sample(samples_[i]);
    const float isovalue = found[i][0][3];
    if (is_within_corners(cell, isovalue)) continue;
    const ThinBox box = thin_box(cell, neighbours_of(samples_[i]), isovalue, 0.25);
    ++boxes[std::count(box.spanned.begin(), box.spanned.end(), true)];
    const double low[3] = {box.low.x, box.low.y, box.low.z};
    const double high[3] = {box.high.x, box.high.y, box.high.z};
    for (size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(found[i][2][axis], box.spanned[axis] ? 1.0f : 0.0f) << "sample " << i;
      EXPECT_NEAR(double(found[i][0][axis]), low[axis], 2e-3) << "sample " << i;
      EXPECT_NEAR(double(found[i][1][axis]), high[axis], 2e-3) << "sample " << i;
    }
  }
  for (int count = 0; count < 3; ++count) EXPECT_GT(boxes[count], 5) << count;
}

}  // namespace
}  // namespace isosplat::render
