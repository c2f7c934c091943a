#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// A box of the volume's voxels, and the array that has their values. Indices are from the volume's
/// first voxel; boxes have their first index and the one after the last.
struct VtkXmlPart {
  size_t file = 0;  ///< index of the array's file
  VtkXmlArray array;
  std::array<int64_t, 3> low{}, high{};           ///< the box that is read from it
  std::array<int64_t, 3> stored_low{}, stored{};  ///< the first voxel of the array, and its sizes
};

/// The bytes of a part's array.
uint64_t vtk_xml_part_bytes(const VtkXmlPart& part);

/// Opens a volume that consists of parts, as one array with all components of a voxel together. If
/// parts overlap, the first one is read. Keeps at most 32 of them open. `sizes`: of the volume.
/// Errors: those of open_vtk_xml_array for each part; malformed_volume if the parts have fewer
/// voxels than the volume. On reading, malformed_volume for a voxel that no part has.
Result<std::unique_ptr<ByteReader>> open_vtk_xml_parts(std::vector<VtkXmlFile> files,
                                                       std::vector<VtkXmlPart> parts,
                                                       Vec3<int64_t> sizes);

}  // namespace isosplat::import
