// A number that is added to the distance (px) of a known state (cap_states.frag.glsl) when the
// nearest one is chosen. States that follow from surfaces get a large number, so that they are
// chosen last. Where isovalues are crossed, bands of pixels of both states lie side by side, and
// either band may have gaps where cells are small in the image. Most unknown pixels are empty.
// Therefore, a higher state has to be nearer by the width of its band.
float unlikeliness(uint state) {
  float number = float(state & uint(CAP_BY_CELL - 1));
  return CAP_BAND_PX * number + (state < uint(CAP_BY_CELL) ? 1e6 : 0.0);
}
