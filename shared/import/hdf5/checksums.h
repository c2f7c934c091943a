#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace isosplat::import {

/// The checksum of HDF5's structures: hashlittle of Bob Jenkins's lookup3.c, beginning with 0.
uint32_t hdf5_lookup3(std::span<const std::byte> bytes);

/// The checksum of HDF5's filter Fletcher32: sums of big-endian 16-bit words.
uint32_t hdf5_fletcher32(std::span<const std::byte> bytes);

}  // namespace isosplat::import
