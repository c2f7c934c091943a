#include "shared/import/volume/volume_name.h"

#include "shared/import/codecs/packing.h"

namespace isosplat::import {

std::string volume_name(const std::filesystem::path& path) {
  std::filesystem::path file = path.filename();
  if (file.empty()) file = path.parent_path().filename();  // "folder/"
  file = unpacked_name(file);
  const std::string stem = file.stem().string();
  return stem.empty() ? "volume" : stem;
}

}  // namespace isosplat::import
