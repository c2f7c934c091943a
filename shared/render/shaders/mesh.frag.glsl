in vec3 v_normal;
layout(location = 0) out uvec4 o_pixel;

void main() { o_pixel = encode_surface(v_normal, 0.0, 0u, 1.0); }
