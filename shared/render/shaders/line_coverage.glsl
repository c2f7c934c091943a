// How much of a pixel a contour line covers, 0 to 1. number: that of the line, a fraction between two
// lines. per_px: its change per px to the right and up. The width of a line is constant in the image.
// Lines that come close to each other fade, where they would alias.
float line_coverage(float number, vec2 per_px) {
  float density = length(per_px);  // lines per px
  float away_px = abs(number - floor(number + 0.5)) / density;
  float shown = (1.0 / density - LINE_LEAST_DISTANCE_PX) / (LINE_FULL_DISTANCE_PX - LINE_LEAST_DISTANCE_PX);
  float coverage = clamp(0.5 * LINE_WIDTH_PX + 0.5 - away_px, 0.0, 1.0) * clamp(shown, 0.0, 1.0);
  // Where the number is constant there is no line; nor where the change is not finite.
  return density > 0.0 && density < 1.0 ? coverage : 0.0;
}
