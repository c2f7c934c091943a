#pragma once

#include <span>

#include "shared/core/unstructured/mesh.h"

namespace isosplat::import {

/// A mesh with points that its file does not have: the centres of faces and cells that are divided.
class MeshBuilder {
 public:
  UnstructuredMesh mesh;

  void add_cell(CellShape shape, std::span<const uint32_t> corners);

  /// Adds the point in the middle of nodes, and returns its index. Without `middles`: their mean.
  /// With `middles`, the nodes in the middle of edges, the value of the quadratic (serendipity)
  /// shape functions: −1/4 of each corner, and the rest evenly of the middles. The same positions
  /// in another order have the same point, to the last bit.
  uint32_t add_point(std::span<const uint32_t> corners, std::span<const uint32_t> middles);

  /// Sets the values of the points that were added, from those of their nodes.
  void set_values();

  /// Whether points were added.
  bool has_added() const { return !added_.empty(); }
  uint64_t memory_bytes() const;

  /// The bytes for an added point with so many nodes.
  static uint64_t point_bytes(uint64_t nodes);

 private:
  struct Added {
    uint32_t point = 0;
    uint32_t corners = 0,
             middles = 0;  ///< their numbers; their indices follow each other in nodes_
  };
  template <class T>
  T combined(const std::vector<T>& of, std::span<const uint32_t> nodes, size_t corners,
             T zero) const;

  std::vector<Added> added_;
  std::vector<uint32_t> nodes_;
};

}  // namespace isosplat::import
