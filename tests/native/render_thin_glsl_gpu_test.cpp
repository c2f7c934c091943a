// Compares the GLSL functions for thin structures in coarse cells (thin.glsl) with the same
// formulas in double precision.
#include <algorithm>
#include <cmath>

#include "shared/render/shader_constants.h"
#include "shared/sampling/sample_neighbours.h"
#include "tests/native/cell_shader.h"

namespace isosplat {
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

struct CellValues {
  double mean = 0, low = 1e9, high = -1e9;
  double gradient[3] = {0, 0, 0};

  explicit CellValues(const UnpackedSample& sample) {
    for (size_t i = 0; i < 8; ++i) {
      const double value = double(sample.corners[i]);
      mean += value / 8;
      low = std::min(low, value);
      high = std::max(high, value);
      for (size_t axis = 0; axis < 3; ++axis)
        gradient[axis] += (i >> axis & 1 ? value : -value) / 4;
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
    const UnpackedSample sample = unpack_sample(samples_[i]);
    const CellValues cell(sample);
    const double isovalue = double(found[i][0][1]);
    const bool up = cell.mean < isovalue;
    const double span = sample.interval.max - sample.interval.min;
    const double peak =
        (up ? cell.high - sample.interval.min : sample.interval.max - cell.low) / span;
    const double level =
        (up ? isovalue - sample.interval.min : sample.interval.max - isovalue) / span;
    double expected = level;
    if (peak >= level) {
      const double lower = THIN_LOWER * std::sqrt(std::max(peak * (1 - peak) * (1 - level), 0.0));
      expected = std::min(level, peak * (1 - lower));
    }
    expected = up ? sample.interval.min + expected * span : sample.interval.max - expected * span;
    EXPECT_NEAR(double(found[i][0][0]), expected, 1e-3 * span) << "sample " << i;
    (std::abs(expected - isovalue) > 1 ? moved : same) += 1;
  }
  EXPECT_GT(moved, 50);
  EXPECT_GT(same, 50);
}

TEST_F(RenderThinGlslGpu, BoundsThinStructuresByTheirNeighbours) {
  constexpr double kVoxel = 0.25;
  const auto found =
      run_shader(samples_, std::string(kIsovalue) +
                               "vec3 low, high, spanned;\n"
                               "thin_box(cell, isovalue, 0.25, low, high, spanned);\n"
                               "o_0 = vec4(low, isovalue);\no_1 = vec4(high, 0.0);\n"
                               "o_2 = vec4(spanned, 0.0);\no_3 = vec4(0.0);\n");
  int boxes[4] = {0, 0, 0, 0};
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample sample = unpack_sample(samples_[i]);
    const CellValues cell(sample);
    const double isovalue = double(found[i][0][3]);
    if (cell.low <= isovalue && isovalue <= cell.high) continue;
    const bool up = cell.mean < isovalue;
    const double from = up ? sample.interval.min : sample.interval.max;
    const double span = (up ? sample.interval.max : sample.interval.min) - from;
    const double level = std::clamp((isovalue - from) / span, 0.01, 1.0);
    const double share =
        std::clamp(THIN_SHARE * (cell.mean - from) / span * -std::log(level), THIN_LEAST, 1.0);
    const NeighbourBits bits = neighbours_of(samples_[i]);
    bool spanned[3];
    int count = 0;
    for (size_t axis = 0; axis < 3; ++axis) count += spanned[axis] = (bits >> 2 * axis & 3) == 3;
    const auto leave_steepest = [&] {
      size_t steepest = 3;
      for (size_t axis = 0; axis < 3; ++axis) {
        if (spanned[axis] && (steepest == 3 || std::abs(cell.gradient[axis]) >
                                                   std::abs(cell.gradient[steepest]) + 1e-4)) {
          steepest = axis;
        }
      }
      spanned[steepest] = false;
      --count;
    };
    if (count == 3) leave_steepest();
    if (count == 2 && share < THIN_SHEET_VOXELS * kVoxel) leave_steepest();
    ++boxes[count];
    const double side = std::pow(share, 1.0 / (3 - count));
    for (size_t axis = 0; axis < 3; ++axis) {
      const double extent = spanned[axis] ? 1 : side;
      const double distance = cell.mean - from;
      const double middle =
          0.5 + (std::abs(distance) > 0.5 ? 0.25 * cell.gradient[axis] / distance : 0);
      const uint32_t pair = bits >> 2 * axis & 3;
      const double low = pair == 1   ? 0
                         : pair == 2 ? 1 - extent
                                     : std::clamp(middle - extent / 2, 0.0, 1 - extent);
      EXPECT_EQ(found[i][2][axis], spanned[axis] ? 1.0f : 0.0f) << "sample " << i;
      EXPECT_NEAR(double(found[i][0][axis]), low, 2e-3) << "sample " << i;
      EXPECT_NEAR(double(found[i][1][axis]), low + extent, 2e-3) << "sample " << i;
    }
  }
  for (int count = 0; count < 3; ++count) EXPECT_GT(boxes[count], 5) << count;
}

}  // namespace
}  // namespace isosplat
