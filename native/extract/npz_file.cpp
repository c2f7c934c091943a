#include "native/extract/npz_file.h"

#include <fmt/format.h>

#include <array>

#include "native/extract/array_bytes.h"
#include "native/extract/npy_header.h"
#include "native/files/zip_writer.h"
#include "shared/core/points/position_precision.h"

namespace isosplat {
namespace {

/// Writes an array of rows of three numbers of `number_bytes` each.
Result<void> write_rows(ZipWriter& zip, const char* name, std::string_view dtype,
                        size_t number_bytes, const SpooledBytes& rows) {
  const std::string header =
      npy_header(dtype, fmt::format("({}, 3)", rows.size() / (3 * number_bytes)));
  if (auto begun = zip.begin_entry(name, header.size() + rows.size()); !begun) return begun;
  if (auto written = zip.append(header); !written) return written;
  return rows.read([&](std::span<const std::byte> piece) { return zip.append(piece); });
}

/// Writes an array of numbers in single precision.
Result<void> write_values(ZipWriter& zip, const std::string& name, const SpooledBytes& values) {
  const std::string header = npy_header("'<f4'", fmt::format("({},)", values.size() / 4));
  const uint64_t size = header.size() + values.size();
  if (auto begun = zip.begin_entry(name.c_str(), size); !begun) return begun;
  if (auto written = zip.append(header); !written) return written;
  return values.read([&](std::span<const std::byte> piece) { return zip.append(piece); });
}

constexpr std::array<std::string_view, 4> kArrays{"positions", "normals", "triangles", "isovalue"};

Result<void> write_number(ZipWriter& zip, const char* name, double number) {
  const std::string header = npy_header("'<f8'", "()");
  if (auto begun = zip.begin_entry(name, header.size() + sizeof number); !begun) return begun;
  if (auto written = zip.append(header); !written) return written;
  return zip.append(std::as_bytes(std::span(&number, 1)));
}

}  // namespace

NpzFile::NpzFile(OutputFile file, SpooledBytes positions, SpooledBytes normals,
                 SpooledBytes triangles, std::vector<SpooledBytes> fields,
                 const SurfaceDescription& surface)
    : file_(std::move(file)),
      positions_(std::move(positions)),
      normals_(std::move(normals)),
      triangles_(std::move(triangles)),
      fields_(std::move(fields)),
      names_(column_names(surface.fields, kArrays)),
      has_doubles_(needs_doubles(surface.grid)),
      is_mesh_(surface.content == SurfaceContent::triangles),
      isovalue_(surface.isovalue) {}

Result<NpzFile> NpzFile::create(const std::filesystem::path& path,
                                const SurfaceDescription& surface) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  auto positions = SpooledBytes::create(path.parent_path());
  if (!positions) return tl::unexpected(positions.error());
  auto normals = SpooledBytes::create(path.parent_path());
  if (!normals) return tl::unexpected(normals.error());
  auto triangles = SpooledBytes::create(path.parent_path());
  if (!triangles) return tl::unexpected(triangles.error());
  std::vector<SpooledBytes> fields;
  for (size_t i = 0; i < surface.fields.size(); ++i) {
    auto values = SpooledBytes::create(path.parent_path());
    if (!values) return tl::unexpected(values.error());
    fields.push_back(std::move(*values));
  }
  return NpzFile(std::move(*file), std::move(*positions), std::move(*normals),
                 std::move(*triangles), std::move(fields), surface);
}

Result<void> NpzFile::append(const MeshPart& part) {
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

Result<void> NpzFile::publish() {
  ZipWriter zip(file_, ZipWriter::Compression::store);
  const size_t position_bytes = has_doubles_ ? 8 : 4;
  auto done = write_rows(zip, "positions.npy", has_doubles_ ? "'<f8'" : "'<f4'", position_bytes,
                         positions_);
  if (done) done = write_rows(zip, "normals.npy", "'<f4'", 4, normals_);
  if (done && is_mesh_) done = write_rows(zip, "triangles.npy", "'<u4'", 4, triangles_);
  if (done) done = write_number(zip, "isovalue.npy", isovalue_);
  for (size_t i = 0; done && i < fields_.size(); ++i) {
    done = write_values(zip, names_[i] + ".npy", fields_[i]);
  }
  if (done) done = zip.close();
  if (!done) return done;
  end_ = zip.bytes();
  return file_.publish();
}

}  // namespace isosplat
