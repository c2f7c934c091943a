// Adds the share of a cell to the smooth gradient of the surface at this pixel.
flat in vec3 v_low;
flat in vec4 v_lower, v_upper;
flat in float v_fade;

uniform highp usampler2D u_positions;  // positions.frag.glsl
uniform highp vec3 u_per_cell;      // cells per unit
uniform uint u_isosurface;

layout(location = 0) out vec4 o_sum;  // gradient, in units of u_gradient_weight; weight

void main() {
  uvec4 bits = texelFetch(u_positions, ivec2(gl_FragCoord.xy), 0);
  vec3 p = (uintBitsToFloat(bits.xyz) - v_low) * u_per_cell;
  vec3 low = low_hats(p), high = high_hats(p), sum = low + high;
  bool is_near = min(min(sum.x, sum.y), sum.z) > 0.0 && bits.w >> 28 == u_isosurface;
  o_sum = vec4(0.0);
  SKIPPABLE_IF(is_near) {
    vec4 share = corner_gradients(v_lower, v_upper, low, high);
    o_sum = vec4(share.xyz * u_per_cell, v_fade * share.w);
  }
}
