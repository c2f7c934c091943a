#pragma once

#include <pybind11/pybind11.h>

#include <span>
#include <vector>

#include "native/python/exceptions.h"
#include "shared/import/bytes/byte_reader.h"

namespace isosplat::python {

/// The bytes of an array in memory. Borrows them.
class MemoryReader : public import::ByteReader {
 public:
  explicit MemoryReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override;
  uint64_t size_limit() const override { return bytes_.size(); }
  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override;
  uint64_t available_bytes() override { return bytes_.size(); }
  bool is_random_access() const override { return true; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  std::span<const std::byte> bytes_;
};

/// How a Python function returns the slices of an array.
struct Slices {
  uint64_t count = 0;
  uint64_t bytes = 0;       ///< of one slice
  uint64_t read_count = 1;  ///< slices that are read together, from a multiple of this number on
};

/// The bytes of an array that a Python function reads slice by slice: read(first, count) returns an
/// object with the buffer protocol, whose bytes are those of slices [first, first + count). Keeps
/// the slices of the last call. Takes the GIL for each call. An exception of the function ends the
/// work through the Interruption.
class SliceReader : public import::ByteReader {
 public:
  /// Borrows the function and the interruption.
  SliceReader(const pybind11::object& read, const Slices& slices, Interruption& interruption)
      : read_(read), slices_(slices), interruption_(interruption) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override;
  uint64_t size_limit() const override { return slices_.count * slices_.bytes; }
  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override;
  uint64_t available_bytes() override { return size_limit(); }
  uint64_t resident_bytes() const override { return slices_.read_count * slices_.bytes; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  Result<void> load(uint64_t first);
  void call(uint64_t first, uint64_t count);

  const pybind11::object& read_;
  Slices slices_;
  Interruption& interruption_;
  std::vector<std::byte> bytes_;  ///< of the slices from first_ on
  uint64_t first_ = 0;
};

}  // namespace isosplat::python
