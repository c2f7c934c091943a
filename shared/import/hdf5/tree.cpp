#include "shared/import/hdf5/tree.h"

#include <fmt/format.h>

namespace isosplat::import {

Result<Hdf5TreeNode> read_hdf5_tree_node(Hdf5File& file, uint64_t address, Hdf5TreeKind kind,
                                         std::optional<uint64_t> level) {
  const uint64_t head_bytes = 8 + 2 * file.address_bytes();
  const auto head = file.read(address, head_bytes);
  if (!head) return tl::unexpected(head.error());
  Hdf5Fields fields = file.fields(*head);
  const bool is_node = fields.text(4) == "TREE" && fields.number(1) == static_cast<uint64_t>(kind);
  const uint64_t found = fields.number(1), count = fields.number(2);
  if (!is_node || found != level.value_or(found)) {
    return file.malformed(fmt::format("expected a node of {}'s tree at {}, found none",
                                      kind == Hdf5TreeKind::group ? "a group" : "an array",
                                      address));
  }
  return Hdf5TreeNode{found, count, address + head_bytes};
}

}  // namespace isosplat::import
