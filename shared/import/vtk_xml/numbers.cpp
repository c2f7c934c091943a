#include "shared/import/vtk_xml/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "shared/import/voxels/stored_voxels.h"
#include "shared/import/vtk_xml/array_bytes.h"

namespace isosplat::import {
namespace {

constexpr uint64_t kNumbersAtOnce = 8192;

}  // namespace

Result<void> visit_vtk_xml_numbers(const VtkXmlFile& file, const VtkXmlArray& array, uint64_t count,
                                   const std::function<bool(double)>& visit) {
  if (!array.type) {
    return malformed_vtk_xml(file.path, fmt::format("expected numbers in the array '{}', found the "
                                                    "type '{}'",
                                                    array.name, array.type_name));
  }
  if (count == 0) return {};
  StoredVoxels stored;
  stored.type = *array.type;
  stored.big_endian = array.format == VtkXmlArray::Format::ascii
                          ? std::endian::native == std::endian::big
                          : file.big_endian;
  const size_t size = voxel_bytes(stored.type);
  auto reader = open_vtk_xml_array(file, array, count * size);
  if (!reader) return tl::unexpected(reader.error());
  std::vector<std::byte> bytes;
  for (uint64_t first = 0; first < count; first += kNumbersAtOnce) {
    const auto some = static_cast<size_t>(std::min(kNumbersAtOnce, count - first));
    bytes.resize(some * size);
    if (auto read = (*reader)->read(first * size, bytes); !read) return read;
    to_native_order(stored, bytes);
    bool goes_on = true;
    with_voxel_type(stored.type, [&]<class T>(T) {
      for (size_t i = 0; i < some && goes_on; ++i) {
        T value;
        std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
        goes_on = visit(static_cast<double>(value));
      }
    });
    if (!goes_on) return {};
  }
  return {};
}

Result<std::vector<double>> read_vtk_xml_numbers(const VtkXmlFile& file, const VtkXmlArray& array,
                                                 uint64_t count) {
  std::vector<double> numbers;
  const auto read = visit_vtk_xml_numbers(file, array, count, [&](double number) {
    if (numbers.empty()) numbers.reserve(static_cast<size_t>(count));
    numbers.push_back(number);
    return true;
  });
  if (!read) return tl::unexpected(read.error());
  return numbers;
}

}  // namespace isosplat::import
