#pragma once

#include <span>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/render/frame/frame.h"

namespace isosplat::render {

/// A coarse depth image (one texel per OCCLUDER_PX² px) of boxes that contain parts of a surface.
/// It is drawn on the CPU. Boxes behind it are likely to be occluded. Its answers can be wrong in
/// both directions, so they only determine the order of drawing.
class Occluders {
 public:
  /// An axis-parallel box in frame space.
  struct Box {
    Vec3f centre, half;
  };

  /// Clears the image.
  void begin(const FrameBlock& frame);

  /// Adds a part of a surface in the box, at the depth of the box's centre. It covers a square of
  /// this area (frame units²) that faces the eye, but not more than the box covers.
  void add(const Box& box, float area);

  /// Replaces the image by the farthest depths that the GPU has drawn in each texel, from the
  /// bottom row on. occlude() is then true only for boxes that are occluded.
  void set_drawn(std::span<const float> depths);

  /// Whether the box is in the image, or within `margin_px` of it.
  bool is_in_image(const Box& box, float margin_px) const;
  /// Whether the whole box is behind the image's depths. Parts outside of the image count as
  /// occluded.
  bool occlude(const Box& box) const;

 private:
  /// Bounds in the image in px, and distances along the view.
  struct Bounds {
    float x, y, half_x, half_y, distance, nearest;
  };
  /// The closed interval [low, high] of texels; empty if low > high.
  struct Texels {
    int low_x, low_y, high_x, high_y;
  };
  Bounds bounds(const Box& box) const;
  bool is_orthographic() const { return frame_.orthographic != 0; }
  /// Whether the near plane cuts the box. The bounds of such a box are meaningless.
  bool is_cut(const Bounds& b) const {
    return !is_orthographic() && b.nearest <= frame_.near_plane;
  }
  Texels texels(float x, float y, float half_x, float half_y, float share) const;

  FrameBlock frame_{};
  int columns_ = 0, rows_ = 0;
  std::vector<float> distances_;  // along the view
};

}  // namespace isosplat::render
