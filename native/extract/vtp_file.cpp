#include "native/extract/vtp_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <iterator>

#include "native/extract/array_bytes.h"
#include "shared/core/points/position_precision.h"

namespace isosplat {
namespace {

constexpr std::array<std::string_view, 2> kArrays{"Normals", "Points"};

/// Numbers that are converted together.
constexpr size_t kPiece = 1 << 16;

/// The text within an element of XML.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return result;
}

/// Writes the length of an array of Int64, and numbers number_at(0), number_at(1), …
template <class NumberAt>
Result<void> write_numbers(uint64_t count, const NumberAt& number_at,
                           const std::function<Result<void>(std::span<const std::byte>)>& write) {
  std::vector<int64_t> numbers{static_cast<int64_t>(8 * count)};
  for (uint64_t i = 0; i < count; ++i) {
    numbers.push_back(number_at(i));
    if (numbers.size() < kPiece) continue;
    if (auto written = write(std::as_bytes(std::span(numbers))); !written) return written;
    numbers.clear();
  }
  return write(std::as_bytes(std::span(numbers)));
}

}  // namespace

VtpFile::VtpFile(OutputFile file, std::vector<SpooledBytes> arrays,
                 const SurfaceDescription& surface)
    : file_(std::move(file)),
      positions_(std::move(arrays[0])),
      normals_(std::move(arrays[1])),
      triangles_(std::move(arrays[2])),
      columns_(surface.fields.begin(), surface.fields.end()),
      names_(column_names(surface.fields, kArrays)),
      has_doubles_(needs_doubles(surface.grid)),
      is_mesh_(surface.content == SurfaceContent::triangles) {
  std::move(arrays.begin() + 3, arrays.end(), std::back_inserter(fields_));
}

Result<VtpFile> VtpFile::create(const std::filesystem::path& path,
                                const SurfaceDescription& surface) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  std::vector<SpooledBytes> arrays;
  for (size_t i = 0; i < 3 + surface.fields.size(); ++i) {
    auto array = SpooledBytes::create(path.parent_path());
    if (!array) return tl::unexpected(array.error());
    arrays.push_back(std::move(*array));
  }
  return VtpFile(std::move(*file), std::move(arrays), surface);
}

Result<void> VtpFile::append(const MeshPart& part) {
  points_ += part.vertices.positions.size();
  std::vector<std::byte> bytes;
  for (const Vec3d& at : part.vertices.positions) append_position(at, has_doubles_, bytes);
  if (auto written = positions_.append(bytes); !written) return written;
  const auto normals = std::as_bytes(std::span(part.vertices.normals));
  if (auto written = normals_.append(normals); !written) return written;
  for (size_t i = 0; i < fields_.size(); ++i) {
    const auto values = std::as_bytes(std::span(part.vertices.fields[i]));
    if (auto written = fields_[i].append(values); !written) return written;
  }
  return triangles_.append(std::as_bytes(std::span(part.triangles)));
}

uint64_t VtpFile::cell_count() const {
  return is_mesh_ ? triangles_.size() / 12 : points_;
}

/// The tag of the next array of the appended data, which has a length of 8 bytes before it.
std::string VtpFile::begin_array(const std::string& attributes, uint64_t bytes) {
  const uint64_t offset = data_;
  data_ += 8 + bytes;
  return fmt::format("<DataArray {} format=\"appended\" offset=\"{}\"", attributes, offset);
}

std::string VtpFile::cells(const char* element) {
  const uint64_t corners = cell_count() * (is_mesh_ ? 3 : 1);
  std::string text = fmt::format("<{}>", element);
  text += begin_array("type=\"Int64\" Name=\"connectivity\"", 8 * corners) + "/>";
  text += begin_array("type=\"Int64\" Name=\"offsets\"", 8 * cell_count()) + "/>";
  return text + fmt::format("</{}>\n", element);
}

std::string VtpFile::header() {
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData><Piece "
      "NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"{}\">\n",
      points_, is_mesh_ ? 0 : cell_count(), is_mesh_ ? cell_count() : 0);
  const std::string type = fmt::format("type=\"{}\" Name=\"Points\" NumberOfComponents=\"3\"",
                                       has_doubles_ ? "Float64" : "Float32");
  text += "<Points>" + begin_array(type, positions_.size()) + "/></Points>\n<PointData";
  if (!names_.empty()) text += fmt::format(" Scalars=\"{}\"", names_[0]);
  text += " Normals=\"Normals\">\n";
  text +=
      begin_array("type=\"Float32\" Name=\"Normals\" NumberOfComponents=\"3\"", normals_.size()) +
      "/>\n";
  for (size_t i = 0; i < names_.size(); ++i) {
    text += begin_array(fmt::format("type=\"Float32\" Name=\"{}\"", names_[i]), fields_[i].size());
    text += columns_[i].units.empty()
                ? "/>\n"
                : fmt::format(
                      ">\n<InformationKey name=\"UNITS_LABEL\" "
                      "location=\"vtkDataArray\">{}</InformationKey>\n</DataArray>\n",
                      escaped(columns_[i].units));
  }
  text += "</PointData>\n";
  text += cells(is_mesh_ ? "Polys" : "Verts");
  return text + "</Piece></PolyData>\n<AppendedData encoding=\"raw\">\n_";
}

Result<void> VtpFile::write(std::span<const std::byte> bytes) {
  auto written = file_.write(end_, bytes);
  end_ += bytes.size();
  return written;
}

Result<void> VtpFile::write_array(const SpooledBytes& array) {
  const uint64_t size = array.size();
  if (auto written = write(std::as_bytes(std::span(&size, 1))); !written) return written;
  return array.read([&](std::span<const std::byte> piece) { return write(piece); });
}

Result<void> VtpFile::write_connectivity() {
  const auto write_bytes = [&](std::span<const std::byte> bytes) { return write(bytes); };
  if (!is_mesh_) {
    return write_numbers(
        points_, [](uint64_t i) { return static_cast<int64_t>(i); }, write_bytes);
  }
  const uint64_t size = triangles_.size() / 4 * 8;
  if (auto written = write(std::as_bytes(std::span(&size, 1))); !written) return written;
  return triangles_.read([&](std::span<const std::byte> piece) {
    std::vector<int64_t> numbers;
    for (size_t at = 0; at + 4 <= piece.size(); at += 4) {
      uint32_t vertex = 0;
      std::memcpy(&vertex, &piece[at], 4);
      numbers.push_back(vertex);
    }
    return write(std::as_bytes(std::span(numbers)));
  });
}

Result<void> VtpFile::write_offsets() {
  const uint64_t corners = is_mesh_ ? 3 : 1;
  return write_numbers(
      cell_count(), [&](uint64_t i) { return static_cast<int64_t>((i + 1) * corners); },
      [&](std::span<const std::byte> bytes) { return write(bytes); });
}

Result<void> VtpFile::publish() {
  const std::string begin = header(), end = "\n</AppendedData>\n</VTKFile>\n";
  auto done = write(std::as_bytes(std::span(begin)));
  if (done) done = write_array(positions_);
  if (done) done = write_array(normals_);
  for (size_t i = 0; done && i < fields_.size(); ++i) done = write_array(fields_[i]);
  if (done) done = write_connectivity();
  if (done) done = write_offsets();
  if (done) done = write(std::as_bytes(std::span(end)));
  if (!done) return done;
  return file_.publish();
}

}  // namespace isosplat
