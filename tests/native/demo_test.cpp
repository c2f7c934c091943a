#include <gtest/gtest.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "native/demo/demo_volumes.h"
#include "shared/core/base/portable_math.h"

namespace isosplat {
namespace {

uint64_t hash(const DemoVolume& volume) {
  return XXH3_64bits(volume.values.data(), volume.values.size());
}

TEST(Demo, VolumesAreTheSameBytesOnEveryMachineAndForAnyThreadCount) {
  const std::pair<std::string_view, uint64_t> expected[] = {
      {"bucky", 18380089432311274616u},
      {"marschner_lobb", 10612221151844886987u},
      {"mandelbulb", 13994651483248495282u}};
  ASSERT_EQ(demo_names().size(), std::size(expected));
  for (const auto& [name, checksum] : expected) {
    const auto one = make_demo(name, 1);
    ASSERT_TRUE(one) << one.error().message;
    EXPECT_EQ(hash(*one), checksum) << name;
    EXPECT_EQ(make_demo(name, 3)->values, one->values) << name;
  }
}

TEST(Demo, BuckyBallPeaksAtItsSixtyAtoms) {
  const int32_t n = 128;
  const auto values = bucky_ball(n, 2);
  int peaks = 0;
  for (int32_t z = 1; z < n - 1; ++z) {
    for (int32_t y = 1; y < n - 1; ++y) {
      for (int32_t x = 1; x < n - 1; ++x) {
        const auto at = [&](int dx, int dy, int dz) {
          return values[static_cast<size_t>(((z + dz) * n + y + dy) * n + x + dx)];
        };
        bool peak = at(0, 0, 0) > 200;
        for (int i = 0; peak && i < 27; ++i) {
          const int dx = i % 3 - 1, dy = i / 3 % 3 - 1, dz = i / 9 - 1;
          const int order = dx + 3 * dy + 9 * dz;  // of equal neighbours, the first is the peak
          if (order < 0 && at(dx, dy, dz) >= at(0, 0, 0)) peak = false;
          if (order > 0 && at(dx, dy, dz) > at(0, 0, 0)) peak = false;
        }
        peaks += peak;
      }
    }
  }
  EXPECT_EQ(peaks, 60);
}

TEST(Demo, MarschnerLobbFollowsItsFormula) {
  const int32_t n = 41;
  const auto values = marschner_lobb(n, 1);
  for (int32_t z = 0; z < n; z += 5) {
    for (int32_t y = 0; y < n; y += 3) {
      for (int32_t x = 0; x < n; ++x) {
        const double px = -1 + x * 0.05, py = -1 + y * 0.05, pz = -1 + z * 0.05;
        const double pi = portable::kPi;
        const double rho = std::cos(12 * pi * std::cos(pi * std::hypot(px, py) / 2));
        const double value = (1 - std::sin(pi * pz / 2) + 0.25 * (1 + rho)) / 2.5;
        EXPECT_NEAR(values[static_cast<size_t>((z * n + y) * n + x)], 255 * value, 0.501);
      }
    }
  }
}

TEST(Demo, PortableMathAgreesWithTheLibrary) {
  for (double x = -30; x < 30; x += 0.137) {
    EXPECT_NEAR(portable::exp(x) / std::exp(x), 1, 1e-12);
    EXPECT_NEAR(portable::sin(x), std::sin(x), 1e-12);
    EXPECT_NEAR(portable::cos(x), std::cos(x), 1e-12);
    EXPECT_NEAR(portable::log(std::exp(x)), x, 1e-12);
    EXPECT_NEAR(portable::log2(std::exp2(x)), x, 1e-12);
    EXPECT_NEAR(portable::pow(1.7, x) / std::pow(1.7, x), 1, 1e-12);
  }
}

TEST(Demo, AnUnknownNameIsRefusedWithAListOfAllNames) {
  const auto volume = make_demo("teapot", 1);
  ASSERT_FALSE(volume);
  EXPECT_EQ(volume.error().status, Status::not_found);
  EXPECT_NE(volume.error().message.find("bucky, marschner_lobb, mandelbulb"), std::string::npos);
}

}  // namespace
}  // namespace isosplat
