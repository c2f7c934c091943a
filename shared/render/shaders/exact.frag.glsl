// Where the pixel's ray meets the cell's trilinear isosurface first.
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

layout(location = 0) out uvec4 o_pixel;

void main() {
  Ray ray = pixel_ray(v_centre, v_centre_px);
  float t;
  if (v_sample.w < 1.0) {
    // Thin structure in a coarse cell: the corners know no surface; a small piece of plane.
    t = (v_plane.w - dot(v_plane.xyz, ray.origin)) / dot(v_plane.xyz, ray.direction);
    vec3 inside = abs((ray.origin + t * ray.direction - v_sample.xyz) / v_size);
    if (!(max(max(inside.x, inside.y), inside.z) <= 0.5 * v_sample.w)) discard;
#ifdef CLIPPED
    vec2 between = clip_ray(ray, v_centre.xyz, vec2(t - 1.0, t + 1.0));
    if (t < between.x || t > between.y) discard;
#endif
  } else {
    vec3 origin = ray.origin / v_size + 0.5, direction = ray.direction / v_size;
    vec2 between = ray_in_cell(origin, direction, EXACT_MARGIN_CELLS);
    between.x = max(between.x, u_depth.z - v_centre.w);
#ifdef CLIPPED
    between = clip_ray(ray, v_centre.xyz, between);
#endif
    if (!(between.x <= between.y)) discard;
    origin += between.x * direction;
    t = first_root(cubic_along(Trilinear(v_a, v_b), origin, direction), between.y - between.x);
    if (t < 0.0) discard;
    t += between.x;
  }
  vec3 p = clamp((ray.origin + t * ray.direction) / v_size + 0.5, 0.0, 1.0);
  vec3 gradient = value_and_gradient(Trilinear(v_a, v_b), p).yzw / v_size;
  float steepness = length(gradient);
  vec3 normal = to_view(steepness > 0.0 ? gradient / steepness : v_plane.xyz);
  gl_FragDepth = window_depth(v_centre.w + t);
  o_pixel = encode_surface(normal, v_scalar + u_scalar.y * steepness * v_span, u_isosurface, 1.0);
}
