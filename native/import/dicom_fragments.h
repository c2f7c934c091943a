#pragma once

#include <cstdint>
#include <vector>

#include "native/import/byte_reader.h"
#include "native/import/dicom_frames.h"

// Encapsulated pixels (PS3.5, A.4): a sequence of items, the first of which may be a table of where
// the frames begin, the others fragments of compressed frames.
//
//   | item: offset table | item: fragment | item: fragment | … | sequence delimiter |
namespace isosplat::dicom {

struct Fragment {
  uint64_t offset = 0;  ///< of the bytes, in the file
  uint32_t bytes = 0;
};

/// The fragments of each frame of an image. `partial`: a file that ends before the last of them
/// gives those that are whole; frames that have none are empty. Errors: truncated where the file
/// ends before, malformed_volume where the frames cannot be told apart.
Result<std::vector<std::vector<Fragment>>> find_fragments(ByteReader& file, const Image& image,
                                                          bool partial = false);

}  // namespace isosplat::dicom
