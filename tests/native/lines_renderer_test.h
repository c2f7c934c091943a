#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/native/field_renderer_test.h"

// Where contour lines of a field should be, and which pixels they change.
namespace isosplat::render {

class LinesGpu : public FieldRendererTest {
 protected:
  using Number = double (*)(double value, double interval);
  static double linear(double value, double interval) { return value / interval; }
  static double decades(double value, double interval) { return std::log10(value) / interval; }

  /// Where lines should be: the number of lines below the value at each pixel, of pictures with the
  /// first row below. NaN where no surface or no value is.
  std::vector<double> expected(Number number) {
    RenderSettings exact = settings_;
    exact.kind = SplatKind::exact;
    exact.field_lines = 0;
    draw_and_keep(exact, camera_, kSize, "lines-positions");
    const auto all = pixels();
    std::vector<double> numbers(all.size(), std::numeric_limits<double>::quiet_NaN());
    for (size_t i = 0; i < all.size(); ++i) {
      if (!all[i].hit || all[i].field != Field::value) continue;
      const double value = mapping_.value(field_at(voxel_at(i, double(all[i].depth))));
      numbers[i] = number(value, settings_.field_lines);
    }
    return numbers;
  }

  /// The change of each pixel by the lines, from −1 (darker) to 1: of the channel that changes
  /// most, relative to the larger value, or to 30 of 255.
  std::vector<double> signed_change(const std::string& name, bool still = false) {
    RenderSettings plain = settings_;
    plain.field_lines = 0;
    const Image without = draw_and_keep(plain, camera_, kSize, "lines-without", still);
    const Image with = draw(name, still);
    std::vector<double> change(size_t{kSize} * kSize);
    for (size_t i = 0; i < change.size(); ++i) {
      const size_t at = 4 * ((kSize - 1 - i / kSize) * kSize + i % kSize);
      for (size_t c = 0; c < 3; ++c) {
        const double a = with.rgba[at + c], b = without.rgba[at + c];
        const double here = (a - b) / std::max({a, b, 30.0});
        if (std::abs(here) > std::abs(change[i])) change[i] = here;
      }
    }
    return change;
  }

  /// The same without the sign.
  std::vector<double> drawn(const std::string& name, bool still = false) {
    auto change = signed_change(name, still);
    for (double& each : change) each = std::abs(each);
    return change;
  }

  struct Comparison {
    int lines = 0;       ///< pairs of neighbours with a line between them
    int unmarked = 0;    ///< of these: neither pixel has changed
    int marked = 0;      ///< pixels that have changed strongly
    int false_ones = 0;  ///< of these: without a line nearby
  };

  /// Where lines are at least 6 px from each other, and at least 2 px from an outline.
  static Comparison compare_lines(const std::vector<double>& numbers,
                                  const std::vector<double>& change, int reach = 1,
                                  double strong = 0.35) {
    Comparison c;
    for (int y = 3; y < kSize - 3; ++y) {
      for (int x = 3; x < kSize - 3; ++x) {
        const auto at = [&](int right, int up) { return size_t((y + up) * kSize + x + right); };
        double least = numbers[at(0, 0)], most = least, widest = 0;
        bool is_whole = true, is_near = false;
        for (int up = -2; up <= 2; ++up) {
          for (int right = -2; right <= 2; ++right) {
            const double here = numbers[at(right, up)];
            is_whole = is_whole && !std::isnan(here);
            if (std::isnan(here)) continue;
            least = std::min(least, here);
            most = std::max(most, here);
          }
        }
        widest = (most - least) / 4;
        if (!is_whole || widest > 1.0 / 6) continue;
        const auto line_of = [&](int right, int up) { return std::floor(numbers[at(right, up)]); };
        for (int up = -reach; up <= reach; ++up) {
          for (int right = -reach; right <= reach; ++right) {
            is_near = is_near || line_of(right, up) != line_of(0, 0);
          }
        }
        if (change[at(0, 0)] > strong) {
          ++c.marked;
          c.false_ones += !is_near;
        }
        for (const auto& [right, up] : {std::pair{1, 0}, std::pair{0, 1}}) {
          if (line_of(0, 0) == line_of(right, up)) continue;
          ++c.lines;
          c.unmarked += std::max(change[at(0, 0)], change[at(right, up)]) < 0.3;
        }
      }
    }
    return c;
  }

  /// The number of pixels that have changed by more than rounding: with lines, the position has 12
  /// instead of 16 bits.
  static int count_changed(const std::vector<double>& change) {
    return static_cast<int>(
        std::count_if(change.begin(), change.end(), [](double each) { return each > 0.06; }));
  }

  struct Beside {
    int near = 0, far = 0;  ///< pixels that have changed: beside a line, and elsewhere
  };

  /// For lines of any distance from each other.
  static Beside beside_lines(const std::vector<double>& numbers,
                             const std::vector<double>& change) {
    Beside c;
    for (int y = 2; y < kSize - 2; ++y) {
      for (int x = 2; x < kSize - 2; ++x) {
        if (!(change[size_t(y * kSize + x)] > 0.1)) continue;
        double least = 1e300, highest = -1e300;
        for (int up = -2; up <= 2; ++up) {
          for (int right = -2; right <= 2; ++right) {
            const double line = std::floor(numbers[size_t((y + up) * kSize + x + right)]);
            least = std::min(least, line);
            highest = std::max(highest, line);
          }
        }
        ++(least < highest ? c.near : c.far);
      }
    }
    return c;
  }
};

}  // namespace isosplat::render
