#pragma once

#include <GLES3/gl3.h>

#include <array>
#include <cstdint>

#include "shared/core/mesh/cell_edges.h"
#include "shared/render/frame/draw_list.h"
#include "shared/render/settings/render_settings.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {

/// The vertices of a cell in a strip of triangles: cut edges, or kNoVertex for vertices of the
/// strip that are not of this cell.
inline constexpr CellEdge kNoVertex = 15;
using TriangleSlots = std::array<CellEdge, TRIANGLE_SLOTS>;

/// The part of a strip of triangles that draws the surface in a cell: each of its loops
/// (cell_loops) as a polygon. Triangles between polygons, and between this cell and others in the
/// strip, have two equal vertices. Front faces are on the side of lower values, if the strip's part
/// begins at an even vertex. joined: as in cell_loops.
TriangleSlots triangle_slots(CornerSigns signs, uint32_t joined);

/// Whether the squares of these samples are drawn as triangles. These show the surface onto which
/// samples are projected, and no errors of the projection.
bool is_drawn_as_triangles(const DrawItem& item, const RenderSettings& settings);

/// A texture with the slots of all cases: x: joined, y: signs; 4 bits per slot, the first ones
/// lowest, eight slots per channel.
class TriangleCases {
 public:
  TriangleCases() = default;
  ~TriangleCases() { release(); }
  TriangleCases(const TriangleCases&) = delete;
  TriangleCases& operator=(const TriangleCases&) = delete;

  /// Makes the texture on the first call, and binds it to a unit.
  void bind(GLenum unit);

  uint64_t bytes() const;

  void release();
  /// The context that owned the texture is gone.
  void abandon() { texture_ = 0; }

 private:
  GLuint texture_ = 0;
};

}  // namespace isosplat::render
