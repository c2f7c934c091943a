#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/import/hdf5/file.h"

namespace isosplat::import {

/// The kinds of messages that the reader uses.
enum class Hdf5Kind : uint16_t {
  dataspace = 0x01,
  link_info = 0x02,
  datatype = 0x03,
  old_fill_value = 0x04,
  fill_value = 0x05,
  link = 0x06,
  external_files = 0x07,
  layout = 0x08,
  filters = 0x0b,
  attribute = 0x0c,
  continuation = 0x10,
  symbol_table = 0x11,
  attribute_info = 0x15,
};

/// A message of an object header.
struct Hdf5Message {
  Hdf5Kind kind{};
  bool is_shared = false;  ///< its content refers to the message
  uint64_t address = 0;    ///< of its content
  std::vector<std::byte> content;
};

/// The object header of a group or a dataset.
struct Hdf5Object {
  std::vector<Hdf5Message> messages;
  bool has_other_attributes = false;  ///< that are not among the messages, and are not read

  /// The first message of a kind; null if there is none.
  const Hdf5Message* find(Hdf5Kind kind) const;
};

/// Errors: malformed_volume, truncated, io_error, unsupported_format.
Result<Hdf5Object> read_hdf5_object(Hdf5File& file, uint64_t address);

/// A hard link of a group.
struct Hdf5Link {
  std::string name;
  uint64_t address = 0;  ///< of an object header
};

/// The links of a group, in stored order; none if the object is not a group. Links to other files
/// and links by path are left out: the target of a path is listed at its own location. Errors:
/// those of read_hdf5_object.
Result<std::vector<Hdf5Link>> hdf5_links(Hdf5File& file, const Hdf5Object& group);

}  // namespace isosplat::import
