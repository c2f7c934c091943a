// The dots of occlusion.vert.glsl; those of one texel are added up.
flat in vec4 v_answer;
layout(location = 0) out vec4 o_answer;

void main() { o_answer = v_answer; }
