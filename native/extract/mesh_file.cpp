#include "native/extract/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "native/extract/encoded_file.h"
#include "native/extract/obj_file.h"
#include "native/extract/three_mf_file.h"

namespace isosplat {
namespace {

template <MeshFormatId format>
Result<std::unique_ptr<MeshFile>> create_encoded(const std::filesystem::path& path,
                                                 const VolumeGrid& grid, std::string_view comment) {
  auto file = EncodedFile::create(path, make_mesh_encoder(format, grid, comment));
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<EncodedFile>(std::move(*file));
}

template <class File>
Result<std::unique_ptr<MeshFile>> create(const std::filesystem::path& path, const VolumeGrid& grid,
                                         std::string_view comment) {
  auto file = File::create(path, grid, comment);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<File>(std::move(*file));
}

constexpr std::array kFormats{
    MeshFormat{".ply", "ply\n", "a PLY file", create_encoded<MeshFormatId::ply>},
    MeshFormat{".stl", "isosurface", "an STL file of this program",
               create_encoded<MeshFormatId::stl>},
    MeshFormat{".obj", "# isosurface", "an OBJ file of this program", create<ObjFile>},
    MeshFormat{".glb", "glTF", "a GLB file", create_encoded<MeshFormatId::glb>},
    MeshFormat{".3mf", "PK", "a 3MF file", create<ThreeMfFile>},
};

}  // namespace

std::string mesh_extensions() {
  std::string all;
  for (const MeshFormat& format : kFormats) {
    all += fmt::format("{}{}", all.empty() ? "" : ", ", format.extension);
  }
  return all;
}

Result<const MeshFormat*> mesh_format(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto found = std::ranges::find(kFormats, extension, &MeshFormat::extension);
  if (found != kFormats.end()) return &*found;
  return fail(
      Status::invalid_argument,
      fmt::format("{}: expected the extension of a mesh file ({}), found \"{}\": choose one "
                  "of them",
                  path.string(), mesh_extensions(), path.extension().string()));
}

}  // namespace isosplat
