#include "native/extract/obj_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace isosplat {
namespace {

/// The text on one line: control characters become blanks.
std::string on_a_line(std::string line) {
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return line;
}

}  // namespace

Result<ObjFile> ObjFile::create(const std::filesystem::path& path,
                                const SurfaceDescription& surface) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  ObjFile obj(std::move(*file), surface.objects);
  const std::string line = on_a_line(fmt::format("# {}", surface.comment));
  if (auto written = obj.write(line + "\n"); !written) return tl::unexpected(written.error());
  if (auto named = obj.write_name(); !named) return tl::unexpected(named.error());
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
  vertices_ += part.vertices.positions.size();
  const uint64_t first = before_ + 1;
  for (const auto& [a, b, c] : part.triangles) {
    fmt::format_to(out, "f {0}//{0} {1}//{1} {2}//{2}\n", first + a, first + b, first + c);
  }
  return write(text);
}

Result<void> ObjFile::next_object() {
  ++open_;
  before_ = vertices_;
  return write_name();
}

/// Some programs divide a file by its objects (o), others by its groups (g). A blank would begin
/// the name of another group.
Result<void> ObjFile::write_name() {
  if (objects_.empty()) return {};
  std::string name = on_a_line(objects_[open_].name);
  std::ranges::replace(name, ' ', '_');
  return write(fmt::format("o {0}\ng {0}\n", name));
}

Result<void> ObjFile::write(const std::string& text) {
  auto written = file_.write(end_, std::as_bytes(std::span(text)));
  if (written) end_ += text.size();
  return written;
}

}  // namespace isosplat
