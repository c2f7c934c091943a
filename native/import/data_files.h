#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "native/import/allowances.h"
#include "native/import/byte_reader.h"

namespace isosplat {

/// The data files that a detached header names together, as NRRD's "data file" and MetaImage's
/// "ElementDataFile" do: `value` is "LIST …", and each line after the header's is a file, or a
/// pattern with one %d and first, last and step, as "slice%03d.raw 1 20 1". Relative names are
/// those of the header's folder. At most a million; a file need not exist. Empty for a pattern that
/// is neither.
std::vector<std::filesystem::path> named_data_files(const std::filesystem::path& header,
                                                    std::string_view value);

/// Whether so many files can share an array with these sizes (fastest first) evenly: each has all
/// samples of some axes, and there is one for each sample of the others.
bool divides_axes(size_t files, std::span<const int64_t> sizes);

/// A range of bytes without data.
struct ByteRange {
  uint64_t begin = 0, end = 0;
};

/// How the data of a volume is spread over files.
struct DataFiles {
  std::vector<std::filesystem::path> paths;
  uint64_t bytes_each = 0;  ///< of voxels in each file
  size_t voxel_bytes = 1;   ///< of one voxel: of a cut one, nothing is used
  int64_t skip = 0;         ///< bytes before them in each file; −1: they are at the file's end
  bool deflated = false;    ///< each file is compressed on its own
};

/// What open_data_files opened.
struct JoinedFiles {
  std::unique_ptr<ByteReader> reader;  ///< the voxels of all files, one after the other
  std::vector<ByteRange> missing;      ///< of files that are absent or short; read as zeros
  std::vector<std::string> notes;
};

/// Opens the data files of one volume as one. Each must be there (unless gaps are allowed), and
/// hold exactly its voxels (unless truncated, or surplus, is allowed); at least one must be there.
/// Holds one open file at a time. `header`: for messages. Errors: io_error for missing files,
/// truncated, malformed_volume.
Result<JoinedFiles> open_data_files(const std::filesystem::path& header, DataFiles files,
                                    Allowances allowed);

}  // namespace isosplat
