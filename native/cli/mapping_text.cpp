#include "native/cli/mapping_text.h"

#include <fmt/format.h>

#include "native/cli/terminal.h"

namespace isosplat::cli {

using Json = nlohmann::ordered_json;

Json mapping_json(const ValueMapping& mapping) {
  return {{"offset", mapping.offset},
          {"scale", mapping.scale},
          {"maxError", mapping.max_error},
          {"bits", mapping.bits}};
}

std::string exactness(const ValueMapping& mapping) {
  const std::string quantized_values =
      fmt::format("{} bits, steps of {:.6g}", mapping.bits, mapping.scale);
  if (mapping.max_error == 0) return "lossless (" + quantized_values + ")";
  return fmt::format("values are within ±{:.3g} ({})", mapping.max_error, quantized_values);
}

std::string describe(const FieldInfo& field) {
  const ValueMapping& mapping = field.mapping;
  return fmt::format("{}: {:.8g} to {:.8g}, {}{}", field.name, mapping.value(field.range.min),
                     mapping.value(field.range.max), exactness(mapping),
                     field.missing_voxels == 0
                         ? ""
                         : ", " + with_commas(field.missing_voxels) + " voxels without a value");
}

Json fields_json(const StoreInfo& info) {
  Json fields = Json::array();
  for (const auto& [field, offset, bytes] : info.fields) {
    fields.push_back(
        {{"name", field.name},
         {"range", {field.mapping.value(field.range.min), field.mapping.value(field.range.max)}},
         {"mapping", mapping_json(field.mapping)},
         {"nonFinite", field.missing_voxels},
         {"bytes", bytes}});
  }
  return fields;
}

}  // namespace isosplat::cli
