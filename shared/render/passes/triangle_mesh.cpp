#include "shared/render/passes/triangle_mesh.h"

namespace isosplat::render {

Result<void> TriangleMesh::upload(std::span<const MeshVertex> vertices,
                                  std::span<const uint32_t> triangles) {
  release();
  if (triangles.empty()) return {};
  glGenVertexArrays(1, &vertex_array_);
  glGenBuffers(2, buffers_);
  glBindVertexArray(vertex_array_);
  glBindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(),
               GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(MeshVertex), nullptr);
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(MeshVertex),
                        reinterpret_cast<const void*>(sizeof(Vec3f)));
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[1]);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles.size_bytes()),
               triangles.data(), GL_STATIC_DRAW);
  glBindVertexArray(0);
  if (glGetError() != GL_NO_ERROR) {
    return fail(Status::out_of_memory, "the GPU has no room for the mesh");
  }
  indices_ = static_cast<GLsizei>(triangles.size());
  bytes_ = vertices.size_bytes() + triangles.size_bytes();
  return {};
}

void TriangleMesh::draw() const {
  glBindVertexArray(vertex_array_);
  glDrawElements(GL_TRIANGLES, indices_, GL_UNSIGNED_INT, nullptr);
}

void TriangleMesh::release() {
  if (vertex_array_) {
    glDeleteVertexArrays(1, &vertex_array_);
    glDeleteBuffers(2, buffers_);
  }
  abandon();
}

void TriangleMesh::abandon() {
  vertex_array_ = buffers_[0] = buffers_[1] = 0;
  indices_ = 0;
  bytes_ = 0;
}

}  // namespace isosplat::render
