// The light's formulas: C++ against integrals and published values, and GLSL against C++.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "native/headless/egl_context.h"
#include "shared/render/gl/gl_program.h"
#include "shared/render/passes/lighting.h"

namespace isosplat::render {
namespace {

constexpr int kCases = 512;
constexpr double kPi = 3.14159265358979;
using Texel = std::array<float, 4>;

/// Runs `body` for each case: it reads a, b, c, d (texels of the case) and sets o_colour.
std::vector<Texel> run_shader(std::initializer_list<std::string_view> files,
                              const std::vector<std::array<Texel, 4>>& cases,
                              const std::string& body,
                              const std::function<void(const GlProgram&)>& set_uniforms = {}) {
  std::string text = shader_text("", files);
  text +=
      "uniform sampler2D u_cases;\nlayout(location = 0) out vec4 o_colour;\n"
      "vec4 texel(int i) { return texelFetch(u_cases, ivec2(i, int(gl_FragCoord.x)), 0); }\n"
      "void main() {\n  vec4 a = texel(0), b = texel(1), c = texel(2);\n" +
      body + "}\n";
  GlProgram program = GlProgram::start(shader_text("", {"image.vert.glsl"}), text);
  const auto linked = program.finish();
  EXPECT_TRUE(linked) << linked.error().message;
  glUseProgram(program.name());
  GLuint textures[2], framebuffer = 0, vertex_array = 0;
  glGenTextures(2, textures);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, textures[0]);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, kCases, 1);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[0], 0);
  glBindTexture(GL_TEXTURE_2D, textures[1]);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, 4, kCases);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 4, kCases, GL_RGBA, GL_FLOAT, cases.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glUniform1i(program.uniform("u_cases"), 0);
  if (set_uniforms) set_uniforms(program);
  glGenVertexArrays(1, &vertex_array);
  glBindVertexArray(vertex_array);
  glViewport(0, 0, kCases, 1);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<Texel> result(kCases);
  glReadPixels(0, 0, kCases, 1, GL_RGBA, GL_FLOAT, result.data());
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  glDeleteTextures(2, textures);
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteVertexArrays(1, &vertex_array);
  return result;
}

Vec3f unit(Vec3f v) {
  return v * (1 / length(v));
}

/// A random direction, evenly distributed on the sphere.
Vec3f random_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return unit({normal(random), normal(random), normal(random)});
}

class LightGlslGpu : public ::testing::Test {
 protected:
  void SetUp() override {
    auto context = EglContext::create();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
  }
  std::unique_ptr<EglContext> context_;
};

// IEC 61966-2-1: mid-grey, the end of the linear part, and both ends.
TEST(Light, SrgbFollowsTheStandard) {
  EXPECT_EQ(srgb_to_linear(0), 0);
  EXPECT_NEAR(srgb_to_linear(1), 1, 1e-6);
  EXPECT_NEAR(srgb_to_linear(0.04045f), 0.0031308, 1e-6);
  EXPECT_NEAR(srgb_to_linear(128 / 255.0f), 0.215861, 1e-6);
  for (int i = 0; i <= 255; ++i) {
    EXPECT_NEAR(linear_to_srgb(srgb_to_linear(float(i) / 255)) * 255, i, 1e-2);
  }
}

TEST_F(LightGlslGpu, ConvertsSrgbAsTheCoreDoes) {
  std::vector<std::array<Texel, 4>> cases(kCases);
  for (size_t i = 0; i < kCases; ++i) cases[i][0][0] = float(i) / (kCases - 1);
  const auto found = run_shader({"gamma.glsl"}, cases,
                                "o_colour = vec4(to_linear(vec3(a.x)).x, from_linear(vec3(a.x)).x, "
                                "apply_gamma(vec4(vec3(0.5 * a.x), 0.5)).xw);\n");
  for (size_t i = 0; i < kCases; ++i) {
    const float x = cases[i][0][0];
    EXPECT_NEAR(found[i][0], srgb_to_linear(x), 2e-5) << x;
    EXPECT_NEAR(found[i][1] * 255, linear_to_srgb(x) * 255, 0.12) << x;
    EXPECT_NEAR(found[i][2], 0.5 * linear_to_srgb(x), 3e-4) << x;
    EXPECT_EQ(found[i][3], 0.5f);
  }
}

// The light of the sky in closed form is the integral of its radiance, weighted by the cosine, over
// the hemisphere around the normal.
TEST(Light, SkyIsTheIntegralOfItsRadiance) {
  LightSettings settings;
  settings.sky = 1.3f;
  const LightTerms terms = light_terms(settings, false);
  for (const float y : {-1.0f, -0.6f, 0.0f, 0.3f, 1.0f}) {
    const Vec3f normal{std::sqrt(1 - y * y), y, 0};
    Vec3d sum;
    double weight = 0;
    constexpr int kSteps = 200;
    for (int i = 0; i < kSteps; ++i) {
      const double height = -1 + (2 * i + 1.0) / kSteps;
      for (int j = 0; j < kSteps; ++j) {
        const double turn = 2 * kPi * j / kSteps, across = std::sqrt(1 - height * height);
        const double cosine =
            across * std::cos(turn) * double(normal.x) + height * double(normal.y);
        if (cosine <= 0) continue;
        const Vec3f radiance = sky_radiance(settings, false, float(height));
        sum = sum + Vec3d{radiance.x, radiance.y, radiance.z} * cosine;
        weight += cosine;
      }
    }
    const Vec3f closed = terms.sky[0] + (terms.sky[1] + terms.sky[2] * y) * y;
    EXPECT_NEAR(closed.x, sum.x / weight, 1e-3) << y;
    EXPECT_NEAR(closed.y, sum.y / weight, 1e-3) << y;
    EXPECT_NEAR(closed.z, sum.z / weight, 1e-3) << y;
  }
}

// Walter et al. 2007, equations 20, 23 and 33 (as G₁ by the Λ of Heitz 2014), written as in these
// papers.
TEST(Light, HighlightIsTheMicrofacetModel) {
  LightSettings settings;
  settings.highlight = 1;
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    settings.roughness = 0.15f + 0.8f * float(i) / 500;
    const LightTerms terms = light_terms(settings, false);
    Vec3f light = random_direction(random), eye = random_direction(random);
    light.z = std::abs(light.z) + 0.05f;
    eye.z = std::abs(eye.z) + 0.05f;
    light = unit(light);
    eye = unit(eye);
    const Vec3f half = unit(light + eye);
    const double alpha = double(settings.roughness) * double(settings.roughness);
    const auto lambda = [alpha](double cosine) {
      const double tangent_2 = 1 / (cosine * cosine) - 1;
      return (std::sqrt(1 + alpha * alpha * tangent_2) - 1) / 2;
    };
    const double n_h = half.z, n_l = light.z, n_v = eye.z;
    const double tangent_2 = 1 / (n_h * n_h) - 1;
    const double d =
        alpha * alpha / (kPi * std::pow(n_h, 4) * std::pow(alpha * alpha + tangent_2, 2));
    const double g = 1 / (1 + lambda(n_l) + lambda(n_v));
    const double f = 0.04 + 0.96 * std::pow(1 - double(dot(eye, half)), 5);
    const double truth = kPi * n_l * d * g * f / (4 * n_l * n_v);
    EXPECT_NEAR(highlight(terms, light.z, eye.z, half.z, dot(eye, half)), truth,
                1e-3 * truth + 1e-6);
  }
}

// Where colours stand for values the diffuse light is grey and limited, and there is no highlight.
TEST(Light, ValueColoursKeepTheirHue) {
  LightSettings settings;
  settings.key = settings.sky = settings.rim = settings.highlight = 2;
  std::mt19937 random(5);
  const Vec3f colour{0.1f, 0.4f, 0.25f};
  float least = 1, most = 0;
  for (int i = 0; i < 1000; ++i) {
    settings.key = float(i % 5) / 2;
    settings.sky = float(i % 3) / 2;
    const LightTerms terms = light_terms(settings, true);
    const float open = float(i % 11) / 10, key_share = float(i % 7) / 6;
    const Vec3f result =
        lit(terms, random_direction(random), random_direction(random), colour, open, key_share);
    const float factor = result.y / colour.y;
    EXPECT_NEAR(result.x, factor * colour.x, 1e-6);
    EXPECT_NEAR(result.z, factor * colour.z, 1e-6);
    least = std::min(least, factor);
    most = std::max(most, factor);
  }
  EXPECT_NEAR(least, kLeastValueShading, 1e-5);  // the limits are reached, and kept
  EXPECT_NEAR(most, 1, 1e-5);
}

TEST_F(LightGlslGpu, LightsAsTheCoreDoes) {
  std::mt19937 random(7);
  std::vector<std::array<Texel, 4>> cases(kCases);
  for (auto& texels : cases) {
    const Vec3f normal = random_direction(random), to_eye = random_direction(random);
    texels[0] = {normal.x, normal.y, normal.z, float(random() % 100) / 99};
    texels[1] = {to_eye.x, to_eye.y, to_eye.z, float(random() % 100) / 99};
    texels[2] = {0.3f, 0.6f, 0.8f, 0};
  }
  for (const ColourBy colour_by : {ColourBy::isosurface, ColourBy::gradient}) {
    RenderSettings settings;
    settings.colour_by = colour_by;
    settings.light.azimuth = 130;
    settings.light.rim = 0.9f;
    Lighting lighting;
    const auto found = run_shader({"frame.glsl", "light.glsl"}, cases,
                                  "o_colour = vec4(lit(a.xyz, b.xyz, c.xyz, a.w, b.w), 1.0);\n",
                                  [&](const GlProgram& program) {
                                    glUniform1i(program.uniform("u_colour_map"), 3);
                                    lighting.apply(program, settings, settings.isosurfaces);
                                  });
    const LightTerms terms = light_terms(settings.light, colour_by != ColourBy::isosurface);
    for (size_t i = 0; i < kCases; ++i) {
      const Texel &a = cases[i][0], &b = cases[i][1], &c = cases[i][2];
      const Vec3f truth =
          lit(terms, {a[0], a[1], a[2]}, {b[0], b[1], b[2]}, {c[0], c[1], c[2]}, a[3], b[3]);
      const float tolerance = 1e-4f + 1e-3f * std::max({truth.x, truth.y, truth.z});
      EXPECT_NEAR(found[i][0], truth.x, tolerance);
      EXPECT_NEAR(found[i][1], truth.y, tolerance);
      EXPECT_NEAR(found[i][2], truth.z, tolerance);
    }
  }
}

// A slice's share is the integral of the cosine to the normal between the horizons, with the weight
// of a slice of the sphere.
TEST(Light, SliceIsTheIntegralBetweenItsHorizons) {
  for (const double normal : {-0.9, 0.0, 0.4}) {
    for (const double low : {-0.3, -0.65}) {
      for (const double high : {0.2, 1.1}) {
        constexpr int kSteps = 20000;
        double sum = 0;
        for (int i = 0; i < kSteps; ++i) {
          const double angle = low + (high - low) * (i + 0.5) / kSteps;
          sum += std::cos(angle - normal) * std::abs(std::sin(angle)) * (high - low) / kSteps;
        }
        EXPECT_NEAR(slice_openness(float(normal), float(low), float(high)), sum, 1e-4);
      }
    }
  }
}

TEST_F(LightGlslGpu, OccludesAsTheCoreDoes) {
  std::mt19937 random(9);
  std::vector<std::array<Texel, 4>> cases(kCases);
  const auto number = [&](float low, float high) {
    return low + (high - low) * float(random() % 1001) / 1000;
  };
  for (auto& texels : cases) {
    const float normal = number(-1.5f, 1.5f);
    texels[0] = {normal, number(normal - 1.57f, 0), number(0, normal + 1.57f), number(0, 1)};
    texels[1] = {number(0, 0.9f), number(-1.5f, 1.5f), 0, 0};
  }
  const auto found =
      run_shader({"frame.glsl", "light.glsl", "depths.glsl", "occlusion.glsl"}, cases,
                 "o_colour = vec4(slice_openness(a.x, a.y, a.z), with_reflections(a.w, b.x), "
                 "disc_share(b.y), 0.0);\n");
  for (size_t i = 0; i < kCases; ++i) {
    const Texel &a = cases[i][0], &b = cases[i][1];
    EXPECT_NEAR(found[i][0], slice_openness(a[0], a[1], a[2]), 1e-4);
    EXPECT_NEAR(found[i][1], with_reflections(a[3], b[0]), 1e-5);
    EXPECT_NEAR(found[i][2], disc_share(b[1]), 1e-5);
  }
}

TEST(Light, DiscShareIsNearTheAreaOfASegment) {
  for (double x = -1.2; x <= 1.2; x += 0.01) {
    const double at = std::clamp(x, -1.0, 1.0);
    const double truth = 0.5 + (at * std::sqrt(1 - at * at) + std::asin(at)) / kPi;
    EXPECT_NEAR(disc_share(float(x)), truth, 0.01) << x;
  }
}

}  // namespace
}  // namespace isosplat::render
