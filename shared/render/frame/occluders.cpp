#include "shared/render/frame/occluders.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

constexpr float kFarthest = std::numeric_limits<float>::infinity();

Vec3f xyz(const std::array<float, 4>& v) {
  return {v[0], v[1], v[2]};
}

/// Half the extent of a box along a direction.
float reach(Vec3f along, Vec3f half) {
  return std::abs(along.x) * half.x + std::abs(along.y) * half.y + std::abs(along.z) * half.z;
}

}  // namespace

void Occluders::begin(const FrameBlock& frame) {
  frame_ = frame;
  columns_ = (static_cast<int>(frame.image_size[0]) + OCCLUDER_PX - 1) / OCCLUDER_PX;
  rows_ = (static_cast<int>(frame.image_size[1]) + OCCLUDER_PX - 1) / OCCLUDER_PX;
  distances_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_), kFarthest);
}

/// Conservative bounds, as half_extent_px in frame.glsl.
Occluders::Bounds Occluders::bounds(const Box& box) const {
  const Vec3f right = xyz(frame_.right), up = xyz(frame_.up), forward = xyz(frame_.forward);
  const float near_plane = frame_.near_plane, focal_px = frame_.focal_px;
  const float centre = dot(box.centre, forward);
  const float nearest = std::max(centre - reach(forward, box.half), near_plane);
  const float z = std::max(centre, near_plane);
  if (is_orthographic()) {
    return {frame_.image_middle[0] + focal_px * dot(box.centre, right),
            frame_.image_middle[1] + focal_px * dot(box.centre, up),
            reach(right, box.half) * focal_px,
            reach(up, box.half) * focal_px,
            centre,
            nearest};
  }
  const float across = dot(box.centre, right) / z, along = dot(box.centre, up) / z;
  const float px = focal_px / nearest;
  return {frame_.image_middle[0] + focal_px * across,
          frame_.image_middle[1] + focal_px * along,
          reach(right - forward * across, box.half) * px,
          reach(up - forward * along, box.half) * px,
          centre,
          nearest};
}

/// share: the fraction of a texel that must be covered at each edge.
Occluders::Texels Occluders::texels(float x, float y, float half_x, float half_y,
                                    float share) const {
  const auto texel = [](float px) { return px / float(OCCLUDER_PX); };
  const auto low = [&](float px) {
    return static_cast<int>(std::floor(std::clamp(texel(px) + share, -1.0f, 1e6f)));
  };
  const auto high = [&](float px) {
    return static_cast<int>(std::floor(std::clamp(texel(px) - share, -1.0f, 1e6f)));
  };
  return {std::max(low(x - half_x), 0), std::max(low(y - half_y), 0),
          std::min(high(x + half_x), columns_ - 1), std::min(high(y + half_y), rows_ - 1)};
}

void Occluders::add(const Box& box, float area) {
  const Bounds b = bounds(box);
  if (is_cut(b)) return;
  const float px = is_orthographic() ? frame_.focal_px : frame_.focal_px / b.distance;
  const float half = 0.5f * std::sqrt(area) * px;
  const Texels t = texels(b.x, b.y, std::min(half, b.half_x), std::min(half, b.half_y), 0.5f);
  for (int y = t.low_y; y <= t.high_y; ++y) {
    for (int x = t.low_x; x <= t.high_x; ++x) {
      float& distance = distances_[static_cast<size_t>(y * columns_ + x)];
      distance = std::min(distance, b.distance);
    }
  }
}

void Occluders::set_drawn(std::span<const float> depths) {
  const auto [offset, per_distance] = frame_.depth_terms;  // as distance_of in frame.glsl
  for (size_t i = 0; i < std::min(depths.size(), distances_.size()); ++i) {
    const float z = 2 * (depths[i] + 1e-6f) - 1 - offset;
    const float distance = is_orthographic() ? z / per_distance : per_distance / z;
    distances_[i] = depths[i] < 1 ? distance : kFarthest;
  }
}

bool Occluders::is_in_image(const Box& box, float margin_px) const {
  const Bounds b = bounds(box);
  if (is_cut(b)) return true;
  return b.x + b.half_x > -margin_px && b.x - b.half_x < frame_.image_size[0] + margin_px &&
         b.y + b.half_y > -margin_px && b.y - b.half_y < frame_.image_size[1] + margin_px;
}

bool Occluders::occlude(const Box& box) const {
  const Bounds b = bounds(box);
  if (is_cut(b)) return false;
  const Texels t = texels(b.x, b.y, b.half_x, b.half_y, 0);
  for (int y = t.low_y; y <= t.high_y; ++y) {
    for (int x = t.low_x; x <= t.high_x; ++x) {
      if (b.nearest <= distances_[static_cast<size_t>(y * columns_ + x)]) return false;
    }
  }
  return true;
}

}  // namespace isosplat::render
