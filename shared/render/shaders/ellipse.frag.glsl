// A disc in the tangent plane, with the plane's depth and the gradient's first-order change.
flat in vec2 v_centre_px;
flat in vec3 v_distance;
flat in vec3 v_place, v_place_x, v_place_y;
flat in vec3 v_along, v_bend;
flat in vec3 v_gradient, v_gradient_x, v_gradient_y;
flat in float v_scalar;

uniform uint u_isosurface;

layout(location = 0) out uvec4 o_pixel;

void main() {
  vec2 d = gl_FragCoord.xy - v_centre_px;
  // A pixel is inside where its nearest point is: moved towards the centre by a part of a pixel.
  float distance_px = length(d);
  d *= 1.0 - min(ELLIPSE_LEAST_PX / max(distance_px, 1e-6), 1.0);
  vec3 from = d.x * v_place_x + d.y * v_place_y;
  // To second order the surface is where the plane is bent to. Where it bends out of the cell, the
  // ray passes it by.
  float bend = dot(v_bend, from.xxy * from.yzz);
  vec3 inside = abs(v_place + from + bend * v_along);
  if (dot(from, from) > ELLIPSE_RADIUS * ELLIPSE_RADIUS ||
      max(max(inside.x, inside.y), inside.z) > 0.5 + ELLIPSE_MARGIN_CELLS) {
    discard;
  }
  float z = v_distance.x + dot(v_distance.yz, d) + bend;
  gl_FragDepth = window_depth(z);
  vec3 normal = v_gradient + d.x * v_gradient_x + d.y * v_gradient_y;
  o_pixel = encode_surface(normal, v_scalar, u_isosurface, 1.0);
}
