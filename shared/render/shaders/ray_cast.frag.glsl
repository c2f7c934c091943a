// The first intersection of the pixel's ray with the cell's trilinear isosurface. Kinds: exact, also
// LIT; blended in two passes, VISIBILITY (depth only) and accumulation.
flat in vec4 v_centre;
#ifndef PULLED
flat in vec2 v_centre_px;
#endif
flat in vec3 v_size;
flat in vec4 v_a, v_b;
flat in float v_scalar;
flat in float v_span;

uniform uint u_isosurface;
uniform vec3 u_scalar;

#ifdef LIT
layout(location = 0) out vec4 o_colour;
#elif KIND == KIND_EXACT
layout(location = 0) out uvec4 o_pixel;
#elif !defined(VISIBILITY)
layout(location = 0) out vec4 o_normal;  // normal x weight; coverage
layout(location = 1) out vec4 o_sums;    // weight x (1, depth, scalar); unused
#endif

#if KIND == KIND_BLENDED && !defined(VISIBILITY)
// Coverage of the pixel by a surface that its ray just misses, from the distance in pixels at the
// closest approach `t`. Always less than a half, so that outlines do not move.
float near_miss(Trilinear f, vec4 k, vec3 origin, vec3 direction, float end, float z, out float t) {
  t = extremum(k, 0.0, end);
  if (t < 0.0) return 0.0;
  vec4 there = value_and_gradient(f, origin + t * direction);
  return 0.499 - abs(there.x) / (length(row_to_view(there.yzw / v_size)) * (z + t) * u_lens.y);
}
#endif

void main() {
#ifdef PULLED
  Ray ray = pixel_ray(v_centre);
#else
  Ray ray = pixel_ray(v_centre, v_centre_px);
#endif
  float t, coverage = 1.0;
  vec3 origin = ray.origin / v_size + 0.5, direction = ray.direction / v_size;
  Trilinear f = Trilinear(v_a, v_b);
  float margin = v_span > 511.0 ? ROUNDED_MARGIN_CELLS : EXACT_MARGIN_CELLS;
  vec2 between = ray_in_cell(origin, direction, margin);
  between.x = max(between.x, u_depth.z - v_centre.w);
#ifdef CLIPPED
  between = clip_ray(ray, v_centre.xyz, between);
#endif
  t = -1.0;
  if (between.x <= between.y) {
    vec3 enter = origin + between.x * direction;
    vec4 k = cubic_along(f, enter, direction);
    t = first_root(k, between.y - between.x);
#if KIND == KIND_BLENDED && !defined(VISIBILITY)
    if (t < 0.0) {
      float closest;
      coverage = near_miss(f, k, enter, direction, between.y - between.x,
                           v_centre.w + between.x, closest);
      if (coverage > 0.0) t = closest;
    }
#endif
  }
#if KIND == KIND_BLENDED && !defined(VISIBILITY)
  if (t < 0.0) {
    // Outside of its cell a splat covers nothing, but contributes its normal to its neighbours.
    coverage = 0.0;
    between = ray_in_cell(origin, direction, BLEND_MARGIN_CELLS);
    between.x = max(between.x, u_depth.z - v_centre.w);
#ifdef CLIPPED
    between = clip_ray(ray, v_centre.xyz, between);
#endif
    if (!(between.x <= between.y)) discard;
    vec4 k = cubic_along(f, origin + between.x * direction, direction);
    t = first_root(k, between.y - between.x);
  }
#endif
  if (t < 0.0) discard;
  t += between.x;
#ifdef VISIBILITY
  float thickness = u_right.w * min(min(v_size.x, v_size.y), v_size.z);
  gl_FragDepth = window_depth(v_centre.w + t + BLEND_DEPTH_CELLS * thickness);
#else
  vec3 p = (ray.origin + t * ray.direction) / v_size + 0.5;
  vec3 gradient = row_to_view(value_and_gradient(Trilinear(v_a, v_b), p).yzw / v_size);
  float steepness = length(gradient);
  vec3 normal = steepness > 0.0 ? gradient / steepness : vec3(0.0, 0.0, 1.0);
  gl_FragDepth = window_depth(v_centre.w + t);
  float scalar = v_scalar + u_scalar.y * steepness * v_span;
#ifdef LIT
  vec3 base = base_colour(u_isosurface, scalar, v_centre.w + t);
  o_colour = apply_gamma(vec4(lit(normal, eye_from(gl_FragCoord.xy), base), 1.0));
#elif KIND == KIND_EXACT
  o_pixel = encode_surface(normal, scalar, u_isosurface, 1.0);
#else
  // The weight is 1 inside of the cell, and 0 at the edge of the splat.
  vec3 place = abs(ray.origin + t * ray.direction) / v_size;
  vec3 beyond = max(place - 0.5 + BLEND_MARGIN_CELLS, 0.0) / (2.0 * BLEND_MARGIN_CELLS);
  vec3 fade = 1.0 - min(beyond, 1.0);
  float weight = max(fade.x * fade.y * fade.z, 1e-4) * max(coverage, coverage == 0.0 ? 1.0 : 0.1);
  o_normal = vec4(normal * weight, coverage);
  o_sums = vec4(weight * vec3(1.0, v_centre.w + t, scalar), 0.0);
#endif
#endif
}
