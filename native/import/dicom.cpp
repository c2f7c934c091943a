#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "native/import/absent_voxels.h"
#include "native/import/array_source.h"
#include "native/import/dicom_order.h"
#include "native/import/dicom_pixels.h"
#include "native/import/formats.h"
#include "native/import/header_text.h"
#include "native/import/slice_files.h"

// Reads DICOM: a folder with a file per slice, or files with several frames. dicom_frames.h makes
// frames from the files' elements, dicom_stacks.h groups frames into stacks, dicom_order.h orders
// them by position. dicom_pixels.h reads the pixels when slices are requested.
namespace isosplat {
namespace {

using namespace dicom;

/// Number of file names that a note lists.
constexpr size_t kMaxNames = 4;

/// How the pixels of all frames are read: as one type that can hold all of them.
struct Values {
  VoxelType type = VoxelType::i16;
  bool has_one_rescaling = true;
  double min_slope = 1, greatest_slope = 1;
  // for the volume header; if not 1 and 0, voxels are the stored pixels
  double slope = 1, intercept = 0;
};

/// The narrowest integer type for numbers from `low` to `high`; f64 if there is none.
VoxelType type_for(double low, double high) {
  struct Range {
    VoxelType type;
    double low, high;
  };
  constexpr Range kRanges[] = {
      {VoxelType::u8, 0, 255},           {VoxelType::i8, -128, 127},
      {VoxelType::u16, 0, 65535},        {VoxelType::i16, -32768, 32767},
      {VoxelType::u32, 0, 4294967295.0}, {VoxelType::i32, -2147483648.0, 2147483647.0},
  };
  for (const Range& range : kRanges) {
    if (low >= range.low && high <= range.high) return range.type;
  }
  return VoxelType::f64;
}

/// Values stay integers if slope and intercept are integers, or if they are equal for all frames:
/// then they become the volume's slope and intercept. Other values become floating-point numbers,
/// of 64 bits if pixels have more than 16 bits; so do integers if some are absent.
Values find_values(const Collection& collection, const std::vector<uint32_t>& frames) {
  Values values;
  const Frame& first = collection.frames[frames[0]];
  double low = 0, high = 0, min_pixel = 0, greatest_pixel = 0;
  bool is_whole = true, is_wide = false, is_float = false, lacks_some = false;
  values.min_slope = values.greatest_slope = first.slope;
  for (const uint32_t index : frames) {
    const Frame& frame = collection.frames[index];
    const Image& image = collection.images[frame.image];
    values.has_one_rescaling = values.has_one_rescaling && frame.slope == first.slope &&
                               frame.intercept == first.intercept;
    values.min_slope = std::min(values.min_slope, frame.slope);
    values.greatest_slope = std::max(values.greatest_slope, frame.slope);
    is_float = is_float || image.is_float;
    lacks_some = lacks_some || image.cut_off;
    is_whole = is_whole && !image.is_float && frame.slope == std::round(frame.slope) &&
               frame.intercept == std::round(frame.intercept);
    is_wide = is_wide || (image.is_float ? image.allocated == 64 : image.stored > 16);
    const auto [smallest, largest] = stored_range(image);
    min_pixel = std::min<double>(min_pixel, smallest);
    greatest_pixel = std::max<double>(greatest_pixel, largest);
    for (const double stored : {smallest, largest}) {
      low = std::min(low, frame.intercept + frame.slope * stored);
      high = std::max(high, frame.intercept + frame.slope * stored);
    }
  }
  if (is_whole) {
    values.type = type_for(low, high);
  } else if (values.has_one_rescaling && !is_float && first.slope != 0) {
    values.type = type_for(min_pixel, greatest_pixel);
    values.slope = first.slope;
    values.intercept = first.intercept;
  } else {
    values.type = is_wide ? VoxelType::f64 : VoxelType::f32;
  }
  if (lacks_some) values.type = type_with_absent(values.type);
  return values;
}

/// out = (1 − weight) · out + weight · other, rounded for integers.
template <class T>
void blend(std::span<std::byte> out, std::span<const std::byte> other, double weight) {
  for (size_t at = 0; at + sizeof(T) <= out.size(); at += sizeof(T)) {
    T a, b;
    std::memcpy(&a, out.data() + at, sizeof(T));
    std::memcpy(&b, other.data() + at, sizeof(T));
    const double mixed = (1 - weight) * static_cast<double>(a) + weight * static_cast<double>(b);
    const T value = static_cast<T>(std::is_integral_v<T> ? std::round(mixed) : mixed);
    std::memcpy(out.data() + at, &value, sizeof(T));
  }
}

void blend(VoxelType type, std::span<std::byte> out, std::span<const std::byte> other,
           double weight) {
  with_voxel_type(type, [&]<class T>(T) { blend<T>(out, other, weight); });
}

/// A slice of the volume, from the pixels of one or two frames.
struct SlicePixels {
  FramePixels first, second;
  double weight = 0;
};

class DicomSource : public VolumeSource {
 public:
  /// `images`: the images that `slices` refer to.
  DicomSource(VolumeHeader header, std::vector<Image> images, std::vector<SlicePixels> slices,
              bool reverse, bool fill_missing, uint64_t memory_bytes)
      : header_(std::move(header)),
        images_(std::move(images)),
        slices_(std::move(slices)),
        reverse_(reverse),
        fill_missing_(fill_missing),
        memory_bytes_(memory_bytes) {}

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const Index3 n = header_.grid.voxels;
    const size_t row = static_cast<size_t>(n.x) * voxel_bytes(header_.type);
    const size_t bytes = row * static_cast<size_t>(n.y);
    if (first < 0 || count < 1 || int64_t{first} + count > n.z ||
        out.size() != bytes * static_cast<size_t>(count)) {
      return fail(Status::invalid_argument, "expected a range of slices inside the volume");
    }
    // One child process decodes a batch of compressed slices; a batch has a few MB.
    const auto batch = static_cast<size_t>(std::clamp<size_t>((size_t{16} << 20) / bytes, 1, 64));
    const auto slices =
        std::span(slices_).subspan(static_cast<size_t>(first), static_cast<size_t>(count));
    for (size_t i = 0; i < slices.size(); i += batch) {
      const size_t some = std::min(batch, slices.size() - i);
      const auto to = out.subspan(i * bytes, some * bytes);
      if (auto r = read_batch(slices.subspan(i, some), to); !r) return r;
      for (size_t k = 0; reverse_ && k < some; ++k) reverse_rows(to.subspan(k * bytes, bytes), row);
    }
    return {};
  }

  uint64_t resident_bytes() const override { return 0; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    for (const Image& image : images_) files.emplace_back(image.file);
    return files;
  }

 private:
  Result<void> read_batch(std::span<const SlicePixels> slices, std::span<std::byte> out) {
    std::vector<FramePixels> frames;
    for (const SlicePixels& slice : slices) frames.push_back(slice.first);
    auto read = read_frames(frames, header_.type, fill_missing_, memory_bytes_, out);
    if (!read) return read;
    const size_t bytes = out.size() / slices.size();
    for (size_t i = 0; i < slices.size(); ++i) {
      if (slices[i].weight == 0) continue;
      other_.resize(bytes);
      read =
          read_frames({&slices[i].second, 1}, header_.type, fill_missing_, memory_bytes_, other_);
      if (!read) return read;
      blend(header_.type, out.subspan(i * bytes, bytes), other_, slices[i].weight);
    }
    return {};
  }

  VolumeHeader header_;
  std::vector<Image> images_;
  std::vector<SlicePixels> slices_;
  bool reverse_, fill_missing_;
  uint64_t memory_bytes_;
  std::vector<std::byte> other_;
};

/// "a.txt, b.txt and 3 more".
std::string names_of(const std::vector<std::string>& files) {
  std::string text;
  for (size_t i = 0; i < std::min(files.size(), kMaxNames); ++i) {
    if (i > 0) text += ", ";
    text += std::filesystem::path(files[i]).filename().string();
  }
  if (files.size() > kMaxNames) text += fmt::format(" and {} more", files.size() - kMaxNames);
  return text;
}

/// Checks the chosen frames' files: returns an error, or adds notes.
Result<void> check_images(const Collection& collection, const std::vector<uint32_t>& frames,
                          const std::filesystem::path& path, const ImportOptions& options,
                          std::vector<std::string>& notes) {
  std::vector<std::string> cut_off, surplus;
  std::string assumption;
  uint32_t last = ~uint32_t{0};
  for (const uint32_t index : frames) {
    const uint32_t image_index = collection.frames[index].image;
    if (image_index == last) continue;
    last = image_index;
    const Image& image = collection.images[image_index];
    if (!image.obstacle.empty()) {
      return fail(image.refusal, fmt::format("{}: {}", image.file, image.obstacle));
    }
    if (image.cut_off) cut_off.push_back(image.file);
    if (image.has_surplus) surplus.push_back(image.file);
    if (!image.assumption.empty()) assumption = image.assumption;
  }
  struct Case {
    const std::vector<std::string>& files;
    Allowance allowance;
    Status status;
    const char *what, *done;
  };
  const Case cases[] = {
      {cut_off, Allowance::truncated, Status::truncated, "end before their last pixel",
       "the missing pixels have no value"},
      {surplus, Allowance::surplus, Status::malformed_volume,
       "have more pixels than their header says", "the extra pixels are ignored"},
  };
  for (const Case& c : cases) {
    if (c.files.empty()) continue;
    const std::string text =
        fmt::format("{} of the files {} ({})", c.files.size(), c.what, names_of(c.files));
    if (!options.allowed.has(c.allowance)) {
      return fail(c.status, fmt::format("{}: {}: copy or export them again, or read them with {}",
                                        path.string(), text, flag_of(c.allowance)));
    }
    notes.push_back(fmt::format("{}: {}", text, c.done));
  }
  if (!assumption.empty()) notes.push_back(std::move(assumption));
  return {};
}

/// The padding values of the chosen frames' files, if all files have the same.
std::optional<FillValue> padding_of(const Collection& collection,
                                    const std::vector<uint32_t>& frames, const Values& values,
                                    std::vector<std::string>& notes) {
  const Frame& first = collection.frames[frames[0]];
  const Image& image = collection.images[first.image];
  bool is_same = values.has_one_rescaling, is_any = false;
  for (const uint32_t index : frames) {
    const Image& other = collection.images[collection.frames[index].image];
    is_any = is_any || other.padding;
    is_same =
        is_same && other.padding == image.padding && other.padding_limit == image.padding_limit;
  }
  if (!is_any) return std::nullopt;
  if (!is_same) {
    notes.push_back(
        "the slices have different padding values (Pixel Padding Value): voxels with these values "
        "are kept");
    return std::nullopt;
  }
  const double a = first.intercept + first.slope * *image.padding;
  const double b = first.intercept + first.slope * image.padding_limit.value_or(*image.padding);
  return FillValue{std::min(a, b), std::max(a, b), false};
}

/// Makes a volume from frames.
Result<OpenVolume> open_frames(Collection collection, const std::filesystem::path& path,
                               const ImportOptions& options, std::vector<std::string> notes) {
  const auto stack = choose_stack(collection, path, options, notes);
  if (!stack) return tl::unexpected(stack.error());
  if (auto r = check_images(collection, stack->frames, path, options, notes); !r) {
    return tl::unexpected(r.error());
  }
  auto arranged = arrange(collection, *stack, path, options, notes);
  if (!arranged) return tl::unexpected(arranged.error());

  std::vector<uint32_t> used;
  for (const Plane& plane : arranged->planes) {
    used.push_back(plane.first);
    if (plane.weight > 0) used.push_back(plane.second);
  }
  const Values values = find_values(collection, used);
  if (!values.has_one_rescaling) {
    notes.push_back(
        fmt::format("the slices have different rescale slopes or intercepts (slopes from "
                    "{:.6g} to {:.6g}): each slice's values are computed with its own",
                    values.min_slope, values.greatest_slope));
  }
  const Frame& first = collection.frames[used[0]];
  if (first.is_inverse) {
    notes.push_back(
        "the pixels are MONOCHROME1 (low values are displayed bright): the values are not "
        "inverted");
  }
  HeaderGeometry geometry = arranged->geometry;
  if (options.spacing) geometry.spacing = *options.spacing;
  const Image& image = collection.images[first.image];
  auto orientation =
      orient({image.columns, image.rows, static_cast<int64_t>(arranged->planes.size())}, geometry);
  if (!orientation) {
    return fail(orientation.error().status, path.string() + ": " + orientation.error().message);
  }
  notes.insert(notes.end(), orientation->notes.begin(), orientation->notes.end());

  // Keeps only the images that the volume uses.
  std::vector<uint32_t> new_index(collection.images.size(), ~uint32_t{0});
  std::vector<Image> images;
  for (const uint32_t index : used) {
    uint32_t& at = new_index[collection.frames[index].image];
    if (at != ~uint32_t{0}) continue;
    at = static_cast<uint32_t>(images.size());
    images.push_back(collection.images[collection.frames[index].image]);
  }
  const auto pixels_of = [&](uint32_t index) {
    const Frame& frame = collection.frames[index];
    const bool is_stored = values.slope != 1 || values.intercept != 0;
    return FramePixels{&images[new_index[frame.image]], frame.index, is_stored ? 1 : frame.slope,
                       is_stored ? 0 : frame.intercept};
  };
  std::vector<SlicePixels> slices;
  for (const Plane& plane : arranged->planes) {
    slices.push_back({pixels_of(plane.first), pixels_of(plane.second), plane.weight});
  }
  OpenVolume volume;
  volume.fill_value = padding_of(collection, used, values, notes);
  volume.notes = std::move(notes);
  VolumeHeader header{orientation->grid, values.type,  "DICOM",
                      volume_name(path), values.slope, values.intercept};
  volume.source = std::make_unique<DicomSource>(
      std::move(header), std::move(images), std::move(slices), orientation->reverse_rows,
      options.allowed.has(Allowance::truncated), options.memory_bytes);
  return volume;
}

/// The files of a folder without frames, by reason.
struct IgnoredFiles {
  std::vector<std::string> not_dicom, no_pixels, colour, unreadable;

  /// Handles a file that ends before its pixels. Errors: truncated, unless gaps are allowed.
  Result<void> add_broken(const std::string& file, const ImportOptions& options) {
    if (options.allowed.has(Allowance::gaps)) {
      unreadable.push_back(file);
      return {};
    }
    return fail(Status::truncated,
                fmt::format("{}: expected a slice, found a file that ends before its pixels: copy "
                            "or export it again, or ignore it with {}",
                            file, flag_of(Allowance::gaps)));
  }

  void describe(std::vector<std::string>& notes) const {
    const auto add = [&](const std::vector<std::string>& files, const char* one, const char* many) {
      if (files.empty()) return;
      notes.push_back(fmt::format("{} file{} ignored, which {} ({})", files.size(),
                                  files.size() > 1 ? "s are" : " is", files.size() > 1 ? many : one,
                                  names_of(files)));
    };
    add(not_dicom, "is not DICOM", "are not DICOM");
    add(no_pixels, "has no pixels", "have no pixels");
    add(colour, "is a colour picture", "are colour pictures");
    add(unreadable, "cannot be read", "cannot be read");
  }
};

/// Whether the file's extension is that of DICOM.
bool is_named_dicom(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".dcm" || extension == ".dicom" || extension == ".ima";
}

/// Whether a file ends before DICOM's prefix would, and all its bytes are 0.
bool is_blank(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::file_size(path, error) == 0) return true;
  const auto beginning = read_beginning(path, 256);
  return beginning && beginning->size() < 132 &&
         beginning->find_first_not_of('\0') >= std::min<size_t>(128, beginning->size());
}

/// Whether a file without pixels is incomplete: other files of its SOP class are images, or it ends
/// before its SOP class. Reports, plans and indices have other SOP classes.
bool is_truncated_image(const Collection& collection, const Pixelless& file) {
  return file.sop_class.empty() ||
         std::any_of(collection.images.begin(), collection.images.end(),
                     [&](const Image& image) { return image.sop_class == file.sop_class; });
}

Result<FileContent> add_file(const std::filesystem::path& path, Collection& collection) {
  const auto elements = read_elements(path);
  if (!elements) return tl::unexpected(elements.error());
  return add_frames(*elements, path, collection);
}

}  // namespace

bool is_dicom(const std::filesystem::path& path) {
  const auto beginning = read_beginning(path, 256);
  return beginning && looks_like_dicom(*beginning);
}

Result<OpenVolume> open_dicom_file(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  Collection collection;
  const auto content = add_file(path, collection);
  if (!content) return tl::unexpected(content.error());
  if (*content == FileContent::colour) return not_scalar(path, 3);
  if (*content == FileContent::no_pixels) {
    return fail(
        Status::unsupported_format,
        fmt::format("{}: expected a DICOM image, found one without pixels (a report, a plan, "
                    "an index, …): give the folder of the series",
                    path.string()));
  }
  if (collection.frames.size() < 2) {
    return fail(Status::no_cells,
                fmt::format("{}: expected a volume, found a single DICOM slice: give the folder "
                            "that holds the series",
                            path.string()));
  }
  return open_frames(std::move(collection), path, options, {});
}

Result<OpenVolume> open_dicom_folder(const std::filesystem::path& path,
                                     const ImportOptions& options) {
  Collection collection;
  IgnoredFiles ignored;
  for (const std::filesystem::path& file : files_of_folder(path, {})) {
    const std::string name = file.string();
    if (!is_dicom(file) && !is_named_dicom(file)) {
      if (!is_blank(file)) {
        ignored.not_dicom.push_back(name);
        continue;
      }
      if (auto r = ignored.add_broken(name, options); !r) return tl::unexpected(r.error());
      continue;
    }
    const auto content = add_file(file, collection);
    if (!content) {
      if (!options.allowed.has(Allowance::gaps)) {
        return fail(content.error().status,
                    fmt::format("{} (or ignore unreadable files with {})", content.error().message,
                                flag_of(Allowance::gaps)));
      }
      ignored.unreadable.push_back(name);
    } else if (*content == FileContent::colour) {
      ignored.colour.push_back(name);
    }
  }
  for (const Pixelless& file : collection.without_pixels) {
    if (!is_truncated_image(collection, file)) {
      ignored.no_pixels.push_back(file.file);
    } else if (auto r = ignored.add_broken(file.file, options); !r) {
      return tl::unexpected(r.error());
    }
  }
  std::vector<std::string> notes;
  ignored.describe(notes);
  if (collection.frames.empty()) {
    std::string found = "neither";
    for (const std::string& note : notes) found += "; " + note;
    return fail(Status::unsupported_format,
                fmt::format("{}: expected a folder with DICOM or TIFF slices, found {}: give the "
                            "folder that contains the slices",
                            path.string(), found));
  }
  return open_frames(std::move(collection), path, options, std::move(notes));
}

}  // namespace isosplat
