#include "shared/import/npy/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "shared/import/geometry/conventions.h"
#include "shared/import/npy/header.h"
#include "shared/import/text/commands.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"

// Reads NumPy's files of one array (.npy), versions 1 to 3 (numpy.lib.format).
//
// 0  6 bytes  "\x93NUMPY"
// 6  u8, u8   version, major and minor
// 8  u16      bytes of the dictionary, little-endian; u32 since version 2
//    text     the dictionary, with spaces and a line end
namespace isosplat::import {
namespace {

/// The dictionary of an array of numbers has about 100 bytes. NumPy has the same limit.
constexpr uint32_t kMaxDictionaryBytes = 10'000;

struct Dictionary {
  std::string text;
  uint64_t end = 0;  ///< offset of the voxels
};

Result<Dictionary> read_dictionary(const std::filesystem::path& path, ByteReader& bytes) {
  std::array<std::byte, 12> raw{};
  if (auto read = bytes.read(0, raw); !read) return tl::unexpected(read.error());
  const auto byte = [&](size_t i) { return static_cast<uint32_t>(raw[i]); };
  const uint32_t major = byte(6), minor = byte(7);
  if (major < 1 || major > 3 || minor != 0) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected version 1.0, 2.0 or 3.0 of NumPy's format, found {}.{}: "
                            "save the array with numpy.save",
                            path.string(), major, minor));
  }
  uint32_t size = byte(8) | byte(9) << 8;
  if (major > 1) size |= byte(10) << 16 | byte(11) << 24;
  if (size > kMaxDictionaryBytes) {
    return malformed_npy(path, fmt::format("expected a header of at most {} bytes, found {}",
                                           kMaxDictionaryBytes, size));
  }
  const uint64_t begin = major > 1 ? 12 : 10;
  Dictionary dictionary{std::string(size, '\0'), begin + size};
  auto read = bytes.read(begin, std::as_writable_bytes(std::span(dictionary.text)));
  if (!read) return tl::unexpected(read.error());
  return dictionary;
}

/// The type and byte order that "descr" names. Errors: unsupported_type.
Result<StoredVoxels> stored_voxels_of(const std::filesystem::path& path, const std::string& name) {
  struct Kind {
    std::string_view name;
    VoxelType type;
    bool is_half = false;
  };
  static constexpr Kind kKinds[] = {
      {"u1", VoxelType::u8},  {"i1", VoxelType::i8},        {"u2", VoxelType::u16},
      {"i2", VoxelType::i16}, {"u4", VoxelType::u32},       {"i4", VoxelType::i32},
      {"u8", VoxelType::u64}, {"i8", VoxelType::i64},       {"f4", VoxelType::f32},
      {"f8", VoxelType::f64}, {"f2", VoxelType::f32, true}, {"b1", VoxelType::u8},
  };
  const std::string_view kind = std::string_view(name).substr(std::min<size_t>(1, name.size()));
  for (const Kind& known : kKinds) {
    StoredVoxels stored;
    stored.type = known.type;
    stored.is_half = known.is_half;
    stored.big_endian = name.starts_with('>');
    const bool has_order = name.starts_with('<') || name.starts_with('>');
    // "|": no byte order, for single bytes.
    const bool is_right = has_order || (name.starts_with('|') && stored_bytes(stored) == 1);
    if (known.name == kind && is_right) return stored;
  }
  if (kind == "c8" || kind == "c16") return not_scalar(path, 2);
  return unknown_type(path, fmt::format("NumPy's type '{}'", name));
}

std::string text_of(const std::vector<int64_t>& shape) {
  return fmt::format("({})", fmt::join(shape, ", "));
}

/// The sizes of the three axes z, y and x. Other axes must have one sample.
Result<std::array<int64_t, 3>> sizes_of(const std::filesystem::path& path,
                                        const std::vector<int64_t>& shape) {
  std::vector<int64_t> sizes;
  std::copy_if(shape.begin(), shape.end(), std::back_inserter(sizes),
               [](int64_t size) { return size != 1; });
  if (sizes.size() > 3) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected an array with the axes z, y and x, found the shape {}: "
                            "save one volume of it with python3 -c \"import sys, numpy; "
                            "numpy.save('volume.npy', numpy.load(sys.argv[1])[{}])\" {}",
                            path.string(), text_of(shape), numpy_index(shape), shell_word(path)));
  }
  if (sizes.size() < 3) {
    return fail(Status::no_cells,
                fmt::format("{}: expected an array with three axes of several samples, found the "
                            "shape {}: save the whole volume as one array",
                            path.string(), text_of(shape)));
  }
  return std::array{sizes[0], sizes[1], sizes[2]};
}

}  // namespace

Result<OpenVolume> open_npy(const std::filesystem::path& path, const ImportOptions& options) {
  auto bytes = open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto dictionary = read_dictionary(path, **bytes);
  if (!dictionary) return tl::unexpected(dictionary.error());
  const auto header = parse_npy_dictionary(path, dictionary->text);
  if (!header) return tl::unexpected(header.error());
  const auto stored = stored_voxels_of(path, header->type);
  if (!stored) return tl::unexpected(stored.error());
  const auto sizes = sizes_of(path, header->shape);
  if (!sizes) return tl::unexpected(sizes.error());
  if (const auto step = choose_step(path, 1, options); !step) return tl::unexpected(step.error());

  std::vector<std::string> notes{
      "a NumPy array does not name its axes: they are read as z, y and x, the last one as x"};
  const Vec3d spacing = options.spacing.value_or(Vec3d{1, 1, 1});
  if (!options.spacing) {
    notes.push_back("a NumPy array has no voxel spacing: 1,1,1 is assumed; --spacing sets another");
  }
  const Vec3d x{spacing.x, 0, 0}, y{0, spacing.y, 0}, z{0, 0, spacing.z};
  // The same array is the same volume in both orders: in Fortran's, z is the fastest axis.
  const bool z_first = header->fortran_order;
  const auto [nz, ny, nx] = *sizes;
  const HeaderGeometry geometry =
      geometry_of_steps(z_first ? std::array{z, y, x} : std::array{x, y, z}, {0, 0, 0});
  ArrayVolume array =
      make_array("NumPy", path, z_first ? Vec3<int64_t>{nz, ny, nx} : Vec3<int64_t>{nx, ny, nz},
                 geometry, options);
  array.geometry = geometry;  // options.spacing is along x, y and z
  array.stored = *stored;
  array.offset = dictionary->end;
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat::import
