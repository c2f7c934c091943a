#include "native/extract/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "native/extract/encoded_file.h"
#include "native/extract/npy_encoder.h"
#include "native/extract/npz_file.h"
#include "native/extract/obj_file.h"
#include "native/extract/three_mf_file.h"
#include "native/extract/vtp_file.h"
#include "shared/core/mesh_files/glb_encoder.h"
#include "shared/core/mesh_files/ply_encoder.h"
#include "shared/core/mesh_files/stl_encoder.h"
#include "shared/render/settings/colour_maps.h"

namespace isosplat {
namespace {

Result<std::unique_ptr<MeshFile>> encoded(const std::filesystem::path& path,
                                          std::unique_ptr<MeshEncoder> encoder) {
  auto file = EncodedFile::create(path, std::move(encoder));
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<EncodedFile>(std::move(*file));
}

Result<std::unique_ptr<MeshFile>> create_ply(const std::filesystem::path& path,
                                             const SurfaceDescription& surface) {
  const auto content = surface.content == SurfaceContent::points ? PlyEncoder::Content::points
                                                                 : PlyEncoder::Content::triangles;
  return encoded(
      path, std::make_unique<PlyEncoder>(surface.grid, surface.comment, content, surface.fields));
}

Result<std::unique_ptr<MeshFile>> create_glb(const std::filesystem::path& path,
                                             const SurfaceDescription& surface) {
  const auto& table = render::kColourMapTable[static_cast<size_t>(render::ColourMap::viridis)];
  static const std::vector<std::array<uint8_t, 3>> colours = [&] {
    std::vector<std::array<uint8_t, 3>> all;
    for (const auto& c : table) all.push_back({c[0], c[1], c[2]});
    return all;
  }();
  const GlbFields fields{surface.fields, colours};
  if (surface.objects.empty()) {
    return encoded(path, std::make_unique<GlbEncoder>(surface.grid, surface.comment, fields));
  }
  return encoded(path, std::make_unique<GlbEncoder>(surface.objects, surface.comment, fields));
}

Result<std::unique_ptr<MeshFile>> create_stl(const std::filesystem::path& path,
                                             const SurfaceDescription& surface) {
  return encoded(path, std::make_unique<StlEncoder>(surface.comment));
}

Result<std::unique_ptr<MeshFile>> create_npy(const std::filesystem::path& path,
                                             const SurfaceDescription& surface) {
  return encoded(path,
                 std::make_unique<NpyEncoder>(surface.grid, surface.isovalue, surface.fields));
}

template <class File>
Result<std::unique_ptr<MeshFile>> create(const std::filesystem::path& path,
                                         const SurfaceDescription& surface) {
  auto file = File::create(path, surface);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<File>(std::move(*file));
}

// extension, beginning, name; whether it has points, triangles, objects, is solid, and has fields;
// creation
constexpr std::array kFormats{
    MeshFormat{".ply", "ply\n", "a PLY file", true, true, false, false, true, create_ply},
    MeshFormat{".stl", "isosurface", "an STL file of this program", false, true, false, true, false,
               create_stl},
    MeshFormat{".obj", "# isosurface", "an OBJ file of this program", false, true, true, false,
               false, create<ObjFile>},
    MeshFormat{".glb", "glTF", "a GLB file", false, true, true, false, true, create_glb},
    MeshFormat{".3mf", "PK", "a 3MF file", false, true, true, true, false, create<ThreeMfFile>},
    MeshFormat{".npy", "\x93NUMPY", "a NumPy file", true, false, false, false, true, create_npy},
    MeshFormat{".npz", "PK", "an NPZ file", true, true, false, false, true, create<NpzFile>},
    MeshFormat{".vtp", "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\"", "a VTP file", true,
               true, false, false, true, create<VtpFile>},
};

/// The extensions of the formats for which this is true.
template <class Predicate>
std::string extensions(const Predicate& is_listed) {
  std::string all;
  for (const MeshFormat& format : kFormats) {
    if (is_listed(format)) all += fmt::format("{}{}", all.empty() ? "" : ", ", format.extension);
  }
  return all;
}

}  // namespace

std::string mesh_extensions(SurfaceContent content) {
  return extensions([&](const MeshFormat& format) { return format.has(content); });
}

Result<void> check_holds_fields(const std::filesystem::path& path, const MeshFormat& format,
                                SurfaceContent content) {
  if (format.has_fields) return {};
  return fail(Status::invalid_argument,
              fmt::format("{}: expected a format that can hold values of fields ({}), found {}: "
                          "choose one of them, or extract without fields",
                          path.string(), extensions([&](const MeshFormat& other) {
                            return other.has_fields && other.has(content);
                          }),
                          format.extension));
}

Result<const MeshFormat*> mesh_format(const std::filesystem::path& path, SurfaceContent content) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto found = std::ranges::find(kFormats, extension, &MeshFormat::extension);
  if (found != kFormats.end() && found->has(content)) return &*found;
  const bool is_points = content == SurfaceContent::points;
  std::string remedy = "choose one of them";
  if (found != kFormats.end()) {
    remedy += is_points ? ", or write triangles with --mesh" : ", or write points without --mesh";
  }
  return fail(Status::invalid_argument,
              fmt::format("{}: expected an extension for {} ({}), found \"{}\": {}", path.string(),
                          is_points ? "points" : "triangles", mesh_extensions(content),
                          path.extension().string(), remedy));
}

}  // namespace isosplat
