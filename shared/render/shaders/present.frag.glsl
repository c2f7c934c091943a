// Draws the mean of accumulated pictures.
uniform sampler2D u_sums;
uniform float u_weight;  // 1 / pictures
layout(location = 0) out vec4 o_colour;

void main() { o_colour = apply_gamma(u_weight * texelFetch(u_sums, ivec2(gl_FragCoord.xy), 0)); }
