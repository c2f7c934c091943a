#include "shared/import/hdf5/records.h"

#include <fmt/format.h>

#include <bit>
#include <vector>

#include "shared/import/hdf5/checksums.h"

// B-trees of version 2.
//
// header  "BTHD", u8 0, u8 kind, u32 bytes of a node, u16 bytes of a record, u16 depth, u8, u8,
//         address of the root, u16 its records, length: all records, u32 checksum
// leaf    "BTLF", u8 0, u8 kind, records, u32 checksum
// others  "BTIN", u8 0, u8 kind, records, for each child (one more than records): its address, the
//         number of its records, of all below it (unless it is a leaf); u32 checksum
//
// Numbers of records take as many bytes as the largest possible one needs.
namespace isosplat::import {
namespace {

constexpr uint64_t kFrameBytes = 10;  // signature, version, kind, checksum
constexpr uint64_t kMaxDepth = 16;

uint64_t bytes_for(uint64_t largest) {
  return (static_cast<uint64_t>(std::bit_width(largest)) + 7) / 8;
}

/// The nodes of one depth; leaves have depth 0.
struct Depth {
  uint64_t most = 0;        ///< records of a node
  uint64_t most_below = 0;  ///< records of a node and all below it
};

class Tree {
 public:
  Tree(Hdf5File& file, Hdf5RecordKind kind, const Hdf5RecordVisitor& visit)
      : file_(file), kind_(static_cast<uint64_t>(kind)), visit_(visit) {}

  Result<void> visit(uint64_t address, uint64_t least_bytes) {
    const auto head = file_.read(address, 22 + file_.address_bytes() + file_.length_bytes());
    if (!head) return tl::unexpected(head.error());
    Hdf5Fields fields = file_.fields(*head);
    const bool is_tree = fields.text(4) == "BTHD" && fields.number(1) == 0 &&
                         fields.number(1) == kind_ && has_hdf5_checksum(file_, *head);
    if (!is_tree) return damaged(address);
    node_bytes_ = fields.number(4);
    record_bytes_ = fields.number(2);
    const uint64_t depth = fields.number(2);
    fields.skip(2);
    const uint64_t root = fields.address(), records = fields.number(2);
    if (record_bytes_ < least_bytes || node_bytes_ < kFrameBytes + record_bytes_ ||
        depth > kMaxDepth) {
      return damaged(address);
    }
    if (root == kHdf5Undefined) return {};
    depths_.push_back({(node_bytes_ - kFrameBytes) / record_bytes_, 0});
    depths_[0].most_below = depths_[0].most;
    for (uint64_t i = 1; i <= depth; ++i) {
      const uint64_t pointer = pointer_bytes(i);
      if (node_bytes_ < kFrameBytes + pointer) return damaged(address);
      Depth next;
      next.most = (node_bytes_ - kFrameBytes - pointer) / (record_bytes_ + pointer);
      if (__builtin_mul_overflow(next.most + 1, depths_.back().most_below, &next.most_below) ||
          __builtin_add_overflow(next.most_below, next.most, &next.most_below)) {
        return damaged(address);
      }
      depths_.push_back(next);
    }
    return visit_node(root, records, depth);
  }

 private:
  tl::unexpected<Error> damaged(uint64_t address) const {
    return file_.malformed(
        fmt::format("expected a B-tree of version 2 at {}, found none", address));
  }

  uint64_t count_bytes() const { return bytes_for(depths_[0].most); }
  /// The bytes of a number of records: all records below a child of a node of this depth.
  uint64_t total_bytes(uint64_t depth) const {
    return depth > 1 ? bytes_for(depths_[static_cast<size_t>(depth) - 1].most_below) : 0;
  }
  uint64_t pointer_bytes(uint64_t depth) const {
    return file_.address_bytes() + count_bytes() + total_bytes(depth);
  }

  Result<void> visit_node(uint64_t address, uint64_t records, uint64_t depth) {
    if (records > depths_[static_cast<size_t>(depth)].most) return damaged(address);
    const uint64_t pointers = depth > 0 ? (records + 1) * pointer_bytes(depth) : 0;
    const auto node = file_.read(address, kFrameBytes + records * record_bytes_ + pointers);
    if (!node) return tl::unexpected(node.error());
    Hdf5Fields fields = file_.fields(*node);
    const bool is_node = fields.text(4) == (depth > 0 ? "BTIN" : "BTLF") && fields.number(1) == 0 &&
                         fields.number(1) == kind_ && has_hdf5_checksum(file_, *node);
    if (!is_node) return damaged(address);
    Hdf5Fields children = fields;
    children.skip(records * record_bytes_);
    for (uint64_t i = 0; i <= records; ++i) {
      if (depth > 0) {
        const uint64_t child = children.address();
        const uint64_t count = children.number(count_bytes());
        children.skip(total_bytes(depth));
        if (auto visited = visit_node(child, count, depth - 1); !visited) return visited;
      }
      if (i == records) break;
      if (auto visited = visit_(fields.bytes(record_bytes_)); !visited) return visited;
    }
    return {};
  }

  Hdf5File& file_;
  uint64_t kind_;
  const Hdf5RecordVisitor& visit_;
  uint64_t node_bytes_ = 0, record_bytes_ = 0;
  std::vector<Depth> depths_;
};

}  // namespace

Result<void> visit_hdf5_records(Hdf5File& file, uint64_t address, Hdf5RecordKind kind,
                                uint64_t least_bytes, const Hdf5RecordVisitor& visit) {
  return Tree(file, kind, visit).visit(address, least_bytes);
}

bool has_hdf5_checksum(const Hdf5File& file, std::span<const std::byte> bytes) {
  if (bytes.size() < 4) return false;
  Hdf5Fields end = file.fields(bytes.last(4));
  return end.number(4) == hdf5_lookup3(bytes.first(bytes.size() - 4));
}

}  // namespace isosplat::import
