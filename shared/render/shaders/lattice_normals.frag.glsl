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

// The term of a corner: its hat function times the gradient there.
vec4 corner_term(ivec3 point, uint page, float hat) {
  return hat * texelFetch(u_gradients, texel_of(page, point & 7), 0);
}

// xyz: in units of LATTICE_WEIGHT, in quantized values per cell; w: interpolated number of cells.
vec4 gradient_at(vec3 p) {
  vec3 floor_ = floor(p), t = p - floor_, s = 1.0 - t;
  ivec3 low = ivec3(floor_), region = low >> 3, high_region = (low + 1) >> 3;
  uint page = page_of(u_pages, region);
  // The pages of the corners that may be in other regions: those with high x, y, z.
  uint px = page, py = page, pxy = page, pz = page, pxz = page, pyz = page, pxyz = page;
  SKIPPABLE_IF(region.x != high_region.x) {
    px = pxy = pxz = pxyz = page_of(u_pages, ivec3(high_region.x, region.yz));
  }
  SKIPPABLE_IF(region.y != high_region.y) {
    py = pyz = page_of(u_pages, ivec3(region.x, high_region.y, region.z));
    pxy = pxyz = page_of(u_pages, ivec3(high_region.xy, region.z));
  }
  SKIPPABLE_IF(region.z != high_region.z) {
    pz = page_of(u_pages, ivec3(region.xy, high_region.z));
    pxz = page_of(u_pages, ivec3(high_region.x, region.y, high_region.z));
    pyz = page_of(u_pages, ivec3(region.x, high_region.yz));
    pxyz = page_of(u_pages, high_region);
  }
  vec4 low_z = s.y * (corner_term(low, page, s.x) + corner_term(low + ivec3(1, 0, 0), px, t.x)) +
               t.y * (corner_term(low + ivec3(0, 1, 0), py, s.x) + corner_term(low + ivec3(1, 1, 0), pxy, t.x));
  vec4 high_z = s.y * (corner_term(low + ivec3(0, 0, 1), pz, s.x) + corner_term(low + ivec3(1, 0, 1), pxz, t.x)) +
                t.y * (corner_term(low + ivec3(0, 1, 1), pyz, s.x) + corner_term(low + 1, pxyz, t.x));
  return s.z * low_z + t.z * high_z;
}

void main() {
  ivec3 at = ivec3(gl_FragCoord.xy, u_layer);
  float depth = texelFetch(u_depths, at, 0).x, z = distance_of(depth);
  uvec4 surface = texelFetch(u_surfaces, at, 0);
  float fade = clamp((u_side_px / w_at(z) - u_smooth_px.x) * u_smooth_px.y, 0.0, 1.0);
  bool is_smooth = depth < 1.0 && surface.w >> ISOSURFACE_SHIFT == u_isosurface && fade > 0.0;
  o_normal = uvec2(0u);
  SKIPPABLE_IF(is_smooth) {
    vec4 sum = gradient_at((point_at(gl_FragCoord.xy, z) - u_lattice_low) * u_per_cell);
    vec3 gradient = row_to_view(sum.xyz * u_per_cell);
    float steepness = length(gradient);
    vec3 own = decode_normal(surface.xy);
    vec3 normal = steepness > 0.0 ? mix(own, gradient / steepness, min(fade * sum.w, 1.0)) : own;
    o_normal = encode_normal(dot(normal, normal) > 0.0 ? normal : own);
  }
  if (o_normal.x == 0u) discard;
}
