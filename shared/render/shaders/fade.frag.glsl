// Draws a mixture of two pictures.
uniform sampler2D u_from, u_to;
uniform float u_progress;  // 0 … 1
layout(location = 0) out vec4 o_colour;

void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  o_colour = mix(texelFetch(u_from, place, 0), texelFetch(u_to, place, 0), u_progress);
}
