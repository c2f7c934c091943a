#pragma once

#include <vector>

#include "shared/base/vec3.h"
#include "shared/render/frame.h"

namespace isosplat {

/// A coarse depth image (one texel per OCCLUDER_PX² px), drawn on the CPU, of boxes that hold
/// pieces of a surface: what lies behind it is likely to be hidden. It errs in both directions, so
/// it only decides what to draw first.
class Occluders {
 public:
  /// An axis-parallel box in frame space.
  struct Box {
    Vec3f centre, half;
  };

  /// Clears the image: nothing hides anything.
  void begin(const FrameBlock& frame);

  /// A piece of a surface in the box hides what lies behind the box's centre: as much as this area
  /// does when seen from its front, and no more than the box.
  void add(const Box& box, float area);

  /// Whether the box is in the image, or within `margin_px` of it.
  bool is_in_image(const Box& box, float margin_px) const;
  /// Whether all of the box lies behind what was added. What is beside the image counts as hidden.
  bool hide(const Box& box) const;

 private:
  /// Bounds on the image in px, and distances along the view.
  struct Bounds {
    float x, y, half_x, half_y, distance, nearest;
  };
  /// From low up to and with high; none where low > high.
  struct Texels {
    int low_x, low_y, high_x, high_y;
  };
  Bounds bounds(const Box& box) const;
  Texels texels(float x, float y, float half_x, float half_y, float share) const;

  FrameBlock frame_{};
  int columns_ = 0, rows_ = 0;
  std::vector<float> distances_;  // along the view
};

}  // namespace isosplat
