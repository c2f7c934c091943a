flat in uvec4 v_pixel;
layout(location = 0) out uvec4 o_pixel;

void main() { o_pixel = v_pixel; }
