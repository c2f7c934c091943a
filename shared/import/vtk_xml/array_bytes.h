#pragma once

#include <memory>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// Opens the values of an array as bytes: in the file's byte order, or in native order if they are
/// in text form. Compressed blocks are decompressed when they are read; one is kept in memory.
/// `bytes`: the number of bytes that the values must have. Requires a type. Errors: io_error,
/// truncated, malformed_volume if there are more or fewer bytes.
Result<std::unique_ptr<ByteReader>> open_vtk_xml_array(const VtkXmlFile& file,
                                                       const VtkXmlArray& array, uint64_t bytes);

}  // namespace isosplat::import
