#include "shared/import/open_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/codecs/packing.h"
#include "shared/import/dicom/dicom.h"
#include "shared/import/hdf5/hdf5.h"
#include "shared/import/images/file.h"
#include "shared/import/images/images.h"
#include "shared/import/known_files.h"
#include "shared/import/meta_image/meta_image.h"
#include "shared/import/mrc/mrc.h"
#include "shared/import/nifti/nifti.h"
#include "shared/import/npy/npy.h"
#include "shared/import/nrrd/nrrd.h"
#include "shared/import/raw/raw.h"
#include "shared/import/slices/slice_files.h"
#include "shared/import/text/header_text.h"
#include "shared/import/tiff/tiff.h"
#include "shared/import/unpacked_volume.h"
#include "shared/import/volume/file_stamps.h"
#include "shared/import/volume/volume_choices.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/missing_values.h"
#include "shared/import/vtk/vtk.h"

namespace isosplat {
namespace {

using Opener = Result<OpenVolume> (*)(const std::filesystem::path&, const ImportOptions&);

/// Selects the reader by a file's first bytes; null if they have no known signature.
Opener opener_for(std::string_view beginning) {
  using namespace std::string_view_literals;
  // Before TIFF: a DICOM file may begin with a TIFF header (PS3.10, 7.1).
  if (beginning.size() > 132 && beginning.substr(128, 4) == "DICM") return open_dicom_file;
  if (beginning.starts_with("NRRD000")) return open_nrrd;
  if (beginning.starts_with("\x93NUMPY")) return open_npy;
  if (is_hdf5(beginning)) return open_hdf5;
  if (beginning.starts_with("CDF\1") || beginning.starts_with("CDF\2") ||
      beginning.starts_with("CDF\5")) {
    return refuse_netcdf_classic;
  }
  if (beginning.starts_with("# vtk DataFile")) return open_vtk_legacy;
  if (beginning.starts_with("II*\0"sv) || beginning.starts_with("MM\0*"sv) ||
      beginning.starts_with("II+\0"sv) || beginning.starts_with("MM\0+"sv)) {
    return open_tiff_file;
  }
  if (beginning.size() >= 348 &&
      (beginning.substr(344, 4) == "n+1\0"sv || beginning.substr(344, 4) == "ni1\0"sv)) {
    return open_nifti;
  }
  if (beginning.size() >= 12 && (beginning.substr(4, 8) == "n+2\0\r\n\032\n"sv ||
                                 beginning.substr(4, 8) == "ni2\0\r\n\032\n"sv)) {
    return open_nifti;
  }
  if (is_mrc(beginning, false)) return open_mrc;
  const std::string_view text = beginning.substr(0, std::min<size_t>(beginning.size(), 4096));
  if (text.find("ElementDataFile") != text.npos || text.find("NDims") != text.npos) {
    return open_meta_image;
  }
  return nullptr;
}

/// The first bytes of a file, decompressed if it is gzip data. Nothing if it cannot be read.
std::optional<std::string> expanded_beginning(const std::filesystem::path& path) {
  auto bytes = is_gzip(path) ? open_deflated(path) : open_plain(path);
  if (!bytes) return std::nullopt;
  const auto some = (*bytes)->count_after(0, 4096);
  std::string text(static_cast<size_t>(some.value_or(540)), '\0');
  if (!(*bytes)->read(0, std::as_writable_bytes(std::span(text)))) return std::nullopt;
  return text;
}

/// Whether the name is one of MRC: such files from before 2000 have no signature.
bool has_mrc_name(std::string_view lower_name) {
  if (lower_name.ends_with(".gz")) lower_name.remove_suffix(3);
  for (const char* suffix : {".mrc", ".map", ".rec", ".st", ".ccp4"}) {
    if (lower_name.ends_with(suffix)) return true;
  }
  return false;
}

/// Whether a file with voxels has the header of a pair beside it.
bool has_nifti_header(const std::filesystem::path& voxels) {
  std::filesystem::path header = voxels;
  if (lower_case(header.extension().string()) == ".gz") header.replace_extension();
  if (lower_case(header.extension().string()) != ".img") return false;
  for (const char* extension : {".hdr", ".HDR", ".hdr.gz"}) {
    header.replace_extension(extension);
    const auto beginning = expanded_beginning(header);
    if (beginning && opener_for(*beginning) == open_nifti) return true;
  }
  return false;
}

constexpr const char* kFormats =
    "NRRD, MetaImage, NIfTI, MRC, NumPy, HDF5, DICOM, TIFF or legacy VTK";

/// The error for a file that no reader takes. `beginning`: its first bytes, decompressed.
tl::unexpected<Error> unsupported(const std::filesystem::path& path, std::string_view beginning) {
  KnownFile known{"no known signature in the file",
                  "save the volume as NRRD or NIfTI (3D Slicer and ITK-SNAP write both), or give "
                  "--dims and --type if the file contains raw voxels"};
  if (auto found = known_file(path, beginning)) known = std::move(*found);
  return fail(Status::unsupported_format,
              fmt::format("{}: expected {}, found {}: {}", path.string(), kFormats, known.what,
                          known.remedy));
}

/// The reader of a folder: that of the format whose files are the largest in total. A DICOM scan
/// may have a few screenshots beside it.
Opener folder_opener(const std::filesystem::path& path) {
  const uint64_t tiff_bytes = total_bytes(files_of_folder(path, {".tif", ".tiff"}));
  const uint64_t image_bytes = image_bytes_of_folder(path);
  if (tiff_bytes == 0 && image_bytes == 0) return open_dicom_folder;
  auto dicoms = files_of_folder(path, {});
  std::erase_if(dicoms, [](const auto& file) { return !is_dicom(file); });
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

/// The reader of a file.
struct Choice {
  Opener opener = nullptr;          ///< null: none
  bool has_header = false;          ///< and so takes no options for raw files
  Packing packing = Packing::none;  ///< what must be removed before the reader can read the file
  std::string beginning = {};       ///< the first bytes, decompressed if they are gzip data
};

/// Chooses the reader. `is_raw`: the options say what raw voxels it has. Errors: io_error.
Result<Choice> choose_opener(const std::filesystem::path& path, bool is_raw) {
  auto beginning = read_beginning(path, 4096);
  if (!beginning) return tl::unexpected(beginning.error());
  const Packing packing = packing_of(*beginning);
  if (packing != Packing::none && packing != Packing::gzip) {
    return Choice{nullptr, false, packing, std::move(*beginning)};
  }
  Opener opener = opener_for(*beginning);
  const std::string name = lower_case(path.filename().string());
  if (packing == Packing::gzip) {
    // The content decides, not the file's name.
    auto inside = expanded_beginning(path);
    opener = inside ? opener_for(*inside) : nullptr;
    if (!opener && inside && !is_raw && has_mrc_name(name) && is_mrc(*inside, true)) {
      opener = open_mrc;
    }
    if (opener && opener != open_nifti && opener != open_mrc) {
      return Choice{opener, true, packing, std::move(*inside)};
    }
    if (inside) beginning = std::move(*inside);
  }
  if (!opener && (name.ends_with(".nii.gz") || name.ends_with(".nii")) &&
      !known_file(path, *beginning)) {
    opener = open_nifti;
  }
  if (!opener && has_nifti_header(path)) opener = open_nifti;
  if (!opener && !is_raw && has_mrc_name(name) && is_mrc(*beginning, true)) opener = open_mrc;
  const bool has_header = opener != nullptr;
  if (!opener && (is_raw || raw_name_is_complete(path) || name.ends_with(".raw") ||
                  name.ends_with(".raw.gz"))) {
    opener = open_raw;
  }
  // Without the prefix "DICM".
  if (!opener && packing == Packing::none && is_dicom(path)) opener = open_dicom_file;
  return Choice{opener, has_header, Packing::none, std::move(*beginning)};
}

Result<OpenVolume> open_format(const std::filesystem::path& path, const ImportOptions& options);

/// Opens a file that is compressed as a whole, once.
Result<OpenVolume> open_packed(const std::filesystem::path& path, Packing packing,
                               const ImportOptions& options) {
  const auto check = [&](const std::filesystem::path& unpacked) -> Result<void> {
    auto choice = choose_opener(unpacked, options.dims || options.type);
    if (!choice) return tl::unexpected(choice.error());
    if (choice->packing != Packing::none) {
      return fail(
          Status::unsupported_format,
          fmt::format("{}: expected a file that is compressed once, found {} in {}: unpack "
                      "it with {} -d",
                      path.string(), name_of(choice->packing), name_of(packing), name_of(packing)));
    }
    if (!choice->opener) return unsupported(unpacked, choice->beginning);
    return {};
  };
  return open_unpacked(path, packing, {check, [&](const std::filesystem::path& unpacked) {
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
    auto volume = open_folder(path, options);
    if (const auto inside = subfolders_of(path); volume && !inside.empty()) {
      volume->notes.push_back(
          fmt::format("{} subfolder{} not read, such as {}: slices in subfolders are other volumes",
                      inside.size(), inside.size() > 1 ? "s are" : " is", inside.front()));
    }
    return volume;
  }
  const auto choice = choose_opener(path, options.dims || options.type);
  if (!choice) return tl::unexpected(choice.error());
  if (const auto size = size_of_file(path); !size) return tl::unexpected(size.error());
  if (choice->packing != Packing::none) return open_packed(path, choice->packing, options);
  if (choice->has_header && raw_options) {
    return fail(Status::invalid_argument,
                fmt::format("{}: --dims, --type, --endian and --skip-bytes are for raw files, this "
                            "file has a header: remove these options",
                            path.string()));
  }
  const Opener opener = choice->opener;
  if (!opener) return unsupported(path, choice->beginning);
  return opener(path, options);
}

}  // namespace

std::string_view format_of_file(const std::filesystem::path& path) {
  constexpr struct {
    Opener opener;
    std::string_view name;
  } kNames[] = {{open_nrrd, "NRRD"},      {open_meta_image, "MetaImage"},
                {open_nifti, "NIfTI"},    {open_vtk_legacy, "VTK"},
                {open_mrc, "MRC"},        {open_npy, "NumPy"},
                {open_hdf5, "HDF5"},      {refuse_netcdf_classic, "netCDF"},
                {open_tiff_file, "TIFF"}, {open_dicom_file, "DICOM"},
                {open_raw, "raw"}};
  const auto choice = choose_opener(path, false);
  if (!choice) return {};
  // A file that must be unpacked first may be anything: its opening says what it is.
  if (choice->packing != Packing::none && !choice->opener) return "compressed";
  for (const auto& [opener, name] : kNames) {
    if (choice->opener == opener) return name;
  }
  return image_format_of(choice->beginning);
}

std::string_view packing_of_file(const std::filesystem::path& path) {
  const auto choice = choose_opener(path, false);
  return choice ? name_of(choice->packing) : std::string_view{};
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

Result<std::vector<VolumeChoice>> volumes_in_file(const std::filesystem::path& path) {
  std::vector<VolumeChoice> volumes;
  if (input_kind(path) == InputKind::file && format_of_file(path) == "HDF5") {
    auto datasets = hdf5_datasets(path);
    if (!datasets) return tl::unexpected(datasets.error());
    if (datasets->size() < 2) return volumes;
    for (std::string& each : *datasets) {
      VolumeChoice choice;
      choice.label = each;
      choice.dataset = std::move(each);
      volumes.push_back(std::move(choice));
    }
  }
  const bool is_folder = input_kind(path) == InputKind::folder;
  if (is_folder ? folder_opener(path) == open_tiff_folder : format_of_file(path) == "TIFF") {
    return tiff_volumes(path);
  }
  return volumes;
}

}  // namespace isosplat
