#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/hdf5_type.h"

namespace isosplat {

/// The numbers of an attribute. Nothing if there is no such attribute, it is no numbers, or more
/// than can be of use here.
std::optional<std::vector<double>> hdf5_numbers(const Hdf5File& file, const Hdf5Object& object,
                                                std::string_view name);

/// The texts of an attribute, without padding. Nothing as for numbers, or if they are damaged.
std::optional<std::vector<std::string>> hdf5_texts(Hdf5File& file, const Hdf5Object& object,
                                                   std::string_view name);

/// A number of these bytes.
double hdf5_number(const StoredVoxels& stored, std::span<const std::byte> bytes);

/// Whether the object has attributes that are not in its header, where they are not found.
bool hdf5_has_other_attributes(const Hdf5File& file, const Hdf5Object& object);

}  // namespace isosplat
