#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/volume/allowances.h"

namespace isosplat::import {

/// Parses the list of data files in a detached header: NRRD's "data file" and MetaImage's
/// "ElementDataFile". `value` is "LIST …", followed by one file per line after the header; or a
/// pattern with one %d and first, last and step, such as "slice%03d.raw 1 20 1". Relative names are
/// relative to the header's folder. At most a million files; they need not exist. Empty if `value`
/// is neither.
std::vector<std::filesystem::path> named_data_files(const std::filesystem::path& header,
                                                    std::string_view value);

/// Whether the value of "data file" or "ElementDataFile" is "LIST" with or without a dimension. The
/// first word decides: "list.raw" is the name of a file.
bool is_list_of_files(std::string_view value);

/// The offset of `bytes` bytes of voxels that end with their file of `file_bytes` bytes. They begin
/// after `begin`, where the header ends. Errors: truncated, also if truncation is allowed: the
/// beginning of the voxels in an incomplete file is unknown.
Result<uint64_t> offset_before_end(const std::filesystem::path& path, uint64_t file_bytes,
                                   uint64_t begin, uint64_t bytes);

/// Whether `files` files can divide an array with these sizes (fastest first) evenly: each file has
/// all samples of some axes, and there is one file for each sample of the other axes.
bool divides_axes(size_t files, std::span<const int64_t> sizes);

/// A byte range without data.
struct ByteRange {
  uint64_t begin = 0, end = 0;
};

/// How the voxels of a volume are distributed over files.
struct DataFiles {
  std::vector<std::filesystem::path> paths;
  uint64_t bytes_each = 0;  ///< of voxels in each file
  size_t voxel_bytes = 1;   ///< size of one voxel; an incomplete voxel at the end is not used
  int64_t skip = 0;  ///< bytes before the voxels in each file; −1: the voxels are at the file's end
  bool deflated = false;  ///< each file is compressed separately
};

/// The result of open_data_files.
struct JoinedFiles {
  std::unique_ptr<ByteReader> reader;  ///< the voxels of all files, one after another
  std::vector<ByteRange> missing;      ///< of missing or short files; they read as zeros
  std::vector<std::string> notes;
};

/// Opens the data files of one volume as one reader. Every file must exist (unless gaps are
/// allowed) and have exactly its number of voxels (unless truncation or surplus is allowed); at
/// least one file must exist. Keeps one file open at a time. `header`: for messages. Errors:
/// io_error for missing files, truncated, malformed_volume.
Result<JoinedFiles> open_data_files(const std::filesystem::path& header, DataFiles files,
                                    Allowances allowed);

}  // namespace isosplat::import
