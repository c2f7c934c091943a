// The smooth normals of an isosurface's pixels: the gradients at the eight lattice points around the
// position, interpolated trilinearly. Pixels without a smooth normal stay 0.
uniform highp usampler2DArray u_surfaces;
uniform highp sampler2DArray u_depths;
uniform highp usampler3D u_pages;
uniform highp sampler2D u_gradients;
uniform int u_layer;
uniform uint u_isosurface;
uniform highp vec3 u_lattice_low;  // the first lattice point of u_pages
uniform highp vec3 u_per_cell;     // cells per unit
uniform float u_side_px;           // side of a cell, at distance 1
uniform vec2 u_smooth_px;          // x: side up to which cells keep their exact normals; y: 1 / (side from
                                   // which on they are smooth - x)
layout(location = 0) out uvec2 o_normal;

// xyz: in units of LATTICE_WEIGHT, in quantized values per cell; w: interpolated number of cells.
// corners: 8, or 0 for pixels that need no sum: software renderers skip a loop that no pixel of a group
// runs.
vec4 gradient_at(vec3 p, int corners) {
  vec3 low = floor(p), t = p - low;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < corners; ++i) {
    ivec3 side = ivec3(i & 1, i >> 1 & 1, i >> 2), point = ivec3(low) + side;
    uint page = page_of(u_pages, point >> 3);
    vec3 hat = mix(1.0 - t, t, vec3(side));
    sum += hat.x * hat.y * hat.z * texelFetch(u_gradients, texel_of(page, point & 7), 0);
  }
  return sum;
}

void main() {
  ivec3 at = ivec3(gl_FragCoord.xy, u_layer);
  float depth = texelFetch(u_depths, at, 0).x, z = distance_of(depth);
  uvec4 surface = texelFetch(u_surfaces, at, 0);
  float fade = clamp((u_side_px / w_at(z) - u_smooth_px.x) * u_smooth_px.y, 0.0, 1.0);
  bool is_smooth = depth < 1.0 && surface.w >> ISOSURFACE_SHIFT == u_isosurface && fade > 0.0;
  if (!is_smooth) discard;
  vec4 sum = gradient_at((point_at(gl_FragCoord.xy, z) - u_lattice_low) * u_per_cell, is_smooth ? 8 : 0);
  vec3 gradient = row_to_view(sum.xyz * u_per_cell);
  float steepness = length(gradient);
  vec3 own = decode_normal(surface.xy);
  bool is_known = steepness > 0.0 && dot(sum.xyz, sum.xyz) < LATTICE_MOST_SQUARE;
  vec3 normal = is_known ? mix(own, gradient / steepness, min(fade * sum.w, 1.0)) : own;
  o_normal = encode_normal(dot(normal, normal) > 0.0 ? normal : own);
}
