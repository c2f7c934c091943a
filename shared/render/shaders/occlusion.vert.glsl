// Each sample becomes a point in the result texture, at the texel of its region in the row of its
// chunk. Its value is the number of pixels that show a surface inside of the sample's cell (no pixel
// shows two cells). With u_in_front, it shows whether any part of the cell is in front of the surface
// of some pixel.
layout(location = 0) in uvec4 a_sample;
uniform float u_quantized_isovalues[MAX_ISOSURFACES];
uniform int u_isosurface_layers[MAX_ISOSURFACES];
uniform int u_isovalue_count;
uniform float u_row, u_rows; // centre of the chunk's row in the result, in rows; number of rows
uniform highp sampler2DArray u_depths;
uniform int u_layers;        // 0 is opaque, the others are translucent
uniform bool u_in_front;
uniform highp usampler2D u_farthest;  // opaque depth of each tile, for u_in_front
flat out vec4 v_answer;

// Bit i: the cell is active for an isosurface of layer i.
uint active_layers(vec2 interval) {
  uint found = 0u;
  for (int i = 0; i < MAX_ISOSURFACES; ++i) {
    if (i < u_isovalue_count && is_active(interval, u_quantized_isovalues[i])) {
      found |= 1u << u_isosurface_layers[i];
    }
  }
  return found;
}

// Whether a layer of the picture has a surface inside of the box at this pixel.
bool is_shown(ivec2 px, vec3 centre, vec3 half_box) {
  float opaque = texelFetch(u_depths, ivec3(px, 0), 0).x;
  for (int layer = 0; layer < u_layers; ++layer) {
    float depth = layer == 0 ? opaque : texelFetch(u_depths, ivec3(px, layer), 0).x;
    if (depth == 1.0 || depth > opaque) continue;
    vec3 hit = point_at(vec2(px) + 0.5, distance_of(depth));
    if (all(lessThanEqual(abs(hit - centre), half_box))) return true;
  }
  return false;
}

// Bounds of the pixels that the box may cover (low, high). All pixels if the near plane cuts the box.
ivec4 px_bounds(vec3 centre, vec3 half_box, float z, float reach) {
  vec2 low = vec2(0.0), high = u_image_size - 1.0;
  if (z - reach > u_near_plane) {
    vec2 extent = half_extent_px(centre, half_box, z);
    low = max(low, floor(to_px(centre, z) - extent - 1.0));
    high = min(high, floor(to_px(centre, z) + extent));
  }
  return ivec4(low, high);
}

// Number of pixels that show a surface inside of the box; an estimate for large boxes.
int px_shown(vec3 centre, vec3 half_box, ivec4 bounds) {
  ivec2 step = 1 + (bounds.zw - bounds.xy) / OCCLUSION_PROBES;
  int count = 0;
  for (int y = bounds.y + step.y / 2; y <= bounds.w; y += step.y) {
    for (int x = bounds.x + step.x / 2; x <= bounds.z; x += step.x) {
      count += int(is_shown(ivec2(x, y), centre, half_box));
    }
  }
  return count * step.x * step.y;
}

// The interval of a pixel's ray inside of the box and the clip planes, as distances along the view; empty
// if x > y.
vec2 ray_in_box(vec2 px, vec3 centre, vec3 half_box) {
  vec3 ray = ray_at(px), from = point_at(px, 0.0);
  vec3 along = mix(ray, vec3(1e-12), lessThan(abs(ray), vec3(1e-12)));
  vec3 first = (centre - from - half_box) / along, second = (centre - from + half_box) / along;
  vec3 enter = min(first, second), leave = max(first, second);
  vec2 between = vec2(max(max(enter.x, enter.y), max(enter.z, u_near_plane)),
                      min(min(leave.x, leave.y), leave.z));
  for (int i = 0; i < u_clip_planes; ++i) {
    float slope = dot(u_clip_plane[i].xyz, ray);
    float inside = dot(u_clip_plane[i].xyz, from) - u_clip_plane[i].w, t = -inside / slope;
    if (slope > 0.0) between.x = max(between.x, t);
    else if (slope < 0.0) between.y = min(between.y, t);
    else if (inside < 0.0) between.y = between.x - 1.0;
  }
  return between;
}

// Whether any part of the box is in front of the surface of this pixel, in the opaque layer or in one
// of these layers. A surface in this part would be visible.
bool is_in_front(ivec2 px, vec3 centre, vec3 half_box, uint layers) {
  vec2 between = ray_in_box(vec2(px) + 0.5, centre, half_box);
  if (between.x > between.y) return false;
  float nearest = window_depth(between.x) - OCCLUSION_DEPTH_MARGIN;
  if (nearest > texelFetch(u_depths, ivec3(px, 0), 0).x) return false;
  for (int layer = 0; layer < u_layers; ++layer) {
    if ((layers >> layer & 1u) == 0u) continue;
    if (layer == 0 || nearest <= texelFetch(u_depths, ivec3(px, layer), 0).x) return true;
  }
  return false;
}

// Whether is_in_front() holds at any pixel. Skips tiles whose farthest depth is nearer than the box.
// Very large boxes count as in front, since the test would take long.
bool is_anywhere_in_front(vec3 centre, vec3 half_box, ivec4 bounds, float nearest, uint layers) {
  ivec4 tiles = bounds / HIDING_TILE_PX;
  if (any(greaterThan(tiles.zw - tiles.xy, ivec2(OCCLUSION_MAX_TILES)))) return true;
  float depth = window_depth(nearest) - OCCLUSION_DEPTH_MARGIN;
  for (int tile_y = tiles.y; tile_y <= tiles.w; ++tile_y) {
    for (int tile_x = tiles.x; tile_x <= tiles.z; ++tile_x) {
      ivec2 tile = ivec2(tile_x, tile_y);
      if (depth > uintBitsToFloat(texelFetch(u_farthest, tile, 0).x)) continue;
      ivec2 low = max(bounds.xy, tile * HIDING_TILE_PX);
      ivec2 high = min(bounds.zw, tile * HIDING_TILE_PX + (HIDING_TILE_PX - 1));
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          if (is_in_front(ivec2(x, y), centre, half_box, layers)) return true;
        }
      }
    }
  }
  return false;
}

void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 1.0;
  v_answer = vec4(0.0);
  Cell cell = unpack_sample(a_sample);
  uint layers = active_layers(cell.interval);
  if (layers == 0u || !is_drawn(cell.low)) return;
  vec3 half_box = 0.5 * cell_size();
  vec3 centre = block_corner() + cell_size() * (cell.low + 0.5);
  float z = dot(centre, u_forward.xyz);
  vec3 reach_of_unit = u_reach_of_unit.xyz;
  if (u_in_front) half_box *= max(u_splat_scale, 1.0) * (1.0 + 2.0 * OCCLUSION_MARGIN_CELLS);
  else half_box += OCCLUSION_MARGIN_PX * u_per_focal_px * w_at(max(z, u_near_plane)) * reach_of_unit;
  float reach = dot(abs(u_forward.xyz), half_box);
  if (z + reach < u_near_plane || is_beside(centre, half_box)) return;
  ivec4 bounds = px_bounds(centre, half_box, z, reach);
  if (any(greaterThan(bounds.xy, bounds.zw))) return;
  int found;
  if (u_in_front) {
    float nearest = max(z - reach, u_near_plane);
    found = is_anywhere_in_front(centre, half_box, bounds, nearest, layers) ? OCCLUSION_MAX_PX : 0;
  } else {
    found = px_shown(centre, half_box, bounds);
  }
  if (found == 0) return;

  uvec3 region = uvec3(cell.low) >> 3;
  uint bit = region.x + 8u * region.y + 64u * region.z;
  vec4 channel = vec4(equal(uvec4(bit & 3u), uvec4(0u, 1u, 2u, 3u)));
  v_answer = min(float(found) / float(OCCLUSION_MAX_PX), 1.0) * channel;
  float column = (float(bit >> 2) + 0.5) / float(OCCLUSION_ROW_TEXELS);
  gl_Position = vec4(2.0 * vec2(column, u_row / u_rows) - 1.0, 0.0, 1.0);
}
