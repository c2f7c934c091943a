// A piece of the tangent plane. Kinds: ellipse; blended in two passes, VISIBILITY (depth only) and
// accumulation.
flat in vec4 v_centre;
flat in vec2 v_centre_px;
flat in vec3 v_size;
flat in vec4 v_a, v_b;
flat in vec4 v_plane;
flat in vec4 v_sample;
flat in float v_scalar;
flat in float v_span;

uniform uint u_isosurface;
uniform vec3 u_scalar;

#if KIND == KIND_ELLIPSE
layout(location = 0) out uvec4 o_pixel;
#elif !defined(VISIBILITY)
layout(location = 0) out vec4 o_normal;  // normal x weight; coverage
layout(location = 1) out vec4 o_sums;    // weight x (1, depth, scalar); unused
#endif

void main() {
  Ray ray = pixel_ray(v_centre, v_centre_px);
  float along = dot(v_plane.xyz, ray.direction);
  float t = (v_plane.w - dot(v_plane.xyz, ray.origin)) / along;
  vec3 hit = ray.origin + t * ray.direction;

  // The piece is cut by its cell's box, a little enlarged; thin structure by a smaller one about
  // the sample.
  vec3 from = v_sample.w < 1.0 ? hit - v_sample.xyz : hit;
  vec3 inside = abs(from / v_size);
  float outermost = max(max(inside.x, inside.y), inside.z);
  float smallest = min(min(v_size.x, v_size.y), v_size.z);
  float px = v_centre.w * u_lens.y / smallest;  // size of a pixel in cells
  float edge = (0.5 + PLANE_MARGIN_CELLS) * v_sample.w * u_lens.w + PLANE_MARGIN_PX * px;
#if KIND == KIND_ELLIPSE || defined(VISIBILITY)
  if (!(outermost <= edge)) discard;
#else
  float coverage = clamp(0.5 + (edge - outermost) / px, 0.0, 1.0);
  if (!(coverage > 0.0)) discard;
#endif
#ifdef CLIPPED
  vec2 between = clip_ray(ray, v_centre.xyz, vec2(t - 1.0, t + 1.0));
  if (t < between.x || t > between.y) discard;
#endif

  float z = v_centre.w + t;
  if (z < u_depth.z) discard;
#if defined(VISIBILITY)
  gl_FragDepth = window_depth(z + BLEND_DEPTH_CELLS * smallest);
#else
  gl_FragDepth = window_depth(z);
  vec3 p = clamp(hit / v_size + 0.5, 0.0, 1.0);
  vec3 gradient = value_and_gradient(Trilinear(v_a, v_b), p).yzw / v_size;
  float steepness = length(gradient);
  vec3 normal = to_view(steepness > 0.0 ? gradient / steepness : v_plane.xyz);
  float scalar = v_scalar + u_scalar.y * steepness * v_span;
#if KIND == KIND_ELLIPSE
  o_pixel = encode_surface(normal, scalar, u_isosurface, 1.0);
#else
  vec3 apart = (hit - v_sample.xyz) / v_size;
  float weight = coverage * exp(-BLEND_FALLOFF * dot(apart, apart));
  o_normal = vec4(normal * weight, coverage);
  o_sums = vec4(weight * vec3(1.0, z, scalar), 0.0);
#endif
#endif
}
