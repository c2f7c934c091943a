// The part of the isosurface in a cell as triangles, for cells that are large in the image. Their
// corners are the points at which the surface crosses edges of the cell, so neighbouring cells
// join. The TRIANGLE_SLOTS vertices of a sample are a part of one strip through all cells
// (passes/triangle_cases.h): gl_VertexID is sample · TRIANGLE_SLOTS + slot.
uniform highp usampler2D u_samples;
uniform highp usampler2D u_cases;
uniform bool u_drops_hidden;       // drops cells that are occluded by u_drawn
uniform highp usampler2D u_drawn;  // depths of each tile (depth_tiles.frag.glsl)
uniform float u_quantized_isovalue;
uniform uint u_isosurface;
uniform vec3 u_scalar;  // weights of 1, gradient length

#ifdef SMOOTH
uniform highp usampler3D u_pages;
uniform highp sampler2D u_gradients;
uniform ivec3 u_first_region;  // of the block, in u_pages
#endif

#ifdef FIELD
// Its colour is that of the value at each fragment.
flat out vec4 v_field_a, v_field_b;  // the field's quantized values in the cell
out vec3 v_place;                    // in the cell, 0 to 1
#endif
#ifdef LINES
flat out vec4 v_a, v_b;  // the volume's quantized values in the cell
flat out float v_least_sine;
#endif
#ifdef LIT
out vec3 v_colour;  // FIELD: the light alone, linear
#else
out vec3 v_normal;
#ifndef FIELD
out float v_scalar;
#endif
#endif

// Whether a cell is outside of the image or, in all tiles that it touches, behind what is drawn. Large
// cells are not tested. e: the centre; h: half the edges.
bool is_hidden(vec3 e, vec3 h) {
  float z = dot(e, u_forward.xyz), nearest = z - dot(abs(u_forward.xyz), h);
  if (nearest < u_near_plane) return false;
  vec2 centre_px = to_px(e, z), half_px = half_extent_px(e, h, z) + 0.5;
  vec2 low_px = centre_px - half_px, high_px = centre_px + half_px;
  if (any(lessThan(high_px, vec2(0.0))) || any(greaterThan(low_px, u_image_size))) return true;
  vec2 last = u_image_size - 1.0;
  ivec2 low = ivec2(clamp(low_px, vec2(0.0), last)) / HIDING_TILE_PX;
  ivec2 high = ivec2(clamp(high_px, vec2(0.0), last)) / HIDING_TILE_PX;
  if (!u_drops_hidden || any(greaterThanEqual(high - low, ivec2(HIDING_MAX_TILES)))) return false;
  uint drawn = 0u;
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) drawn = max(drawn, texelFetch(u_drawn, ivec2(x, y), 0).x);
  }
  return window_depth(nearest) > uintBitsToFloat(drawn) + 1e-6;
}

// Bits of the six faces: whether the corners above the isovalue are connected, if the face is
// ambiguous (the asymptotic decider, joined_faces in shared/core/mesh). Both cells of a face compare
// the same products. lower, upper: values at the corners, minus the isovalue.
uint joined_faces(vec4 lower, vec4 upper) {
  // The diagonals with the first corner of the faces x = 0, x = 1, y = 0 and y = 1; z = 0 and z = 1.
  vec4 even = vec4(lower.xyxz * vec4(upper.zwyw));
  vec4 odd = vec4(lower.zwyw * upper.xyxz);
  vec2 even_z = vec2(lower.x * lower.w, upper.x * upper.w), odd_z = vec2(lower.y * lower.z, upper.y * upper.z);
  vec4 side = mix(vec4(-1.0), vec4(1.0), greaterThan(lower.xyxz, vec4(0.0)));
  vec2 side_z = mix(vec2(-1.0), vec2(1.0), greaterThan(vec2(lower.x, upper.x), vec2(0.0)));
  vec4 joined = mix(vec4(0.0), vec4(1.0, 2.0, 4.0, 8.0), greaterThan(side * even, side * odd));
  vec2 joined_z = mix(vec2(0.0), vec2(16.0, 32.0), greaterThan(side_z * even_z, side_z * odd_z));
  return uint(dot(joined, vec4(1.0)) + joined_z.x + joined_z.y);
}

// Bit i: corner i is above the isovalue. Zero counts as below, as in is_active.
uint corner_signs(vec4 lower, vec4 upper) {
  vec4 bits = mix(vec4(0.0), vec4(1.0, 2.0, 4.0, 8.0), greaterThan(lower, vec4(0.0)));
  bits += mix(vec4(0.0), vec4(16.0, 32.0, 64.0, 128.0), greaterThan(upper, vec4(0.0)));
  return uint(dot(bits, vec4(1.0)));
}

#ifdef SMOOTH
// The sum of the gradients around a lattice point of the block; w: the number of cells.
vec4 gradient_around(ivec3 point) {
  return texelFetch(u_gradients, texel_of(page_of(u_pages, u_first_region + (point >> 3)), point & 7), 0);
}
#endif

// The gradient by which a vertex is lit, in quantized values per cell, of any length. own: that of the
// cell. The vertex is on the edge from the lattice point `start` along an axis, at t.
vec3 gradient_at_vertex(vec3 own, ivec3 start, int axis, float t) {
#ifdef SMOOTH
  ivec3 end = start + ivec3(equal(ivec3(axis), ivec3(0, 1, 2)));
  vec4 sum = mix(gradient_around(start), gradient_around(end), t);
  float square = dot(sum.xyz, sum.xyz);
  return square > 0.0 && square < LATTICE_MOST_SQUARE ? sum.xyz : own;
#else
  return own;
#endif
}

void draw_vertex(Cell cell, vec4 lower, vec4 upper, int edge) {
  // CellEdge of shared/core/mesh: 4 · axis + the coordinates of the edge along the other axes.
  int axis = edge >> 2, along = edge & 3;
  vec4 start = axis == 0 ? vec4(lower.xz, upper.xz) : axis == 1 ? vec4(lower.xy, upper.xy) : lower;
  vec4 end = axis == 0 ? vec4(lower.yw, upper.yw) : axis == 1 ? vec4(lower.zw, upper.zw) : upper;
  vec4 chosen = vec4(equal(ivec4(along), ivec4(0, 1, 2, 3)));
  float from = dot(start, chosen);
  float t = from / (from - dot(end, chosen));
  vec2 other = vec2(along & 1, along >> 1);
  vec3 p = axis == 0 ? vec3(t, other) : axis == 1 ? vec3(other.x, t, other.y) : vec3(other, t);
  vec3 size = cell_size();
  vec3 position = block_corner() + (cell.low + p) * size;
  vec3 own = value_and_gradient(trilinear(lower, upper), p).yzw;
  float steepness = length(row_to_view(own / size));
  ivec3 start_point = ivec3(cell.low) + (axis == 0 ? ivec3(0, along & 1, along >> 1)
                                         : axis == 1 ? ivec3(along & 1, 0, along >> 1)
                                                     : ivec3(along & 1, along >> 1, 0));
  vec3 normal = row_to_view(gradient_at_vertex(own, start_point, axis, t) / size);
  float length_ = length(normal);
  normal = length_ > 0.0 ? normal / length_ : vec3(0.0, 0.0, 1.0);
  gl_Position = in_clip_space(position);
#ifdef FIELD
  v_place = p;
#else
  float scalar = dot(u_scalar.xy, vec2(1.0, steepness));
#endif
#if defined(LIT) && defined(FIELD)
  v_colour = lit(normal, to_eye_from(position), vec3(1.0));
#elif defined(LIT)
  vec3 base = base_colour(u_isosurface, scalar, dot(position, u_forward.xyz));
  v_colour = apply_gamma(vec4(lit(normal, to_eye_from(position), base), 1.0)).rgb;
#else
  v_normal = normal;
#ifndef FIELD
  v_scalar = scalar;
#endif
#endif
}

void main() {
  // Triangles with several vertices here are not drawn. Inside of the image no clipping is needed.
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
#ifdef LIT
  v_colour = vec3(0.0);
#else
  v_normal = vec3(0.0, 0.0, 1.0);
#ifndef FIELD
  v_scalar = 0.0;
#endif
#endif
#ifdef FIELD
  v_place = vec3(0.0);
  v_field_a = v_field_b = vec4(0.0);
#endif
#ifdef LINES
  v_a = v_b = vec4(0.0);
  v_least_sine = 0.0;
#endif
  int sample_ = gl_VertexID / TRIANGLE_SLOTS, slot = gl_VertexID % TRIANGLE_SLOTS;
  uvec4 words = texelFetch(u_samples, ivec2(sample_ % SAMPLE_TEXTURE_WIDTH, sample_ / SAMPLE_TEXTURE_WIDTH), 0);
  float low = float(words.y & 0xffffu), high = float(words.y >> 16);
  bool is_drawn = is_active(vec2(low, high), u_quantized_isovalue);
  SKIPPABLE_IF(is_drawn) {
    vec3 size = cell_size(), place = vec3(words.x & 63u, words.x >> 6 & 63u, words.x >> 12 & 63u);
    is_drawn = !is_hidden(block_corner() + (place + 0.5) * size, 0.5 * size);
  }
  SKIPPABLE_IF(is_drawn) {
    Cell cell = unpack_sample(words);
    vec4 lower = cell.lower - u_quantized_isovalue, upper = cell.upper - u_quantized_isovalue;
    uint signs = corner_signs(lower, upper);
    uvec4 edges = texelFetch(u_cases, ivec2(joined_faces(lower, upper), signs), 0);
    uint eight = slot < 8 ? edges.x : slot < 16 ? edges.y : edges.z;
    int edge = int(eight >> 4 * (slot & 7) & 15u);
    SKIPPABLE_IF(edge < 12) draw_vertex(cell, lower, upper, edge);
#ifdef FIELD
    Trilinear field = trilinear_field(fetch_field(sample_));
    v_field_a = field.a;
    v_field_b = field.b;
#endif
#ifdef LINES
    Trilinear values = trilinear(lower, upper);
    v_a = values.a;
    v_b = values.b;
    v_least_sine = least_sine_of(cell.interval);
#endif
  }
}
