#include "shared/import/open_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/codecs/file_head.h"
#include "shared/import/dicom/dicom.h"
#include "shared/import/formats.h"
#include "shared/import/hdf5/hdf5.h"
#include "shared/import/images/file.h"
#include "shared/import/images/images.h"
#include "shared/import/known_files.h"
#include "shared/import/npy/npz.h"
#include "shared/import/slices/slice_files.h"
#include "shared/import/tiff/tiff.h"
#include "shared/import/unpacked_volume.h"
#include "shared/import/volume/file_stamps.h"
#include "shared/import/volume/volume_choices.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/missing_values.h"
#include "shared/import/zarr/zarr.h"

namespace isosplat::import {
namespace {

/// The error for a file that no reader supports.
tl::unexpected<Error> unsupported(const FileHead& head) {
  KnownFile known{"no known signature in the file",
                  "save the volume as NRRD or NIfTI (3D Slicer and ITK-SNAP write both), or give "
                  "--dims and --type if the file contains raw voxels"};
  if (auto found = known_file(head.path, head.bytes())) known = std::move(*found);
  return fail(Status::unsupported_format,
              fmt::format("{}: expected {}, found {}: {}", head.path.string(), titles_of_formats(),
                          known.what, known.remedy));
}

using FolderOpener = Result<OpenVolume> (*)(const std::filesystem::path&, const ImportOptions&);

/// The reader of a folder: that of the format whose files are the largest in total, since a DICOM
/// scan may have a few screenshots beside it.
FolderOpener folder_opener(const std::filesystem::path& path) {
  const uint64_t tiff_bytes = total_bytes(files_of_folder(path, {".tif", ".tiff"}));
  const uint64_t image_bytes = image_bytes_of_folder(path);
  if (tiff_bytes == 0 && image_bytes == 0) return open_dicom_folder;
  auto dicoms = files_of_folder(path, {});
  std::erase_if(dicoms, [](const auto& file) { return !is_dicom_file(file); });
  const uint64_t dicom_bytes = total_bytes(dicoms);
  if (dicom_bytes >= std::max(tiff_bytes, image_bytes)) return open_dicom_folder;
  return tiff_bytes >= image_bytes ? open_tiff_folder : open_image_folder;
}

/// The names of a folder's subfolders, in order; hidden ones are left out.
std::vector<std::string> subfolders_of(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const FolderEntry& entry : folder_entries(folder)) {
    const std::string name = entry.path.filename().string();
    if (!name.starts_with('.') && entry.kind == InputKind::folder) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

Result<OpenVolume> open_folder(const std::filesystem::path& path, const ImportOptions& options) {
  if (const auto known = known_folder(path)) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected a folder with slices, found {}: {}", path.string(),
                            known->what, known->remedy));
  }
  return folder_opener(path)(path, options);
}

/// The kind of a file, by its beginning and its name.
struct Kind {
  FileHead head;
  const Format* format = nullptr;  ///< null: none, or unknown until the file is unpacked
  bool must_unpack = false;        ///< before its reader can read it
};

/// `is_raw`: the options describe raw voxels. Errors: those of read_head.
Result<Kind> kind_of_file(const std::filesystem::path& path, bool is_raw) {
  auto head = read_head(path);
  if (!head) return tl::unexpected(head.error());
  if (head->packing != Packing::none && !head->is_gzip()) {
    return Kind{std::move(*head), nullptr, true};
  }
  const Format* format = format_of(*head, is_raw);
  const bool must_unpack = format && head->is_gzip() && !format->reads_gzip;
  return Kind{std::move(*head), format, must_unpack};
}

Result<OpenVolume> open_format(const std::filesystem::path& path, const ImportOptions& options);

/// Opens a file that is compressed as a whole, once.
Result<OpenVolume> open_packed(const FileHead& packed, const ImportOptions& options) {
  const auto check = [&](const std::filesystem::path& unpacked) -> Result<void> {
    const auto kind = kind_of_file(unpacked, options.dims || options.type);
    if (!kind) return tl::unexpected(kind.error());
    if (kind->must_unpack) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected a file that is compressed once, found {} in {}: unpack "
                              "it with {} -d",
                              packed.path.string(), name_of(kind->head.packing),
                              name_of(packed.packing), name_of(packed.packing)));
    }
    if (!kind->format) return unsupported(kind->head);
    return {};
  };
  return open_unpacked(packed.path, packed.packing,
                       {check, [&](const std::filesystem::path& unpacked) {
                          return open_format(unpacked, options);
                        }});
}

/// Opens a volume with the reader of its format.
Result<OpenVolume> open_format(const std::filesystem::path& path, const ImportOptions& options) {
  const bool raw_options =
      options.dims || options.type || options.big_endian || options.skip_bytes > 0;
  if (input_kind(path) == InputKind::folder) {
    if (raw_options) {
      return fail(Status::invalid_argument,
                  fmt::format("{}: --dims, --type, --endian and --skip-bytes are for raw files, "
                              "this is a folder: remove these options",
                              path.string()));
    }
    if (is_zarr(path)) return open_zarr(path, options);
    auto volume = open_folder(path, options);
    if (const auto inside = subfolders_of(path); volume && !inside.empty()) {
      volume->notes.push_back(
          fmt::format("{} subfolder{} not read, such as {}: slices in subfolders are other volumes",
                      inside.size(), inside.size() > 1 ? "s are" : " is", inside.front()));
    }
    return volume;
  }
  const auto kind = kind_of_file(path, options.dims || options.type);
  if (!kind) return tl::unexpected(kind.error());
  if (kind->must_unpack) return open_packed(kind->head, options);
  if (!kind->format) return unsupported(kind->head);
  if (kind->format->has_header && raw_options) {
    return fail(Status::invalid_argument,
                fmt::format("{}: --dims, --type, --endian and --skip-bytes are for raw files, this "
                            "file has a header: remove these options",
                            path.string()));
  }
  return kind->format->open(kind->head, options);
}

}  // namespace

std::string_view format_of_file(const std::filesystem::path& path) {
  const auto kind = kind_of_file(path, false);
  if (!kind) return {};
  if (kind->format) return kind->format->name;
  // A file that must be unpacked first may have any format: opening it determines the format.
  return kind->must_unpack ? "compressed" : image_format_of(kind->head.bytes());
}

std::string_view packing_of_file(const std::filesystem::path& path) {
  const auto kind = kind_of_file(path, false);
  return kind && kind->must_unpack ? name_of(kind->head.packing) : std::string_view{};
}

Result<OpenVolume> open_volume(const std::filesystem::path& path, const ImportOptions& options) {
  const FileStamps before = FileStamps::of({path});
  offer(options, {});
  auto volume = open_format(path, options);
  if (!volume) {
    offer_allowance(options, volume.error().message);
    return volume;
  }
  if (auto same = before.check(); !same) return tl::unexpected(same.error());
  const VolumeHeader& header = volume->source->header();
  const Index3 n = header.grid.voxels;
  if (const uint64_t slice = volume_bytes({n.x, n.y, 1}, voxel_bytes(header.type));
      slice > std::numeric_limits<size_t>::max() / 4) {
    return fail(Status::volume_too_large,
                fmt::format("{}: expected slices of less than 1 GiB, found {} × {} voxels of type "
                            "{}: build the store with the program (isosplat build), which has more "
                            "memory than a browser",
                            path.string(), n.x, n.y, voxel_type_name(header.type)));
  }
  volume->source = watch_files(std::move(volume->source));
  return with_missing_values(std::move(*volume), options);
}

Result<std::vector<SegmentMap>> open_segments(const std::filesystem::path& path,
                                              const ImportOptions& options) {
  const bool is_read = input_kind(path) == InputKind::folder
                           ? !known_folder(path) && folder_opener(path) == open_dicom_folder
                           : format_of_file(path) == "DICOM";
  if (!is_read) return std::vector<SegmentMap>{};
  const FileStamps before = FileStamps::of({path});
  auto maps = open_dicom_segments(path, options);
  if (!maps) return maps;
  if (auto same = before.check(); !same) return tl::unexpected(same.error());
  for (SegmentMap& map : *maps) map.volume.source = watch_files(std::move(map.volume.source));
  return maps;
}

Result<std::vector<VolumeChoice>> volumes_in_file(const std::filesystem::path& path) {
  std::vector<VolumeChoice> volumes;
  const InputKind input = input_kind(path);
  if (input == InputKind::folder) {
    const FolderOpener opener = folder_opener(path);
    if (opener == open_tiff_folder) return tiff_volumes(path);
    return opener == open_dicom_folder ? dicom_volumes(path) : volumes;
  }
  const std::string_view format = format_of_file(path);
  if (format == "DICOM") return dicom_volumes(path);
  if (format == "TIFF") return tiff_volumes(path);
  if (format != "HDF5" && format != "NumPy archive") return volumes;
  auto datasets = format == "HDF5" ? hdf5_datasets(path) : npz_datasets(path);
  if (!datasets) return tl::unexpected(datasets.error());
  if (datasets->size() < 2) return volumes;
  for (std::string& each : *datasets) {
    VolumeChoice choice;
    choice.label = each;
    choice.dataset = std::move(each);
    volumes.push_back(std::move(choice));
  }
  return volumes;
}

}  // namespace isosplat::import
