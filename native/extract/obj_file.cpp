#include "native/extract/obj_file.h"

#include <fmt/format.h>

#include <iterator>

namespace isosplat {

Result<ObjFile> ObjFile::create(const std::filesystem::path& path,
                                const SurfaceDescription& surface) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  ObjFile obj(std::move(*file));
  std::string line = fmt::format("# {}", surface.comment);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  if (auto written = obj.write(line + "\n"); !written) return tl::unexpected(written.error());
  return obj;
}

Result<void> ObjFile::append(const MeshPart& part) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (const Vec3d& at : part.vertices.positions) {
    fmt::format_to(out, "v {} {} {}\n", at.x, at.y, at.z);
  }
  for (const Vec3f& normal : part.vertices.normals) {
    fmt::format_to(out, "vn {} {} {}\n", normal.x, normal.y, normal.z);
  }
  for (const auto& [a, b, c] : part.triangles) {
    fmt::format_to(out, "f {0}//{0} {1}//{1} {2}//{2}\n", uint64_t{a} + 1, uint64_t{b} + 1,
                   uint64_t{c} + 1);
  }
  return write(text);
}

Result<void> ObjFile::write(const std::string& text) {
  auto written = file_.write(end_, std::as_bytes(std::span(text)));
  if (written) end_ += text.size();
  return written;
}

}  // namespace isosplat
