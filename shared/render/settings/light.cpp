#include "shared/render/settings/light.h"

#include <algorithm>
#include <cmath>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

constexpr float kPi = 3.14159265f;

// Radiance of a white diffuse surface that faces the key light, and of the sky's parts, at strength
// 1: white surfaces that face the light are just not brighter than white paper.
constexpr float kKey = 0.86f;
constexpr float kZenith = 0.42f, kHorizon = 0.16f, kGround = 0.08f;
constexpr float kRim = 0.65f;

// Tints where colours do not stand for values: a warm key light, a blue zenith and a warm ground
// separate surfaces that grey light would show alike. Each has the luminance of white.
constexpr Vec3f kWhite{1, 1, 1};
constexpr Vec3f kKeyTint{1.021f, 0.998f, 0.956f};
constexpr Vec3f kZenithTint{0.94f, 1.01f, 1.075f};
constexpr Vec3f kGroundTint{1.06f, 0.99f, 0.925f};

// From behind, on the right: touches the outlines that the key light leaves dark.
constexpr Vec3f kRimDirection{0.76f, 0.19f, -0.62f};

constexpr float kNormalReflectance = 0.04f;  // of most dielectrics

Vec3f unit(Vec3f v) {
  return v * (1 / length(v));
}

Vec3f times(Vec3f a, Vec3f b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// Coefficients of the sky's radiance: 1, h, h², for sky_height() h.
std::array<Vec3f, 3> sky_polynomial(const LightSettings& settings, bool shows_values) {
  const float strength = limited(settings.sky, 0, 2);
  const Vec3f zenith = (shows_values ? kWhite : kZenithTint) * (kZenith * strength);
  const Vec3f ground = (shows_values ? kWhite : kGroundTint) * (kGround * strength);
  const Vec3f horizon = kWhite * (kHorizon * strength);
  return {horizon, (zenith - ground) * 0.5f, (zenith + ground) * 0.5f - horizon};
}

}  // namespace

float srgb_to_linear(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

float linear_to_srgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

Vec3f to_linear(Vec3f colour) {
  const auto linear = [](float v) { return srgb_to_linear(std::clamp(v, 0.0f, 1.0f)); };
  return {linear(colour.x), linear(colour.y), linear(colour.z)};
}

LightTerms light_terms(const LightSettings& settings, bool shows_values) {
  LightTerms terms;
  const float azimuth = limited(settings.azimuth, -180, 180) * (kPi / 180);
  const float elevation = limited(settings.elevation, -90, 90) * (kPi / 180);
  terms.key_direction = {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                         std::cos(azimuth) * std::cos(elevation)};
  terms.key = (shows_values ? kWhite : kKeyTint) * (kKey * limited(settings.key, 0, 2));
  // A cosine around the normal scales the spherical harmonics of order 0, 1, 2 by 1, 2/3, 1/4 (per
  // π), and h² = 1/3 + 2/3 P₂(h).
  const std::array<Vec3f, 3> sky = sky_polynomial(settings, shows_values);
  terms.sky = {sky[0] + sky[2] * 0.25f, sky[1] * (2.0f / 3), sky[2] * 0.25f};
  terms.rim_direction = unit(kRimDirection);
  terms.rim = kRim * limited(settings.rim, 0, 2);
  const float roughness = limited(settings.roughness, 0.1f, 1);
  terms.roughness_4 = roughness * roughness * roughness * roughness;
  terms.highlight = shows_values ? 0 : limited(settings.highlight, 0, 2);
  terms.least = shows_values ? kLeastValueShading : 0;
  terms.most = shows_values ? 1 : 100;
  return terms;
}

float sky_height(Vec3f direction) {
  return float(SKY_UP_Y) * direction.y + float(SKY_UP_Z) * direction.z;
}

Vec3f sky_radiance(const LightSettings& settings, bool shows_values, float h) {
  const std::array<Vec3f, 3> sky = sky_polynomial(settings, shows_values);
  return sky[0] + (sky[1] + sky[2] * h) * h;
}

float highlight(const LightTerms& terms, float n_l, float n_v, float n_h, float v_h) {
  const float a2 = terms.roughness_4;
  const float d = (n_h * a2 - n_h) * n_h + 1;
  const float visibility = 0.5f / (n_l * std::sqrt((n_v - a2 * n_v) * n_v + a2) +
                                   n_v * std::sqrt((n_l - a2 * n_l) * n_l + a2));
  const float away = 1 - v_h, away_2 = away * away;
  const float fresnel = kNormalReflectance + (1 - kNormalReflectance) * away_2 * away_2 * away;
  return terms.highlight * n_l * a2 / (d * d) * visibility * fresnel;
}

Vec3f lit(const LightTerms& terms, Vec3f normal, Vec3f to_eye, Vec3f colour, float open,
          float key_share) {
  if (dot(normal, to_eye) < 0) normal = normal * -1.0f;
  const float n_l = dot(normal, terms.key_direction);
  const float rim = terms.rim * std::max(dot(normal, terms.rim_direction), 0.0f);
  const float up = sky_height(normal);
  const Vec3f sky = terms.sky[0] + (terms.sky[1] + terms.sky[2] * up) * up;
  Vec3f light = (sky + kWhite * rim) * open + terms.key * (key_share * std::max(n_l, 0.0f));
  light = {limited(light.x, terms.least, terms.most), limited(light.y, terms.least, terms.most),
           limited(light.z, terms.least, terms.most)};
  Vec3f result = times(colour, light);
  if (n_l > 0) {
    const Vec3f half = unit(terms.key_direction + to_eye);
    const float n_v = std::max(dot(normal, to_eye), 1e-3f);
    const float strength = highlight(terms, n_l, n_v, dot(normal, half), dot(to_eye, half));
    result = result + terms.key * (key_share * strength);
  }
  return result;
}

float slice_openness(float normal, float negative_horizon, float positive_horizon) {
  const auto part = [normal](float horizon) {
    return std::cos(normal) + 2 * horizon * std::sin(normal) - std::cos(2 * horizon - normal);
  };
  return 0.25f * (part(negative_horizon) + part(positive_horizon));
}

float with_reflections(float open, float albedo) {
  const float a = 2.0404f * albedo - 0.3324f, b = -4.7951f * albedo + 0.6417f,
              c = 2.7552f * albedo + 0.6903f;
  return std::max(open, ((open * a + b) * open + c) * open);
}

float disc_share(float height) {
  const float x = std::clamp(height, -1.0f, 1.0f);
  return 0.5f + x * (0.6366f - 0.1366f * x * x);
}

}  // namespace isosplat::render
