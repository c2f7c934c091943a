#pragma once

#include <cstdint>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/dicom/frames.h"

// Encapsulated pixels (PS3.5, A.4) are a sequence of items. The first item may be a table of the
// frames' offsets; the others are fragments of compressed frames.
//
//   | item: offset table | item: fragment | item: fragment | … | sequence delimiter |
namespace isosplat::import::dicom {

struct Fragment {
  uint64_t offset = 0;  ///< of the fragment's bytes, in the file
  uint32_t bytes = 0;
};

/// The fragments of each frame of an image. `allow_partial`: if the file ends before the last
/// fragment, returns the complete ones; frames without fragments are empty. Errors: truncated if
/// the file ends early, malformed_volume if the fragments cannot be assigned to frames.
Result<std::vector<std::vector<Fragment>>> find_fragments(ByteReader& file, const Image& image,
                                                          bool allow_partial = false);

}  // namespace isosplat::import::dicom
