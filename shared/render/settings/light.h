#pragma once

#include <algorithm>
#include <array>

#include "shared/core/base/vec3.h"

namespace isosplat::render {

/// The light on isosurfaces, and their material. Directions are those of the camera's frame, so
/// that the light stays where it is when the volume is turned. All numbers are limited to the
/// stated ranges where they are used; NaN counts as the lower limit.
struct LightSettings {
  float azimuth = -45;     ///< of the key light: degrees, −180 … 180; negative: from the left
  float elevation = 45;    ///< of the key light: degrees above the view's horizon, −90 … 90
  float key = 1;           ///< strength of the key light, 0 … 2
  float sky = 1;           ///< strength of the light from all sides, brightest from above, 0 … 2
  float rim = 0.3f;        ///< strength of the light from behind, on the right, 0 … 2
  float highlight = 0.6f;  ///< strength of the reflection of the key light, 0 … 2
  float roughness = 0.4f;  ///< of the material, 0.1 … 1: wide and faint highlights where it is high
  float occlusion = 1;     ///< share of the occluded sky light that is taken away, 0 … 1
  /// How far occluders reach, as a share of the radius of the visible part of the volume, 0.001
  /// … 1.
  float occlusion_radius = 0.2f;
  float shadow = 0.9f;           ///< share of the occluded key light that is taken away, 0 … 1
  float shadow_softness = 0.1f;  ///< radius of the key light at distance 1, 0.01 … 0.5

  friend bool operator==(const LightSettings&, const LightSettings&) = default;
};

/// Colours that show values are multiplied by a grey factor in this range, without highlights: hue
/// and saturation stay those of the legend, and the lightness L* stays above 0.67 times the
/// legend's, with the edge shading included (kLeastEdgeShading).
inline constexpr float kLeastValueShading = 0.4f;
inline constexpr float kLeastEdgeShading = 0.75f;

/// `value` within [low, high]; low if it is not a number.
inline float limited(float value, float low, float high) {
  return value > low ? std::min(value, high) : low;
}

/// The sRGB transfer function (IEC 61966-2-1) and its inverse, 0 … 1.
float srgb_to_linear(float encoded);
float linear_to_srgb(float linear);
/// Converts each channel, and clamps it to 0 … 1.
Vec3f to_linear(Vec3f colour);

/// The numbers with which shaders/light.glsl computes. Vectors are in the camera's frame (right,
/// up, towards the eye). Colours are linear.
struct LightTerms {
  Vec3f key_direction;  ///< towards the light, unit length
  Vec3f key;            ///< radiance of a white diffuse surface that faces the key light
  /// Radiance of a white diffuse surface below the sky alone: sky[0] + h (sky[1] + h sky[2]), where
  /// h is the sky_height() of its normal.
  std::array<Vec3f, 3> sky;
  Vec3f rim_direction;
  float rim = 0;
  float roughness_4 = 0;  ///< fourth power of the roughness, the α² of GGX
  float highlight = 0;
  float least = 0, most = 0;  ///< limits of the diffuse light
};

/// `shows_values`: colours stand for values, see kLeastValueShading.
LightTerms light_terms(const LightSettings& settings, bool shows_values);

/// The cosine between a direction (unit length) and the sky's zenith, which is above, and tilted
/// towards the eye.
float sky_height(Vec3f direction);

/// Radiance of the sky from a direction with sky_height() h: a quadratic polynomial through the
/// radiance of ground (−1), horizon (0) and zenith (1). Its convolution with a cosine is known in
/// closed form, for which order 2 of spherical harmonics is exact (R. Ramamoorthi, P. Hanrahan, "An
/// efficient representation for irradiance environment maps", SIGGRAPH 2001).
Vec3f sky_radiance(const LightSettings& settings, bool shows_values, float h);

/// Radiance of the highlight, for a key light of radiance 1 on white: GGX (B. Walter et al.,
/// "Microfacet models for refraction through rough surfaces", EGSR 2007), visibility by Smith with
/// correlated heights (E. Heitz, JCGT 2014), Fresnel reflection by Schlick with 0.04 at normal
/// incidence. Arguments are cosines between normal, light, eye and the half vector; n_l, n_v > 0.
float highlight(const LightTerms& terms, float n_l, float n_v, float n_h, float v_h);

/// Radiance of a surface, as lit() in shaders/light.glsl: both sides are lit alike. `normal`,
/// `to_eye`: unit length. `open`, `key_share`: shares of sky and key light that reach the surface.
Vec3f lit(const LightTerms& terms, Vec3f normal, Vec3f to_eye, Vec3f colour, float open = 1,
          float key_share = 1);

/// Share of the cosine-weighted sky in one slice of the hemisphere, between two horizons (J.
/// Jimenez et al., "Practical real-time strategies for accurate indirect occlusion", 2016,
/// equation 7), as slice_openness() in shaders/occlusion.glsl. Angles in radians, from the
/// direction to the eye: of the normal in the slice, and of the horizons, negative and positive.
/// Multiplied by the normal's length in the slice, its mean over all slices is the share of the
/// sky.
float slice_openness(float normal, float negative_horizon, float positive_horizon);

/// Share of the sky light that reaches a surface if `open` is the share of the sky that it sees:
/// adds the light that surfaces around it reflect (Jimenez et al. 2016, section 6). `albedo`: 0
/// … 1.
float with_reflections(float open, float albedo);

/// Share of the key light's disc that is visible above a straight edge, to 0.01. `height` of the
/// disc's centre above the edge, in radii of the disc: 0 below −1, 1 above 1.
float disc_share(float height);

}  // namespace isosplat::render
