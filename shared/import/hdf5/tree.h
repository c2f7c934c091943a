#pragma once

#include <cstdint>
#include <optional>

#include "shared/import/hdf5/file.h"

namespace isosplat::import {

/// The beginning of a node of a B-tree of version 1, before its entries: "TREE", u8 kind, u8 level,
/// u16 entries, addresses of its siblings.
struct Hdf5TreeNode {
  uint64_t level = 0;  ///< 0: its entries are not nodes
  uint64_t count = 0;
  uint64_t entries = 0;  ///< address of the first entry
};

enum class Hdf5TreeKind : uint8_t { group, array };

/// `level`: the required level of the node; any level for the root. Errors: those of
/// Hdf5File::read.
Result<Hdf5TreeNode> read_hdf5_tree_node(Hdf5File& file, uint64_t address, Hdf5TreeKind kind,
                                         std::optional<uint64_t> level);

}  // namespace isosplat::import
