#include "native/demo/demo_volumes.h"
#include "native/demo/parallel_slices.h"
#include "shared/core/base/portable_math.h"

namespace isosplat {

std::vector<uint8_t> marschner_lobb(int32_t size, unsigned threads) {
  constexpr double kFrequency = 6;
  constexpr double kAlpha = 0.25;
  const double step = 2.0 / (size - 1);
  const auto count = static_cast<size_t>(size);
  std::vector<uint8_t> values(count * count * count);
  for_each_slice(size, threads, [&](int32_t zi) {
    const double vertical = 1 - portable::sin(portable::kPi * (-1 + step * zi) / 2);
    uint8_t* out = &values[static_cast<size_t>(zi) * count * count];
    for (int32_t yi = 0; yi < size; ++yi) {
      for (int32_t xi = 0; xi < size; ++xi) {
        const double x = -1 + step * xi, y = -1 + step * yi;
        const double r = std::sqrt(x * x + y * y);
        const double radial =
            portable::cos(2 * portable::kPi * kFrequency * portable::cos(portable::kPi * r / 2));
        const double value = (vertical + kAlpha * (1 + radial)) / (2 * (1 + kAlpha));
        *out++ = static_cast<uint8_t>(value * 255 + 0.5);
      }
    }
  });
  return values;
}

}  // namespace isosplat
