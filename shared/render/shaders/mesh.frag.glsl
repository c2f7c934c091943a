#ifdef LIT
in vec3 v_colour;
layout(location = 0) out vec4 o_colour;

void main() { o_colour = vec4(v_colour, 1.0); }
#else
in vec3 v_normal;
layout(location = 0) out uvec4 o_pixel;

void main() { o_pixel = encode_surface(v_normal, 0.0, 0u, SIDE_UNKNOWN); }
#endif
