#include "native/extract/three_mf_file.h"

#include <fmt/format.h>

#include <functional>
#include <iterator>

#include "native/files/zip_writer.h"

namespace isosplat {
namespace {

constexpr std::string_view kXmlBegin = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

constexpr std::string_view kContentTypes =
    "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">"
    "<Default Extension=\"rels\" "
    "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
    "<Default Extension=\"model\" "
    "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>\n";

constexpr std::string_view kRelationships =
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
    "<Relationship Target=\"/3D/3dmodel.model\" Id=\"model\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>\n";

/// The text as content of an element. Characters that are not ASCII become "?": a file's name need
/// not be valid UTF-8.
std::string escape_xml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += c >= 0x7F || c < 0 ? '?' : c < ' ' ? ' ' : c;
    }
  }
  return escaped;
}

Result<void> write_text(ZipWriter& zip, const char* name, std::string_view text) {
  if (auto begun = zip.begin_entry(name, kXmlBegin.size() + text.size()); !begun) return begun;
  if (auto written = zip.append(kXmlBegin); !written) return written;
  return zip.append(text);
}

}  // namespace

Result<ThreeMfFile> ThreeMfFile::create(const std::filesystem::path& path,
                                        const SurfaceDescription& surface) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  auto vertices = SpooledBytes::create(path.parent_path());
  if (!vertices) return tl::unexpected(vertices.error());
  auto triangles = SpooledBytes::create(path.parent_path());
  if (!triangles) return tl::unexpected(triangles.error());
  return ThreeMfFile(std::move(*file), std::move(*vertices), std::move(*triangles),
                     surface.comment);
}

Result<void> ThreeMfFile::append(const MeshPart& part) {
  constexpr uint64_t kMost = uint64_t{1} << 31;
  vertex_count_ += part.vertices.positions.size();
  triangle_count_ += part.triangles.size();
  if (vertex_count_ > kMost || triangle_count_ > kMost) {
    return fail(Status::invalid_argument,
                "expected at most 2^31 vertices and triangles, the limit of 3MF files, found more: "
                "write a .ply file, or use a coarser --level or --simplify");
  }
  std::string text;
  for (const Vec3d& at : part.vertices.positions) {
    fmt::format_to(std::back_inserter(text), "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n", at.x, at.y,
                   at.z);
  }
  if (auto written = vertices_.append(std::as_bytes(std::span(text))); !written) return written;
  text.clear();
  for (const auto& [a, b, c] : part.triangles) {
    fmt::format_to(std::back_inserter(text), "<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>\n", a, b,
                   c);
  }
  return triangles_.append(std::as_bytes(std::span(text)));
}

Result<void> ThreeMfFile::publish() {
  const std::string begin = fmt::format(
      "{}<model unit=\"millimeter\" xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n"
      "<metadata name=\"Description\">{}</metadata>\n"
      "<resources>{}",
      kXmlBegin, escape_xml(comment_),
      triangle_count_ > 0 ? "<object id=\"1\" type=\"model\"><mesh><vertices>\n" : "");
  const std::string_view middle = triangle_count_ > 0 ? "</vertices><triangles>\n" : "";
  const std::string_view end = triangle_count_ > 0
                                   ? "</triangles></mesh></object></resources>\n<build><item "
                                     "objectid=\"1\"/></build></model>\n"
                                   : "</resources>\n<build/></model>\n";
  ZipWriter zip(file_, ZipWriter::Compression::deflate);
  const auto copy = [&](std::span<const std::byte> piece) { return zip.append(piece); };
  const auto steps = {
      std::function([&] { return write_text(zip, "[Content_Types].xml", kContentTypes); }),
      std::function([&] { return write_text(zip, "_rels/.rels", kRelationships); }),
      std::function([&] {
        return zip.begin_entry("3D/3dmodel.model", begin.size() + vertices_.size() + middle.size() +
                                                       triangles_.size() + end.size());
      }),
      std::function([&] { return zip.append(begin); }),
      std::function([&] { return vertices_.read(copy); }),
      std::function([&] { return zip.append(middle); }),
      std::function([&] { return triangles_.read(copy); }),
      std::function([&] { return zip.append(end); }),
      std::function([&] { return zip.close(); }),
      std::function([&] { return file_.publish(); }),
  };
  for (const std::function<Result<void>()>& step : steps) {
    if (auto done = step(); !done) return done;
  }
  end_ = zip.bytes();
  return {};
}

}  // namespace isosplat
