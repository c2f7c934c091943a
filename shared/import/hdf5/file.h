#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

/// The address of objects that do not exist: all bits are set.
constexpr uint64_t kHdf5Undefined = ~uint64_t{0};

/// Reads the fields of a structure one after another. After the end, fields are 0 or empty, and
/// is_short() is true, so that one check after the last field is enough.
class Hdf5Fields {
 public:
  Hdf5Fields(std::span<const std::byte> bytes, size_t address_bytes, size_t length_bytes)
      : rest_(bytes), address_bytes_(address_bytes), length_bytes_(length_bytes) {}

  std::span<const std::byte> bytes(uint64_t count);
  std::string_view text(uint64_t count);
  void skip(uint64_t count) { bytes(count); }
  /// A whole number, little-endian, of 1 to 8 bytes.
  uint64_t number(uint64_t count);
  /// An address, or kHdf5Undefined.
  uint64_t address() { return defined(address_bytes_); }
  uint64_t length() { return number(length_bytes_); }
  /// A length, or kHdf5Undefined if all its bits are set.
  uint64_t unlimited_length() { return defined(length_bytes_); }

  size_t left() const { return rest_.size(); }
  bool is_short() const { return is_short_; }

 private:
  uint64_t defined(uint64_t count);

  std::span<const std::byte> rest_;
  size_t address_bytes_, length_bytes_;
  bool is_short_ = false;
};

/// An HDF5 file: its superblock, and reading of its structures ("HDF5 File Format Specification
/// Version 3.0"). Addresses count from its base, which follows a user block.
class Hdf5File {
 public:
  /// Errors: io_error, truncated, malformed_volume, unsupported_format.
  static Result<Hdf5File> open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  uint64_t root() const { return root_; }  ///< address of the root group's object header
  uint64_t base() const { return base_; }  ///< of address 0, in the file
  uint64_t bytes() const { return reader_->size_limit(); }
  size_t address_bytes() const { return address_bytes_; }
  size_t length_bytes() const { return length_bytes_; }

  /// Reads a structure of at most 256 MiB. All reads of a file together are limited to eight times
  /// its size plus 1 MiB. This ends the reading of a hostile file whose structures refer to each
  /// other in a cycle. Errors: truncated, io_error, malformed_volume.
  Result<std::vector<std::byte>> read(uint64_t address, uint64_t count);

  Hdf5Fields fields(std::span<const std::byte> bytes) const {
    return {bytes, address_bytes_, length_bytes_};
  }

  /// Reads stored bytes of an array, before filters. They do not count towards the limit of read().
  /// Errors: those of ByteReader::read.
  Result<void> read_data(uint64_t address, std::span<std::byte> out) {
    return reader_->read(base_ + address, out);
  }

  tl::unexpected<Error> malformed(const std::string& what) const;
  /// `found`: the unsupported part of the file, such as "an external link".
  tl::unexpected<Error> unsupported(const std::string& found) const;

 private:
  Result<void> read_superblock();

  std::filesystem::path path_;
  std::unique_ptr<ByteReader> reader_;
  uint64_t base_ = 0, root_ = 0, budget_ = 0;
  size_t address_bytes_ = 8, length_bytes_ = 8;
};

/// The offsets at which the superblock is searched. HDF5 allows each further doubling as well.
constexpr uint64_t kHdf5SuperblockPlaces[] = {0, 512, 1024, 2048};
constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1a\n";

}  // namespace isosplat::import
