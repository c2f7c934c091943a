#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/import/hdf5/object.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import {

/// A type of elements, reduced to the parts that the reader uses.
struct Hdf5Type {
  enum class Kind : uint8_t { number, text, variable_text, reference_list, other };
  Kind kind = Kind::other;
  StoredVoxels stored;  ///< of numbers
  uint64_t bytes = 0;   ///< of an element in the file; 0 does not occur
  std::string name;     ///< of other types, for messages
};

/// Parses a datatype message. Unsupported types become `other`, with a name. Nothing if the message
/// is truncated.
std::optional<Hdf5Type> hdf5_type(Hdf5Fields fields);

/// The sizes along the axes of a dataspace, the slowest first; empty for a single element. Nothing
/// if the message is truncated, or describes no elements.
std::optional<std::vector<uint64_t>> hdf5_sizes(Hdf5Fields fields);

/// The maximum sizes of an array whose dataspace hdf5_sizes parses; kHdf5Undefined: no limit.
std::vector<uint64_t> hdf5_limits(Hdf5Fields fields);

/// The dataspace and the type of a dataset, as hdf5_sizes and hdf5_type parse them.
struct Hdf5Elements {
  std::optional<std::vector<uint64_t>> sizes;
  std::optional<Hdf5Type> type;
};
/// Errors: those of hdf5_message.
Result<Hdf5Elements> hdf5_elements(Hdf5File& file, const Hdf5Object& dataset);

/// The message of this kind. If it is shared (a named datatype), the message that it refers to.
/// Errors: malformed_volume, unsupported_format, those of read_hdf5_object.
Result<Hdf5Message> hdf5_message(Hdf5File& file, const Hdf5Object& object, Hdf5Kind kind);

}  // namespace isosplat::import
