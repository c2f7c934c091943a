#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/import/dicom/stacks.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/segment_map.h"

// All segments of a segmentation at once (PS3.3, A.51 and C.8.20). They may overlap, so they become
// one or several volumes of labels.
namespace isosplat::import::dicom {

/// The segments of a stack whose frames have one segment each. Each file, or concatenation of
/// files, has its own slices. A pixel of a fractional segmentation is inside from half of the
/// Maximum Fractional Value on. Reads all pixels once, to find the segments that overlap. Errors:
/// those of open_dicom_segments.
Result<std::vector<SegmentMap>> map_segments(const Collection& collection, const Stack& stack,
                                             const std::filesystem::path& path,
                                             const ImportOptions& options,
                                             std::vector<std::string> notes);

/// The segments of a label map, without its volume. Errors: invalid_argument if the options choose
/// a segment that does not exist.
Result<SegmentMap> describe_label_map(const Collection& collection, const Stack& stack,
                                      const std::filesystem::path& path,
                                      const ImportOptions& options);

}  // namespace isosplat::import::dicom
