// The points of occlusion.vert.glsl; blending adds those of one texel.
flat in vec4 v_answer;
layout(location = 0) out vec4 o_answer;

void main() { o_answer = v_answer; }
