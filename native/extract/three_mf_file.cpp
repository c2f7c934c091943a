#include "native/extract/three_mf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "native/files/zip_writer.h"

namespace isosplat {
namespace {

constexpr std::string_view kXmlBegin = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// Numbers of the model's resources.
constexpr size_t kMaterials = 1, kFirstObject = 2;

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

/// Whether XML may have this text: valid UTF-8, without U+FFFE and U+FFFF.
bool is_xml_text(std::string_view text) {
  for (const std::string_view excluded : {"\xEF\xBF\xBE", "\xEF\xBF\xBF"}) {
    if (text.find(excluded) != std::string_view::npos) return false;
  }
  try {
    static_cast<void>(nlohmann::json(text).dump());
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

/// The text as content of an element or as the value of an attribute. If XML may not have the text,
/// its bytes that are not ASCII become "?": a file's name may have any bytes.
std::string escape_xml(std::string_view text) {
  const bool is_valid = is_xml_text(text);
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
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c < 0 ? (is_valid ? c : '?') : c == 0x7F ? '?' : c < ' ' ? ' ' : c;
    }
  }
  return escaped;
}

/// #RRGGBBAA
std::string colour_text(const MeshObject& object) {
  const auto byte = [](float of_one) {
    return static_cast<int>(std::lround(255 * std::clamp(of_one, 0.f, 1.f)));
  };
  const auto [red, green, blue] = object.colour;
  return fmt::format("#{:02X}{:02X}{:02X}{:02X}", byte(red), byte(green), byte(blue),
                     byte(object.opacity));
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
  auto model = SpooledBytes::create(path.parent_path());
  if (!model) return tl::unexpected(model.error());
  auto vertices = SpooledBytes::create(path.parent_path());
  if (!vertices) return tl::unexpected(vertices.error());
  auto triangles = SpooledBytes::create(path.parent_path());
  if (!triangles) return tl::unexpected(triangles.error());
  return ThreeMfFile(std::move(*file), std::move(*model), std::move(*vertices),
                     std::move(*triangles), surface);
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

Result<void> ThreeMfFile::close_object() {
  if (triangle_count_ > 0) {
    const size_t id = kFirstObject + open_;
    std::string begin = fmt::format("<object id=\"{}\" type=\"model\"", id);
    if (!objects_.empty()) {
      begin += fmt::format(" name=\"{}\" pid=\"{}\" pindex=\"{}\"",
                           escape_xml(objects_[open_].name), kMaterials, open_);
    }
    begin += "><mesh><vertices>\n";
    const auto write = [&](std::string_view text) {
      return model_.append(std::as_bytes(std::span(text)));
    };
    const auto copy = [&](std::span<const std::byte> piece) { return model_.append(piece); };
    auto done = write(begin);
    if (done) done = vertices_.read(copy);
    if (done) done = write("</vertices><triangles>\n");
    if (done) done = triangles_.read(copy);
    if (done) done = write("</triangles></mesh></object>\n");
    if (!done) return done;
    built_.push_back(open_);
  }
  vertices_.clear();
  triangles_.clear();
  vertex_count_ = triangle_count_ = 0;
  return {};
}

Result<void> ThreeMfFile::next_object() {
  auto closed = close_object();
  ++open_;
  return closed;
}

std::string ThreeMfFile::materials() const {
  if (objects_.empty()) return {};
  std::string text = fmt::format("<basematerials id=\"{}\">", kMaterials);
  for (const MeshObject& object : objects_) {
    text += fmt::format("<base name=\"{}\" displaycolor=\"{}\"/>", escape_xml(object.name),
                        colour_text(object));
  }
  return text + "</basematerials>\n";
}

Result<void> ThreeMfFile::publish() {
  if (auto closed = close_object(); !closed) return closed;
  const std::string begin = fmt::format(
      "{}<model unit=\"millimeter\" xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n"
      "<metadata name=\"Description\">{}</metadata>\n"
      "<resources>{}",
      kXmlBegin, escape_xml(comment_), materials());
  std::string end = "</resources>\n<build>";
  for (const size_t object : built_) {
    end += fmt::format("<item objectid=\"{}\"/>", kFirstObject + object);
  }
  end += "</build></model>\n";
  ZipWriter zip(file_, ZipWriter::Compression::deflate);
  const auto copy = [&](std::span<const std::byte> piece) { return zip.append(piece); };
  auto done = write_text(zip, "[Content_Types].xml", kContentTypes);
  if (done) done = write_text(zip, "_rels/.rels", kRelationships);
  if (done) {
    done = zip.begin_entry("3D/3dmodel.model", begin.size() + model_.size() + end.size());
  }
  if (done) done = zip.append(begin);
  if (done) done = model_.read(copy);
  if (done) done = zip.append(end);
  if (done) done = zip.close();
  if (done) done = file_.publish();
  if (!done) return done;
  end_ = zip.bytes();
  return {};
}

}  // namespace isosplat
