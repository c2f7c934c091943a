#include "shared/import/formats.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <vector>

#include "shared/import/cube/cube.h"
#include "shared/import/dicom/dicom.h"
#include "shared/import/hdf5/hdf5.h"
#include "shared/import/known_files.h"
#include "shared/import/meta_image/meta_image.h"
#include "shared/import/mgh/mgh.h"
#include "shared/import/mrc/mrc.h"
#include "shared/import/netcdf/netcdf.h"
#include "shared/import/nifti/nifti.h"
#include "shared/import/npy/npy.h"
#include "shared/import/npy/npz.h"
#include "shared/import/nrrd/nrrd.h"
#include "shared/import/opendx/opendx.h"
#include "shared/import/raw/raw.h"
#include "shared/import/text/header_text.h"
#include "shared/import/tiff/tiff.h"
#include "shared/import/vasp/vasp.h"
#include "shared/import/vtk/vtk.h"
#include "shared/import/vtk_xml/vtk_xml.h"
#include "shared/import/xsf/xsf.h"

namespace isosplat::import {
namespace {

using namespace std::string_view_literals;

/// Adapts a reader that opens a file by its path.
template <Result<OpenVolume> (*Open)(const std::filesystem::path&, const ImportOptions&)>
Result<OpenVolume> by_path(const FileHead& head, const ImportOptions& options) {
  return Open(head.path, options);
}

/// Whether the beginning is one of these.
template <size_t N>
bool starts_with_any(std::string_view head, const std::array<std::string_view, N>& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&](std::string_view each) { return head.starts_with(each); });
}

bool begins_dicom(std::string_view head) {
  return head.size() > 132 && head.substr(128, 4) == "DICM";
}

bool begins_nrrd(std::string_view head) {
  return head.starts_with("NRRD000");
}

bool begins_npy(std::string_view head) {
  return head.starts_with("\x93NUMPY");
}

bool begins_vtk(std::string_view head) {
  return head.starts_with("# vtk DataFile");
}

bool begins_tiff(std::string_view head) {
  return starts_with_any(head, std::array{"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv});
}

bool begins_nifti(std::string_view head) {
  if (head.size() >= 348 &&
      (head.substr(344, 4) == "n+1\0"sv || head.substr(344, 4) == "ni1\0"sv)) {
    return true;
  }
  return head.size() >= 12 &&
         (head.substr(4, 8) == "n+2\0\r\n\032\n"sv || head.substr(4, 8) == "ni2\0\r\n\032\n"sv);
}

bool begins_mrc(std::string_view head) {
  return is_mrc(head, false);
}

bool begins_meta_image(std::string_view head) {
  return head.find("ElementDataFile") != head.npos || head.find("NDims") != head.npos;
}

std::string lower_name(const FileHead& head) {
  return lower_case(head.path.filename().string());
}

/// Whether a file with voxels has the header of a pair beside it.
bool has_nifti_header(const std::filesystem::path& voxels) {
  std::filesystem::path header = voxels;
  if (lower_case(header.extension().string()) == ".gz") header.replace_extension();
  if (lower_case(header.extension().string()) != ".img") return false;
  for (const char* extension : {".hdr", ".HDR", ".hdr.gz"}) {
    header.replace_extension(extension);
    const auto head = read_head(header);
    if (head && begins_nifti(head->bytes())) return true;
  }
  return false;
}

bool is_named_nifti(const FileHead& head, bool /*is_raw*/) {
  const std::string name = lower_name(head);
  if ((name.ends_with(".nii.gz") || name.ends_with(".nii")) &&
      !known_file(head.path, head.bytes())) {
    return true;
  }
  return has_nifti_header(head.path);
}

/// Files of MRC from before 2000 have no signature, so their names decide.
bool is_named_mrc(const FileHead& head, bool is_raw) {
  if (is_raw) return false;
  std::string name = lower_name(head);
  if (name.ends_with(".gz")) name.resize(name.size() - 3);
  constexpr std::array kSuffixes{".mrc"sv, ".map"sv, ".rec"sv, ".st"sv, ".ccp4"sv};
  const bool is_named =
      std::any_of(kSuffixes.begin(), kSuffixes.end(),
                  [&](std::string_view suffix) { return name.ends_with(suffix); });
  return is_named && is_mrc(head.bytes(), true);
}

/// The format has no signature, so names decide.
bool is_named_mgh(const FileHead& head, bool /*is_raw*/) {
  const std::string name = lower_name(head);
  return (name.ends_with(".mgh") || name.ends_with(".mgz") || name.ends_with(".mgh.gz")) &&
         is_mgh(head.bytes(), true);
}

/// Recognizes a text by its first lines.
template <bool (*Begins)(std::string_view)>
bool resembles(const FileHead& head) {
  return Begins(head.bytes());
}

bool resembles_mgh(const FileHead& head) {
  return is_mgh(head.bytes(), false);
}

bool is_named_raw(const FileHead& head, bool is_raw) {
  if (is_raw) return true;
  const std::string name = lower_name(head);
  return raw_name_is_complete(head.path) || name.ends_with(".raw") || name.ends_with(".raw.gz");
}

/// Recognizes DICOM data sets without the prefix "DICM".
bool resembles_dicom(const FileHead& head) {
  return head.packing == Packing::none && is_dicom(head.stored);
}

/// In the order in which a file's first bytes are compared. DICOM precedes TIFF, since a DICOM file
/// may begin with a TIFF header (PS3.10, 7.1). MetaImage has no signature; it is recognized by
/// words in its header.
constexpr Format kFormats[] = {
    {.name = "DICOM",
     .title = "DICOM",
     .title_rank = 9,
     .begins = begins_dicom,
     .resembles = resembles_dicom,
     .open = by_path<open_dicom_file>},
    {.name = "NRRD",
     .title = "NRRD",
     .title_rank = 1,
     .begins = begins_nrrd,
     .open = by_path<open_nrrd>},
    {.name = "NumPy",
     .title = "NumPy",
     .title_rank = 6,
     .begins = begins_npy,
     .open = by_path<open_npy>},
    {.name = "NumPy archive", .begins = is_npz, .open = by_path<open_npz>},
    {.name = "HDF5",
     .title = "HDF5",
     .title_rank = 7,
     .begins = is_hdf5,
     .open = by_path<open_hdf5>},
    {.name = "netCDF",
     .title = "netCDF",
     .title_rank = 8,
     .begins = is_netcdf,
     .open = by_path<open_netcdf>},
    {.name = "VTK",
     .title = "legacy VTK",
     .title_rank = 11,
     .begins = begins_vtk,
     .open = by_path<open_vtk_legacy>},
    {.name = "VTK XML",
     .title = "VTK XML images",
     .title_rank = 12,
     .begins = is_vtk_xml,
     .open = by_path<open_vtk_xml>},
    {.name = "TIFF",
     .title = "TIFF",
     .title_rank = 10,
     .begins = begins_tiff,
     .open = by_path<open_tiff_file>},
    {.name = "NIfTI",
     .title = "NIfTI",
     .title_rank = 3,
     .reads_gzip = true,
     .begins = begins_nifti,
     .is_named = is_named_nifti,
     .open = open_nifti},
    {.name = "MRC",
     .title = "MRC",
     .title_rank = 5,
     .reads_gzip = true,
     .begins = begins_mrc,
     .is_named = is_named_mrc,
     .open = open_mrc},
    {.name = "MGH",
     .title = "MGH",
     .title_rank = 4,
     .reads_gzip = true,
     .is_named = is_named_mgh,
     .resembles = resembles_mgh,
     .open = open_mgh},
    {.name = "OpenDX",
     .title = "OpenDX",
     .title_rank = 16,
     .begins = is_opendx,
     .open = by_path<open_opendx>},
    {.name = "XSF", .title = "XSF", .title_rank = 15, .begins = is_xsf, .open = by_path<open_xsf>},
    {.name = "cube",
     .title = "cube",
     .title_rank = 13,
     .resembles = resembles<is_cube>,
     .open = by_path<open_cube>},
    {.name = "VASP",
     .title = "VASP",
     .title_rank = 14,
     .resembles = resembles<is_vasp>,
     .open = by_path<open_vasp>},
    {.name = "MetaImage",
     .title = "MetaImage",
     .title_rank = 2,
     .begins = begins_meta_image,
     .open = by_path<open_meta_image>},
    {.name = "raw",
     .reads_gzip = true,
     .has_header = false,
     .is_named = is_named_raw,
     .open = open_raw},
};

}  // namespace

const Format* format_of(const FileHead& head, bool is_raw) {
  const auto first = [](auto&& is_it) {
    const Format* found = std::find_if(std::begin(kFormats), std::end(kFormats), is_it);
    return found == std::end(kFormats) ? nullptr : found;
  };
  const Format* found =
      first([&](const Format& each) { return each.begins && each.begins(head.bytes()); });
  if (!found) {
    found = first([&](const Format& each) { return each.is_named && each.is_named(head, is_raw); });
  }
  if (!found) {
    found = first([&](const Format& each) { return each.resembles && each.resembles(head); });
  }
  return found;
}

std::string titles_of_formats() {
  std::vector<const Format*> listed;
  for (const Format& each : kFormats) {
    if (!each.title.empty()) listed.push_back(&each);
  }
  std::sort(listed.begin(), listed.end(),
            [](const Format* a, const Format* b) { return a->title_rank < b->title_rank; });
  std::string text;
  for (const Format* each : listed) {
    if (!text.empty()) text += each == listed.back() ? " or " : ", ";
    text += each->title;
  }
  return text;
}

}  // namespace isosplat::import
