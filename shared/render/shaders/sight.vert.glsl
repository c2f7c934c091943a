// One sample becomes one dot in the answer, at its region's place in its chunk's row: the px in
// which the picture shows a surface inside of its cell. No px shows two cells.
layout(location = 0) in uvec4 a_sample;
uniform vec4 u_block;        // as in splat.vert.glsl
uniform float u_isocodes[MAX_ISOSURFACES];
uniform int u_isocode_count;
uniform vec2 u_row;          // middle of the chunk's row in the answer, in rows; all rows
uniform highp sampler2DArray u_depths;
uniform int u_layers;        // 0 is opaque, the others are seen in front of it
flat out vec4 v_answer;

bool is_active_for_any(vec2 interval) {
  for (int i = 0; i < MAX_ISOSURFACES; ++i) {
    if (i < u_isocode_count && is_active(interval, u_isocodes[i])) return true;
  }
  return false;
}

// Whether a layer of the picture shows a surface inside of the box, at this px.
bool is_shown(ivec2 px, vec3 centre, vec3 half_box) {
  vec2 slope = (vec2(px) + 0.5 - 0.5 * u_image.xy) * u_lens.y;
  vec3 ray = u_step_forward.xyz + slope.x * u_step_right.xyz + slope.y * u_step_up.xyz;
  float opaque = texelFetch(u_depths, ivec3(px, 0), 0).x;
  for (int layer = 0; layer < u_layers; ++layer) {
    float depth = layer == 0 ? opaque : texelFetch(u_depths, ivec3(px, layer), 0).x;
    if (depth == 1.0 || depth > opaque) continue;
    vec3 hit = ray * distance_of(depth);
    if (all(lessThanEqual(abs(hit - centre), half_box))) return true;
  }
  return false;
}

// The px that show a surface inside of the box; of large boxes, an estimate.
int px_shown(vec3 centre, vec3 half_box) {
  float z = dot(centre, u_forward.xyz);
  float reach = dot(abs(u_forward.xyz), half_box);
  if (z + reach < u_depth.z) return 0;
  vec2 low = vec2(0.0), high = u_image.xy - 1.0;
  if (z - reach > u_depth.z) {
    vec2 extent = half_extent_px(centre, half_box, z);
    low = max(low, to_px(centre, z) - extent - 1.0);
    high = min(high, to_px(centre, z) + extent);
  }
  if (any(greaterThan(low, high))) return 0;
  ivec2 step = 1 + ivec2(high - low) / SIGHT_PROBES;
  int count = 0;
  for (int y = int(low.y) + step.y / 2; y <= int(high.y); y += step.y) {
    for (int x = int(low.x) + step.x / 2; x <= int(high.x); x += step.x) {
      count += int(is_shown(ivec2(x, y), centre, half_box));
    }
  }
  return count * step.x * step.y;
}

void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 1.0;
  v_answer = vec4(0.0);
  Cell cell = unpack_sample(a_sample);
  if (!is_active_for_any(cell.interval) || !is_drawn(cell.low)) return;
  vec3 half_box = 0.5 * u_block.w * u_cell.xyz;
  vec3 centre = u_block.xyz + u_block.w * u_cell.xyz * (cell.low + 0.5);
  float z = max(dot(centre, u_forward.xyz), u_depth.z);
  vec3 reach_of_unit = vec3(u_step_right.w, u_step_up.w, u_step_forward.w);
  int shown = px_shown(centre, half_box + SIGHT_MARGIN_PX * u_lens.y * z * reach_of_unit);
  if (shown == 0) return;

  uvec3 region = uvec3(cell.low) >> 3;
  uint bit = region.x + 8u * region.y + 64u * region.z;
  vec4 channel = vec4(equal(uvec4(bit & 3u), uvec4(0u, 1u, 2u, 3u)));
  v_answer = min(float(shown) / 255.0, 1.0) * channel;
  float column = (float(bit >> 2) + 0.5) / float(SIGHT_ROW_TEXELS);
  gl_Position = vec4(2.0 * vec2(column, u_row.x / u_row.y) - 1.0, 0.0, 1.0);
}
