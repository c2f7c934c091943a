#include "shared/render/passes/triangle_cases.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "shared/core/mesh/cell_loops.h"

namespace isosplat::render {
namespace {

constexpr int kJoined = 64, kSigns = 256, kChannels = 4;

/// Squared distance of the middles of two edges, in half cells.
int distance(CellEdge a, CellEdge b) {
  const auto middle = [](int edge, int axis) {
    return axis == axis_of(edge) ? 1 : 2 * (low_corner(edge) >> axis & 1);
  };
  int sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int d = middle(a, axis) - middle(b, axis);
    sum += d * d;
  }
  return sum;
}

/// The vertices of a polygon as those of a strip, from the given one on: alternately from both
/// sides. `mirrored`: the strip begins at an odd vertex, where triangles have the other
/// orientation.
CellLoop strip_of(const CellLoop& loop, size_t first, bool mirrored) {
  const size_t n = loop.size();
  CellLoop strip{loop[first]};
  for (size_t step = 1; strip.size() < n; ++step) {
    size_t one = (first + step) % n, other = (first + n - step) % n;
    if (mirrored) std::swap(one, other);
    strip.push_back(loop[one]);
    if (strip.size() < n) strip.push_back(loop[other]);
  }
  return strip;
}

/// The strip with the shortest inner edges.
CellLoop best_strip(const CellLoop& loop, bool mirrored) {
  CellLoop best;
  int least = 0;
  for (size_t first = 0; first < loop.size(); ++first) {
    CellLoop strip = strip_of(loop, first, mirrored);
    int length = 0;
    for (size_t i = 1; i + 2 < strip.size(); ++i) length += distance(strip[i], strip[i + 1]);
    if (!best.empty() && length >= least) continue;
    least = length;
    best = std::move(strip);
  }
  return best;
}

}  // namespace

TriangleSlots triangle_slots(CornerSigns signs, uint32_t joined) {
  TriangleSlots slots;
  slots.fill(kNoVertex);
  size_t size = 0;
  for (const CellLoop& loop : cell_loops(signs, joined)) {
    // Its first and last vertex twice: triangles that join polygons then have two equal vertices.
    if (size + loop.size() + 2 > slots.size()) break;
    const CellLoop strip = best_strip(loop, (size + 1) % 2 == 1);
    slots[size++] = strip.front();
    for (const CellEdge edge : strip) slots[size++] = edge;
    slots[size++] = strip.back();
  }
  // A single vertex elsewhere would be one of a triangle with the next cell.
  if (size > 0 && size + 1 == slots.size()) slots[size] = slots[size - 1];
  return slots;
}

bool is_drawn_as_triangles(const DrawItem& item, const RenderSettings& settings) {
  return item.chunk->block.level == 0 && item.largest_side_px > float(TRIANGLE_SIDE_PX) &&
         settings.projected && settings.displaced == Displaced::clamp &&
         settings.splat_scale >= 1 && settings.colour_by != ColourBy::projection_error;
}

void TriangleCases::bind(GLenum unit) {
  glActiveTexture(unit);
  if (texture_) {
    glBindTexture(GL_TEXTURE_2D, texture_);
    return;
  }
  std::vector<uint32_t> texels(size_t{kSigns} * kJoined * kChannels);
  for (int signs = 0; signs < kSigns; ++signs) {
    const auto corners = static_cast<CornerSigns>(signs);
    const uint32_t ambiguous = ambiguous_faces(corners);
    for (uint32_t joined = 0; joined < kJoined; ++joined) {
      uint32_t* texel = &texels[(size_t(signs) * kJoined + joined) * kChannels];
      if (const uint32_t same = joined & ambiguous; same != joined) {
        std::copy_n(&texels[(size_t(signs) * kJoined + same) * kChannels], kChannels, texel);
        continue;
      }
      const TriangleSlots slots = triangle_slots(corners, joined);
      for (size_t i = 0; i < slots.size(); ++i) texel[i / 8] |= uint32_t{slots[i]} << 4 * (i % 8);
    }
  }
  glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32UI, kJoined, kSigns);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kJoined, kSigns, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                  texels.data());
}

uint64_t TriangleCases::bytes() const {
  return texture_ ? uint64_t{kSigns} * kJoined * kChannels * sizeof(uint32_t) : 0;
}

void TriangleCases::release() {
  if (texture_) glDeleteTextures(1, &texture_);
  abandon();
}

}  // namespace isosplat::render
