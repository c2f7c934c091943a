#pragma once

#include <GLES3/gl3.h>

#include <cstdint>
#include <span>

#include "shared/core/base/status.h"
#include "shared/render/passes/mesh_vertex.h"

namespace isosplat::render {

/// An indexed triangle mesh in GPU buffers.
class TriangleMesh {
 public:
  TriangleMesh() = default;
  ~TriangleMesh() { release(); }
  TriangleMesh(const TriangleMesh&) = delete;
  TriangleMesh& operator=(const TriangleMesh&) = delete;

  /// Replaces the mesh; without triangles, only deletes it. The caller has collected earlier errors
  /// of GL (gl_errors.h). Errors: out_of_memory.
  Result<void> upload(std::span<const MeshVertex> vertices, std::span<const uint32_t> triangles);

  /// Draws it with the current program (attribute 0: position, 1: normal).
  void draw() const;

  bool is_empty() const { return indices_ == 0; }
  uint64_t bytes() const { return bytes_; }

  void release();
  /// The context that owned the objects is gone.
  void abandon();

 private:
  GLuint vertex_array_ = 0, buffers_[2] = {0, 0};
  GLsizei indices_ = 0;
  uint64_t bytes_ = 0;
};

}  // namespace isosplat::render
