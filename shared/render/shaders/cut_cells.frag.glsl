// The number of isovalues that are reached where the ray enters the part that is shown, plus 1; with
// CAP_ESTIMATED if there is a margin.
flat in vec3 v_low, v_size;
flat in vec4 v_a, v_b;
flat in float v_isovalue;

uniform int u_rank;                            // number of isovalues up to the cell's
uniform float u_reachable[MAX_ISOSURFACES];    // quantized isovalues in ascending order
uniform int u_reachable_count;
uniform float u_margin_px;
layout(location = 0) out uint o_reached;

void main() {
  float z;
  int plane = entry(gl_FragCoord.xy, z);
  if (plane < 0) discard;
  vec3 p = (point_at(gl_FragCoord.xy, z) - v_low) / v_size;
  // The size of a pixel on the face. On oblique faces, it is larger than across the view, but
  // limited to twice this size.
  vec3 normal = normalize(row_to_view(u_clip_plane[plane].xyz));
  float facing = max(abs(dot(normal, eye_from(gl_FragCoord.xy))), 0.5);
  vec3 reach_of_unit = u_reach_of_unit.xyz;
  vec3 margin = u_margin_px * w_at(z) * u_per_focal_px / facing * reach_of_unit / v_size;
  margin = CUT_MARGIN_CELLS + min(margin, 0.9);
  if (any(greaterThan(abs(p - 0.5), 0.5 + margin))) discard;
  // In the margin, the nearest point of the cell decides: a neighbour that is not active is on the
  // same side of the isovalue as the face between the two cells.
  float value = value_and_gradient(Trilinear(v_a, v_b), clamp(p, 0.0, 1.0)).x;
  int count = 0;
  for (int i = 0; i < u_reachable_count; ++i) count += int(value > u_reachable[i]);
  // The isovalue of coarse cells is lowered where they contain thin structures.
  o_reached = uint(value > v_isovalue ? max(count, u_rank) : min(count, u_rank - 1)) + 1u;
  if (u_margin_px > 0.0) o_reached |= uint(CAP_ESTIMATED);
}
