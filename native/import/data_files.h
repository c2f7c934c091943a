#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace isosplat {

/// The data files that a detached header names together, as NRRD's "data file" and MetaImage's
/// "ElementDataFile" do: `value` is "LIST …", and each line after the header's is a file, or a
/// pattern with one %d and first, last and step, as "slice%03d.raw 1 20 1". Relative names are
/// those of the header's folder. At most a million; a file need not exist. Empty for a pattern that
/// is neither.
std::vector<std::filesystem::path> named_data_files(const std::filesystem::path& header,
                                                    std::string_view value);

}  // namespace isosplat
