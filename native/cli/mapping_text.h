#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "shared/core/store/store_reader.h"

// How isosplat info describes mappings to quantized values, and fields.
namespace isosplat::cli {

nlohmann::ordered_json mapping_json(const ValueMapping& mapping);

/// The error of the stored values.
std::string exactness(const ValueMapping& mapping);

/// Name, range, error and missing voxels of a field.
std::string describe(const FieldInfo& field);

/// An array with an object for each field of a store.
nlohmann::ordered_json fields_json(const StoreInfo& info);

}  // namespace isosplat::cli
