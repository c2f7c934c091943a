#include "shared/render/passes/accumulation.h"

#include <cmath>

namespace isosplat::render {

ImageOffset Accumulation::offset(int n) {
  // Powers of the inverse of the plastic number, the root of x³ = x + 1.
  constexpr double kAcross = 0.7548776662466927, kUp = 0.5698402909980532;
  const auto centred = [](double x) { return x - std::floor(x) - 0.5; };
  return {centred(0.5 + n * kAcross), centred(0.5 + n * kUp)};
}

Result<void> Accumulation::begin(int width, int height) {
  if (auto ok = sums_.prepare(width, height); !ok) return ok;
  pictures_ = 0;
  const float nothing[4] = {0, 0, 0, 0};
  glBindFramebuffer(GL_FRAMEBUFFER, sums_.framebuffer());
  glClearBufferfv(GL_COLOR, 0, nothing);
  return {};
}

void Accumulation::release() {
  sums_.release();
  pictures_ = 0;
}

void Accumulation::abandon() {
  sums_.abandon();
  pictures_ = 0;
}

}  // namespace isosplat::render
