#include "shared/import/npy/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "shared/import/geometry/conventions.h"
#include "shared/import/npy/header.h"
#include "shared/import/text/commands.h"
#include "shared/import/volume/choose_channel.h"
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
  if (std::memcmp(raw.data(), "\x93NUMPY", 6) != 0) {
    return malformed_npy(path, "expected an array of NumPy");
  }
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

/// At most so many samples of an axis are channels rather than voxels or times: those of colours.
constexpr int64_t kMaxChannels = 4;

/// The axes of an array: z, y and x, and at most one other before or after them.
struct NpyAxes {
  std::array<int64_t, 3> sizes{};
  int64_t others = 1;         ///< samples of the other axis
  bool is_last = false;       ///< the other axis is the last one
  bool are_channels = false;  ///< or time steps
};

/// Finds the axes. Those with one sample do not count. As in ImageJ's and tifffile's arrays, the
/// first of four axes is time, or channels if the options choose one; a last axis of at most four
/// samples is that of colours.
Result<NpyAxes> axes_of(const std::filesystem::path& path, const std::vector<int64_t>& shape,
                        const ImportOptions& options) {
  std::vector<int64_t> sizes;
  std::copy_if(shape.begin(), shape.end(), std::back_inserter(sizes),
               [](int64_t size) { return size != 1; });
  if (sizes.size() > 4) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected an array with the axes z, y and x, and one of times or "
                            "channels, found the shape {}: save one volume of it with python3 -c "
                            "\"import sys, numpy; numpy.save('volume.npy', "
                            "numpy.load(sys.argv[1])[{}])\" {}",
                            path.string(), text_of(shape), numpy_index(shape), shell_word(path)));
  }
  const bool is_empty =
      sizes.size() == 4 && std::find(sizes.begin(), sizes.end(), 0) != sizes.end();
  if (sizes.size() < 3 || is_empty) {
    return fail(Status::no_cells,
                fmt::format("{}: expected an array with three axes of several samples, found the "
                            "shape {}: save the whole volume as one array",
                            path.string(), text_of(shape)));
  }
  NpyAxes axes;
  if (sizes.size() == 3) {
    axes.sizes = {sizes[0], sizes[1], sizes[2]};
    return axes;
  }
  const bool is_first_short = sizes[0] <= kMaxChannels, is_last_short = sizes[3] <= kMaxChannels;
  if (is_first_short && is_last_short &&
      options.channel.has_value() == options.time_step.has_value()) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected the axes z, y and x, and one of times or channels, found "
                            "the shape {}, whose first and last axis may be that: choose along the "
                            "first with --time-step 0 to --time-step {}, or along the last with "
                            "--channel 0 to --channel {}",
                            path.string(), text_of(shape), sizes[0] - 1, sizes[3] - 1));
  }
  axes.is_last = is_last_short && !(is_first_short && options.time_step);
  axes.are_channels = axes.is_last || (options.channel && !options.time_step);
  const size_t at = axes.is_last ? 0 : 1;
  axes.sizes = {sizes[at], sizes[at + 1], sizes[at + 2]};
  axes.others = axes.is_last ? sizes[3] : sizes[0];
  return axes;
}

std::string described(const NpyAxes& axes) {
  if (axes.others == 1) {
    return "a NumPy array does not name its axes: they are read as z, y and x, the last one as x";
  }
  return fmt::format(
      "a NumPy array does not name its axes: the {} one is read as {} of {}{}, the others as z, y "
      "and x",
      axes.is_last ? "last" : "first", axes.are_channels ? "channels" : "time steps", axes.others,
      axes.are_channels || axes.is_last ? "" : " (--channel reads it as channels)");
}

}  // namespace

Result<OpenVolume> open_npy(const std::filesystem::path& path, const ImportOptions& options) {
  auto bytes = open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return open_npy_array(path, std::move(*bytes), true, options);
}

Result<std::vector<int64_t>> npy_shape(const std::filesystem::path& path, ByteReader& bytes) {
  const auto dictionary = read_dictionary(path, bytes);
  if (!dictionary) return tl::unexpected(dictionary.error());
  auto header = parse_npy_dictionary(path, dictionary->text);
  if (!header) return tl::unexpected(header.error());
  return std::move(header->shape);
}

Result<OpenVolume> open_npy_array(const std::filesystem::path& path,
                                  std::unique_ptr<ByteReader> bytes, bool is_plain,
                                  const ImportOptions& options) {
  const auto dictionary = read_dictionary(path, *bytes);
  if (!dictionary) return tl::unexpected(dictionary.error());
  const auto header = parse_npy_dictionary(path, dictionary->text);
  if (!header) return tl::unexpected(header.error());
  const auto stored = stored_voxels_of(path, header->type);
  if (!stored) return tl::unexpected(stored.error());
  const auto axes = axes_of(path, header->shape, options);
  if (!axes) return tl::unexpected(axes.error());
  const auto step = choose_step(path, axes->are_channels ? 1 : axes->others, options);
  if (!step) return tl::unexpected(step.error());
  const auto channel =
      choose_channel(path, static_cast<uint64_t>(axes->are_channels ? axes->others : 1), options);
  if (!channel) return tl::unexpected(channel.error());

  std::vector<std::string> notes{described(*axes)};
  const Vec3d spacing = options.spacing.value_or(Vec3d{1, 1, 1});
  if (!options.spacing) {
    notes.push_back("a NumPy array has no voxel spacing: 1,1,1 is assumed; --spacing sets another");
  }
  const Vec3d x{spacing.x, 0, 0}, y{0, spacing.y, 0}, z{0, 0, spacing.z};
  // The same array is the same volume in both orders: in Fortran's, z is the fastest axis.
  const bool z_first = header->fortran_order;
  const auto [nz, ny, nx] = axes->sizes;
  const HeaderGeometry geometry =
      geometry_of_steps(z_first ? std::array{z, y, x} : std::array{x, y, z}, {0, 0, 0});
  ArrayVolume array =
      make_array("NumPy", path, z_first ? Vec3<int64_t>{nz, ny, nx} : Vec3<int64_t>{nx, ny, nz},
                 geometry, options);
  array.geometry = geometry;  // options.spacing is along x, y and z
  array.stored = *stored;
  array.offset = dictionary->end;
  array.steps = static_cast<uint64_t>(axes->others);
  array.step = axes->are_channels ? *channel : *step;
  if (axes->others > 1 && axes->is_last != z_first) array.step_axis = 0;
  array.plain = is_plain;
  return open_array(std::move(array), std::move(bytes), std::move(notes));
}

}  // namespace isosplat::import
