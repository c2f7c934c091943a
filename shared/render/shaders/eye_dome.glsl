// Eye-dome lighting (Boucheny 2009): darkens pixels that are farther away than their neighbours.
uniform float u_edge_strength, u_edge_radius_px;

const ivec2 kAround[8] = ivec2[8](ivec2(1, 0), ivec2(2, 2), ivec2(0, 1), ivec2(-2, 2), ivec2(-1, 0),
                                  ivec2(-2, -2), ivec2(0, -1), ivec2(2, -2));
float eye_dome(ivec2 at, int layer, float z) {
  float sum = 0.0, here = log_distance(z);
  for (int i = 0; i < 8; ++i) {
    float depth = depth_at(at + kAround[i] * int(u_edge_radius_px), layer);
    if (depth < 1.0) sum += max(0.0, here - log_distance(distance_of(depth)));
  }
  return exp2(-u_edge_strength * EDGE_SHADING_SLOPE * min(sum, EDGE_SHADING_MOST));
}
