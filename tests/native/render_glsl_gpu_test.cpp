// Compares the values of GLSL functions with the C++ functions that have the same formulas.
#include <cmath>
#include <cstring>

#include "shared/core/sampling/exact_projection.h"
#include "shared/core/sampling/projection.h"
#include "shared/core/sampling/smooth_gradients.h"
#include "shared/core/sampling/trilinear.h"
#include "tests/native/cell_shader.h"

namespace isosplat::render {
namespace {

using RenderGlslGpu = CellShaderTest;

TEST_F(RenderGlslGpu, UnpacksExactly) {
  const auto found = run_shader(samples_,
                                "Cell cell = unpack_sample(bits);\n"
                                "o_0 = vec4(cell.low, 1.0);\no_1 = cell.lower;\n"
                                "o_2 = cell.upper;\no_3 = vec4(cell.interval, 0.0, 0.0);\n");
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample truth = unpack_sample(samples_[i]);
    const auto& o = found[i];
    EXPECT_EQ(o[0], (std::array<float, 4>{float(truth.cell.x), float(truth.cell.y),
                                          float(truth.cell.z), 1}));
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_EQ(o[1][c], truth.corners[c]);
      EXPECT_EQ(o[2][c], truth.corners[4 + c]);
    }
    EXPECT_EQ(o[3][0], float(truth.interval.min));
    EXPECT_EQ(o[3][1], float(truth.interval.max));
  }
}

// Tolerances: 10⁻⁵ of the cell's span for value and gradient; 10⁻⁴ of a cell for Newton steps of at
// most one cell.
TEST_F(RenderGlslGpu, InterpolatesAndProjectsAsTheCoreDoes) {
  const auto found =
      run_shader(samples_,
                 "Cell cell = unpack_sample(bits);\n"
                 "Trilinear f = trilinear(cell.lower, cell.upper);\n"
                 "o_0 = value_and_gradient_at_centre(cell);\n"
                 "o_1 = value_and_gradient(f, vec3(0.25, 0.75, 0.1));\n"
                 "vec3 size = vec3(1.0, 1.5, 2.0);\n"
                 "float quantized_isovalue = mix(cell.interval.x, cell.interval.y, 0.3);\n"
                 "o_2 = vec4(newton_step(o_0.x, o_0.yzw / size, o_0.yzw / size, "
                 "quantized_isovalue), quantized_isovalue);\no_3 = vec4(0.0);\n");
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample sample = unpack_sample(samples_[i]);
    const Trilinear f(sample.corners);
    const float span = float(sample.interval.max - sample.interval.min);
    if (span == 0) continue;
    int row = 0;
    for (const Vec3f p : {Vec3f{0.5f, 0.5f, 0.5f}, Vec3f{0.25f, 0.75f, 0.1f}}) {
      const auto [value, gradient] = f.at(p);
      const auto& o = found[i][size_t(row++)];
      const float tolerance = 1e-5f * span + 1e-6f * value;
      EXPECT_NEAR(o[0], value, tolerance);
      EXPECT_NEAR(o[1], gradient.x, tolerance);
      EXPECT_NEAR(o[2], gradient.y, tolerance);
      EXPECT_NEAR(o[3], gradient.z, tolerance);
    }
    const auto [value, gradient] = f.at({0.5f, 0.5f, 0.5f});
    const Vec3f scaled{gradient.x, gradient.y / 1.5f, gradient.z / 2};
    const auto to = project({}, value, scaled, found[i][2][3]);
    if (!to || length(*to) > 1) continue;
    EXPECT_NEAR(found[i][2][0], to->x, 1e-4f + 1e-5f * value / span);
    EXPECT_NEAR(found[i][2][1], to->y, 1e-4f + 1e-5f * value / span);
    EXPECT_NEAR(found[i][2][2], to->z, 1e-4f + 1e-5f * value / span);
  }
}

// Rays that start on a face of the cell. The first root equals that of the core's cubic to 10⁻³ of
// a cell. Both find a root, or neither does, except for rays that graze the surface.
TEST_F(RenderGlslGpu, FindsTheRootsThatTheCoreFinds) {
  const auto found = run_shader(
      samples_,
      "Cell cell = unpack_sample(bits);\n"
      "float span = max(cell.interval.y - cell.interval.x, 1.0);\n"
      "Trilinear f = trilinear((cell.lower - cell.interval.x) / span - 0.4,\n"
      "                        (cell.upper - cell.interval.x) / span - 0.4);\n"
      "vec3 origin = vec3(cell.low.xy / 63.0, 0.0), direction = vec3(0.5 - origin.xy, 0.8);\n"
      "vec2 between = ray_in_cell(origin, direction, 0.0);\n"
      "o_0 = vec4(between, first_root(cubic_along(f, origin, direction), between.y), 0.0);\n"
      "o_1 = o_2 = o_3 = vec4(0.0);\n");
  int roots = 0, disagreements = 0;
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample sample = unpack_sample(samples_[i]);
    const float span = std::max(float(sample.interval.max - sample.interval.min), 1.0f);
    std::array<float, 8> corners;
    for (size_t c = 0; c < 8; ++c) {
      corners[c] = (sample.corners[c] - float(sample.interval.min)) / span;
    }
    const Vec3f origin{float(sample.cell.x) / 63, float(sample.cell.y) / 63, 0};
    const Vec3f direction{0.5f - origin.x, 0.5f - origin.y, 0.8f};
    // For rays from a face inwards, the root nearest to the origin is the first one.
    const auto truth = nearest_root_in_cell(Trilinear(corners), origin, direction, 0.4f);
    const float ours = found[i][0][2];
    if (truth.has_value() != (ours >= 0)) {
      ++disagreements;
      continue;
    }
    if (!truth) continue;
    ++roots;
    disagreements += std::abs(ours - *truth) > 1e-3f;
  }
  EXPECT_GT(roots, 300);
  EXPECT_LE(disagreements, 5);
}

// The extents of the points in which the isosurface crosses the cell's edges, to 10⁻⁵. Zero counts
// as below: an isovalue that is equal to corners crosses the same edges as one just above.
TEST_F(RenderGlslGpu, BoundsTheCrossingsOfTheEdges) {
  const auto found =
      run_shader(samples_,
                 "Cell cell = unpack_sample(bits);\n"
                 "float share = cell.low.x / 63.0;\n"
                 "float quantized_isovalue = share < 0.2 ? cell.lower.y : mix(cell.interval.x, "
                 "cell.interval.y, share);\n"
                 "vec3 along = cell.low.zxy / 32.0 - 1.0;\n"
                 "Crossings c = find_crossings(cell.lower - quantized_isovalue, "
                 "cell.upper - quantized_isovalue);\n"
                 "o_0 = vec4(extent(c, along), quantized_isovalue, 0.0);\n"
                 "o_1 = vec4(along, 0.0);\no_2 = o_3 = vec4(0.0);\n");
  int crossed = 0, equal = 0;
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample sample = unpack_sample(samples_[i]);
    const auto& o = found[i];
    const float isovalue = o[0][2];
    float low = 1e9f, high = -1e9f;
    for (size_t axis = 0; axis < 3; ++axis) {
      for (size_t corner = 0; corner < 8; ++corner) {
        if (corner >> axis & 1) continue;
        const float start = sample.corners[corner], end = sample.corners[corner | 1u << axis];
        if ((start > isovalue) == (end > isovalue)) continue;
        std::array<float, 3> place{float(corner & 1), float(corner >> 1 & 1), float(corner >> 2)};
        place[axis] = (isovalue - start) / (end - start);
        const float at = o[1][0] * place[0] + o[1][1] * place[1] + o[1][2] * place[2];
        low = std::min(low, at);
        high = std::max(high, at);
      }
    }
    EXPECT_NEAR(o[0][0], low, 1e-5f);
    EXPECT_NEAR(o[0][1], high, 1e-5f);
    crossed += low < high;
    equal += isovalue == float(sample.corners[1]);
  }
  EXPECT_GT(crossed, kSamples / 2);
  EXPECT_GT(equal, kSamples / 10);
}

// The box of the surface contains every change of sign between neighbours of a lattice of 9³ points
// in the cell, and most boxes are smaller than their cells. The function in the coordinates of a
// box has the values of the cell's function, to 10⁻⁵ of the span.
TEST_F(RenderGlslGpu, BoundsTheSurfaceInTheCell) {
  const auto found =
      run_shader(samples_,
                 "Cell cell = unpack_sample(bits);\n"
                 "float quantized_isovalue = mix(cell.interval.x, cell.interval.y, 0.02 + "
                 "cell.low.x / 65.0);\n"
                 "vec3 low, high;\n"
                 "bound_surface(find_crossings(cell.lower - quantized_isovalue, "
                 "cell.upper - quantized_isovalue), low, high);\n"
                 "Trilinear f = in_box(trilinear(cell.lower, cell.upper), low, high - low);\n"
                 "o_0 = vec4(low, quantized_isovalue);\no_1 = vec4(high, 0.0);\n"
                 "o_2 = vec4(value_and_gradient(f, vec3(0.25, 0.75, 0.1)).x);\no_3 = vec4(0.0);\n");
  int smaller = 0;
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample sample = unpack_sample(samples_[i]);
    const Trilinear f(sample.corners);
    const Vec3f low{found[i][0][0], found[i][0][1], found[i][0][2]};
    const Vec3f high{found[i][1][0], found[i][1][1], found[i][1][2]};
    const float isovalue = found[i][0][3];
    const float span = float(sample.interval.max - sample.interval.min);
    const auto within = [](float from, float to, float least, float most) {
      return to >= least - 1e-4f && from <= most + 1e-4f;
    };
    for (int at = 0; at < 9 * 9 * 9; ++at) {
      const Vec3f p{float(at % 9) / 8, float(at / 9 % 9) / 8, float(at / 81) / 8};
      for (const Vec3f step : {Vec3f{0.125f, 0, 0}, Vec3f{0, 0.125f, 0}, Vec3f{0, 0, 0.125f}}) {
        const Vec3f q = p + step;
        if (q.x > 1 || q.y > 1 || q.z > 1) continue;
        if ((f.at(p).value > isovalue) == (f.at(q).value > isovalue)) continue;
        EXPECT_TRUE(within(p.x, q.x, low.x, high.x) && within(p.y, q.y, low.y, high.y) &&
                    within(p.z, q.z, low.z, high.z))
            << "sample " << i;
      }
    }
    const Vec3f place{low.x + 0.25f * (high.x - low.x), low.y + 0.75f * (high.y - low.y),
                      low.z + 0.1f * (high.z - low.z)};
    EXPECT_NEAR(found[i][2][0], f.at(place).value, 1e-5f * (span + float(sample.interval.max)));
    const Vec3f extent = high - low;
    smaller += extent.x * extent.y * extent.z < 0.5f;
  }
  EXPECT_GT(smaller, kSamples / 10);
}

// Where a root lies beside an extremum, a Newton step from the root leads far away.
TEST_F(RenderGlslGpu, FindsARootBesideAnExtremum) {
  const auto found = run_shader(
      samples_,
      "vec4 k = vec4(0.00027863, -0.48001632, 0.65949959, -0.22652423);\n"
      "o_0 = vec4(first_root(k, 0.68736678), 0.0, 0.0, 0.0);\no_1 = o_2 = o_3 = vec4(0.0);\n");
  const float t = found.front()[0][0];
  const float residual = ((0.00027863f * t - 0.48001632f) * t + 0.65949959f) * t - 0.22652423f;
  EXPECT_GE(t, 0);
  EXPECT_LT(std::abs(residual), 1e-4f);
}

// No ray along which the cubic has a root is rejected, and most others are. At most 5 roots may be
// missed where the cubic only touches zero.
TEST_F(RenderGlslGpu, RejectsRaysWithoutRoots) {
  const auto found = run_shader(
      samples_,
      "Cell cell = unpack_sample(bits);\n"
      "vec4 k = (cell.lower - mix(cell.interval.x, cell.interval.y, 0.5)) / "
      "max(cell.interval.y - cell.interval.x, 1.0);\n"
      "o_0 = k;\no_1 = vec4(first_root(k, 0.8), may_cross(k, 0.8) ? 1.0 : 0.0, 0.0, 0.0);\n"
      "o_2 = o_3 = vec4(0.0);\n");
  int rootless = 0, rejected = 0, missed = 0;
  for (const auto& o : found) {
    const auto cubic = [&k = o[0]](float t) { return ((k[0] * t + k[1]) * t + k[2]) * t + k[3]; };
    bool has_root = false;
    for (int i = 0; i < 800; ++i) {
      has_root = has_root || (cubic(0.001f * float(i)) > 0) != (cubic(0.001f * float(i + 1)) > 0);
    }
    const bool may_cross = o[1][1] != 0;
    if (has_root) {
      EXPECT_TRUE(may_cross);
      missed += std::abs(cubic(o[1][0])) > 1e-4f;
    }
    rootless += !has_root;
    rejected += !may_cross;
  }
  EXPECT_GT(rootless, kSamples / 10);
  EXPECT_LE(missed, 5);
  EXPECT_GT(rejected, rootless / 2);
}

// In the cell, and up to more than a cell beyond it: relative to the cell's span, to 10⁻⁵.
TEST_F(RenderGlslGpu, SumsGradientsAsTheCoreDoes) {
  const auto found =
      run_shader(samples_,
                 "Cell cell = unpack_sample(bits);\n"
                 "vec3 p = cell.low / 20.0 - 1.1;\n"
                 "o_0 = corner_gradients(cell.lower, cell.upper, low_hats(p), high_hats(p));\n"
                 "o_1 = vec4(p, 0.0);\no_2 = o_3 = vec4(0.0);\n");
  int outside = 0;
  for (size_t i = 0; i < kSamples; ++i) {
    const UnpackedSample sample = unpack_sample(samples_[i]);
    const auto& o = found[i];
    const auto truth = corner_gradients(sample.corners, {o[1][0], o[1][1], o[1][2]});
    const float tolerance = 1e-5f * float(sample.interval.max);
    EXPECT_NEAR(o[0][0], truth.gradient.x, tolerance);
    EXPECT_NEAR(o[0][1], truth.gradient.y, tolerance);
    EXPECT_NEAR(o[0][2], truth.gradient.z, tolerance);
    EXPECT_NEAR(o[0][3], truth.weight, 1e-5f);
    outside += truth.weight == 0;
  }
  EXPECT_GT(outside, kSamples / 20);
  EXPECT_LT(outside, kSamples / 2);
}

}  // namespace
}  // namespace isosplat::render
