#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/conformance/sample.h"

namespace isosplat::conformance {

/// An object of an HDF5 file: a group, or a dataset if it has sizes.
struct Hdf5Node {
  struct Attribute {
    std::string name;
    std::string type;             ///< a datatype message
    std::vector<uint64_t> sizes;  ///< none: a single value
    std::string values;
    std::vector<const Hdf5Node*> references;  ///< instead of values: a list of one object each
  };

  std::string name;
  std::vector<std::unique_ptr<Hdf5Node>> children;
  std::vector<Attribute> attributes;

  std::vector<uint64_t> sizes;  ///< of a dataset, the slowest axis first
  std::string type, values;
  uint64_t element_bytes = 0;
  std::vector<uint64_t> chunk;  ///< none: contiguous
  bool is_compressed = false;   ///< its chunks

  /// The child with this name, which is added if it is new. "a/b": of the child a.
  Hdf5Node& at(const std::string& path);
  void set_numbers(const std::string& attribute, Number kind, const std::vector<double>& numbers,
                   bool is_single = false);
  void set_text(const std::string& attribute, const std::string& text);
  void set_references(const std::string& attribute, std::vector<const Hdf5Node*> objects);
  /// Makes it a dataset.
  void set_array(Number kind, std::vector<uint64_t> shape, const std::vector<double>& numbers,
                 bool big_endian = false);

  mutable uint64_t address = 0;  ///< of its header, in the file
};

/// The bytes of a file whose root group this is.
std::string hdf5_bytes(const Hdf5Node& root);

}  // namespace isosplat::conformance
