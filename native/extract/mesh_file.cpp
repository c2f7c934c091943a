#include "native/extract/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "native/extract/glb_file.h"
#include "native/extract/obj_file.h"
#include "native/extract/ply_file.h"
#include "native/extract/stl_file.h"
#include "native/extract/three_mf_file.h"

namespace isosplat {
namespace {

/// A PLY file as a file of mesh parts.
class PlyMeshFile : public MeshFile {
 public:
  static Result<PlyMeshFile> create(const std::filesystem::path& path, const VolumeGrid& grid,
                                    std::string_view comment) {
    auto ply = PlyFile::create(path, grid, comment, PlyFile::Content::triangles);
    if (!ply) return tl::unexpected(ply.error());
    return PlyMeshFile(std::move(*ply));
  }
  Result<void> append(const MeshPart& part) override {
    if (auto points = file_.append(part.vertices); !points) return points;
    return file_.append(part.triangles);
  }
  Result<void> publish() override { return file_.publish(); }
  uint64_t bytes() const override { return file_.bytes(); }

 private:
  explicit PlyMeshFile(PlyFile file) : file_(std::move(file)) {}

  PlyFile file_;
};

template <class File>
Result<std::unique_ptr<MeshFile>> create(const std::filesystem::path& path, const VolumeGrid& grid,
                                         std::string_view comment) {
  auto file = File::create(path, grid, comment);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<File>(std::move(*file));
}

constexpr std::array kFormats{
    MeshFormat{".ply", "ply\n", "a PLY file", create<PlyMeshFile>},
    MeshFormat{".stl", "isosurface", "an STL file of this program", create<StlFile>},
    MeshFormat{".obj", "# isosurface", "an OBJ file of this program", create<ObjFile>},
    MeshFormat{".glb", "glTF", "a GLB file", create<GlbFile>},
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
