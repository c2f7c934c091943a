flat in vec4 v_gradient;
layout(location = 0) out vec4 o_sum;

void main() { o_sum = v_gradient; }
