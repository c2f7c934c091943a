#include "shared/import/known_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <vector>

#include "shared/import/bytes/input_files.h"
#include "shared/import/codecs/packing.h"
#include "shared/import/images/file.h"
#include "shared/import/text/commands.h"
#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

using namespace std::string_view_literals;

/// In remedies: {0} is the file, {1} its name without suffix, each as words of a command line.
constexpr const char* kBioFormats =
    "convert one channel with the command line tools of Bio-Formats: bfconvert -series 0 "
    "-channel 0 -timepoint 0 {0} {1}.ome.tif (or open it in Fiji and save it as TIFF)";
constexpr const char* kMesh = "give the volume from which it was computed";
constexpr const char* kUnpack = "unpack it with {2} {0}, and give the volume in it";
constexpr const char* kFromFiji = "open it in Fiji, and save it with File > Save As > Nrrd";
constexpr const char* kNoVolume = "give a volume";
constexpr const char* kMetaImageOfParaView =
    "in ParaView resample it with Filters > Resample To Image, and save the data as MetaImage "
    "(.mhd)";

struct Signature {
  size_t offset;
  std::string_view bytes;
  const char* what;
  const char* remedy;
  const char* command = "";  ///< {2} of kUnpack
};

constexpr Signature kSignatures[] = {
    {0, "\x89ISOS\r\n\x1a"sv, "a store", "open it with isosplat view, info or serve"},
    {0, "version https://git-lfs.github.com/spec/"sv,
     "a pointer of Git LFS, which stands for the file",
     "get the file with git lfs pull --include {0}"},
    {0, "MATLAB 5.0 MAT-file"sv, "a MATLAB file of version 5 to 7",
     "save its first array for NumPy with python3 -c \"import sys, numpy, scipy.io; "
     "m = scipy.io.loadmat(sys.argv[1]); "
     "numpy.save(sys.argv[2], next(m[k] for k in m if k[0] != '_'))\" {0} {1}.npy"},
    {0, "ZISRAWFILE"sv, "Zeiss CZI", kBioFormats},
    {0, "\xda\xce\xbe\x0a"sv, "Nikon ND2", kBioFormats},
    {0, "OLYMPUSRAWFORMAT"sv, "Olympus OIR", kBioFormats},
    {0, "\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"sv,
     "a Microsoft compound file (Olympus OIB, Zeiss ZVI, or a document)", kBioFormats},
    {96, "\xa0\xc0"sv, "DeltaVision", kBioFormats},
    {96, "\xc0\xa0"sv, "DeltaVision", kBioFormats},
    {0, "GIF8"sv, "a GIF image", "convert its pictures to PNG files in a folder, and give that"},
    {0, "%PDF"sv, "a PDF document", kNoVolume},
    {0, "%!PS"sv, "a PostScript document", kNoVolume},
    {0, "{\\rtf"sv, "a document", kNoVolume},
    {0, "7z\xbc\xaf\x27\x1c"sv, "a 7-Zip archive", kUnpack, "7z x"},
    {0, "Rar!\x1a\x07"sv, "a RAR archive", kUnpack, "unrar x"},
    {257, "ustar"sv, "a tar archive", kUnpack, "tar -xf"},
    {0, "\x04\x22\x4d\x18"sv, "LZ4-compressed data", kUnpack, "lz4 -d"},
    {0, "\x1f\x9d"sv, "data compressed by the program compress", kUnpack, "uncompress"},
    {0, "LZIP"sv, "lzip-compressed data", kUnpack, "lzip -d"},
    {0, "\x5d\0\0"sv, "LZMA-compressed data", kUnpack, "xz -d --format=lzma"},
    {0, "# AmiraMesh"sv, "an Amira file", kFromFiji},
    {0, "# Avizo"sv, "an Avizo file", kFromFiji},
    {0, "SIMPLE  ="sv, "FITS",
     "save its image for NumPy with python3 -c \"import sys, numpy; from astropy.io import fits; "
     "numpy.save(sys.argv[2], fits.getdata(sys.argv[1]))\" {0} {1}.npy"},
    {0, " BDV\0\0\0\0"sv, "OpenVDB", kMetaImageOfParaView},
    {0, "\0\0\0\3\0"sv, "Gatan DM3", "convert it with IMOD: dm2mrc {0} {1}.mrc"},
    {0, "\0\0\0\4\0\0\0\0"sv, "Gatan DM4", "convert it with IMOD: dm2mrc {0} {1}.mrc"},
    {0, "\xc3\x40\xf1"sv, "SEG-Y",
     "save it for NumPy with python3 -c \"import sys, numpy, segyio; "
     "numpy.save(sys.argv[2], segyio.tools.cube(sys.argv[1]))\" {0} {1}.npy"},
    {0, "!INTERFILE"sv, "an Interfile header",
     "give its data file with --dims, --type and --spacing"},
    {0, "ENVI"sv, "an ENVI header", "give its data file with --dims, --type and --spacing"},
    {0, "solid "sv, "a mesh (STL)", kMesh},
    {0, "ply\n"sv, "a mesh or point cloud (PLY)", kMesh},
    {0, "ply\r\n"sv, "a mesh or point cloud (PLY)", kMesh},
    {0, "OFF\n"sv, "a mesh (OFF)", kMesh},
    {0, "glTF"sv, "a mesh (glTF)", kMesh},
    {0, "LASF"sv, "a point cloud (LAS)", kNoVolume},
    {0, "SQLite format 3"sv, "a database", kNoVolume},
    {0, "RIFF"sv, "a sound, video or WebP image", kNoVolume},
    {4, "ftyp"sv, "a video or photograph", kNoVolume},
    {0, "\x1a\x45\xdf\xa3"sv, "a video", kNoVolume},
    {0,
     "\x7f"
     "ELF"sv,
     "a program", kNoVolume},
};

struct Suffix {
  std::string_view suffix;
  const char* what;
  const char* remedy;
};

/// Files that are recognized only by their names.
constexpr Suffix kSuffixes[] = {
    {".mnc", "MINC", "convert it with nibabel: nib-convert {0} {1}.nii.gz"},
    {".obj", "a mesh", kMesh},
    {".img", "the voxels of a pair without a valid NIfTI .hdr",
     "give it with --dims, --type and --spacing, or put the .hdr beside it"},
    {".hdr",
     "an ANALYZE header, which does not distinguish left from right, or an ENVI or other header",
     "convert it to NIfTI with a program that knows its orientation (SPM, FSL)"},
};

KnownFile made(const char* what, const char* remedy, const std::filesystem::path& path,
               const char* command = "") {
  std::filesystem::path stem = unpacked_name(path).stem();
  return {what, fmt::format(fmt::runtime(remedy), shell_word(path), shell_word(stem), command)};
}

/// Distinguishes a header, which is text, from a JPEG that contains "ISO".
bool is_text(std::string_view bytes) {
  return !bytes.empty() && std::all_of(bytes.begin(), bytes.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\r' || c == '\t';
  });
}

/// The beginning of a text without a byte order mark and white space, in lower case.
std::string plain_beginning(std::string_view bytes) {
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);
  const size_t at = bytes.find_first_not_of(" \t\r\n");
  return at == bytes.npos ? std::string() : lower_case(bytes.substr(at));
}

std::optional<KnownFile> known_xml(const std::filesystem::path& path, std::string_view lower) {
  const auto has = [&](std::string_view part) { return lower.find(part) != lower.npos; };
  if (lower.starts_with("<!doctype html") || lower.starts_with("<html") ||
      lower.starts_with("<head") || (lower.starts_with("<?xml") && has("<html"))) {
    return KnownFile{"a web page",
                     "the address of the download leads to a page; download the file itself"};
  }
  if (!lower.starts_with("<?xml") && !lower.starts_with("<vtkfile") &&
      !lower.starts_with("<spimdata") && !lower.starts_with("<svg")) {
    return std::nullopt;
  }
  if (has("\"vtkoverlappingamr\"") || has("\"vtkhierarchicalboxdataset\"")) {
    return KnownFile{"an adaptive grid of VTK's XML format",
                     "isosplat build makes a scene of it, with a store for each refinement level"};
  }
  constexpr const char* kScene =
      "isosplat build makes a scene of it, resampled to an adaptive grid";
  if (has("\"unstructuredgrid\"") || has("\"punstructuredgrid\"")) {
    return KnownFile{"an unstructured grid of VTK's XML format", kScene};
  }
  if (has("\"structuredgrid\"") || has("\"pstructuredgrid\"")) {
    return KnownFile{"a curvilinear grid of VTK's XML format", kScene};
  }
  if (has("<vtkfile"))
    return made("a grid or mesh of VTK's XML format", kMetaImageOfParaView, path);
  if (has("<spimdata")) {
    return KnownFile{"the XML file of a BigDataViewer image", "give the .h5 file beside it"};
  }
  if (has("<error") && has("<code")) {
    return KnownFile{"an error message of a storage host", "download the file again"};
  }
  if (has("<svg")) return KnownFile{"a drawing (SVG)", kNoVolume};
  return KnownFile{"an XML file", "give the file that it describes"};
}

std::optional<KnownFile> known_text(const std::filesystem::path& path, std::string_view bytes) {
  if (!is_text(bytes)) return std::nullopt;
  const std::string lower = plain_beginning(bytes);
  if (auto xml = known_xml(path, lower)) return xml;
  const std::string name = path.filename().string();
  if (name == ".zattrs" || name == ".zgroup" || name == ".zarray" || name == "zarr.json") {
    return KnownFile{"metadata of Zarr", "give the folder that it is in"};
  }
  std::string line(trimmed(bytes.substr(0, std::min<size_t>(bytes.find('\n'), 60))));
  return KnownFile{fmt::format("a text that begins with \"{}\"", line), "give a volume"};
}

std::optional<KnownFile> known_zip(const std::filesystem::path& path, std::string_view bytes) {
  if (!bytes.starts_with("PK\3\4") && !bytes.starts_with("PK\5\6")) return std::nullopt;
  return made("a ZIP archive", "unpack it with unzip {0} -d {1}, and give the volume in it", path);
}

/// A DICOMDIR has its UID in its first elements.
bool is_dicomdir(std::string_view bytes) {
  return bytes.size() > 132 && bytes.substr(128, 4) == "DICM" &&
         bytes.substr(0, 512).find("1.2.840.10008.1.3.10"sv) != bytes.npos;
}

/// Leica's LIF: 0x70, the size of a part, '*', the size of a text in UTF-16.
bool is_lif(std::string_view bytes) {
  return bytes.size() > 16 && bytes.starts_with("\x70\0\0\0"sv) && bytes[8] == '*' &&
         bytes.substr(13, 2) == "<\0"sv;
}

}  // namespace

std::optional<KnownFile> known_file(const std::filesystem::path& path, std::string_view beginning) {
  if (is_dicomdir(beginning)) {
    const auto folder = path.parent_path();
    return KnownFile{"the directory of a DICOM medium (DICOMDIR)",
                     fmt::format("give the folder of a series beside it, in {}",
                                 shell_word(folder.empty() ? "." : folder))};
  }
  if (is_lif(beginning)) return made("Leica LIF", kBioFormats, path);
  if (const auto format = image_format_of(beginning); !format.empty()) {
    return KnownFile{fmt::format("a single image ({})", format),
                     "give the folder with all slices of the volume"};
  }
  if (auto zip = known_zip(path, beginning)) return zip;
  const std::string suffix = lower_case(unpacked_name(path).extension().string());
  for (const Suffix& known : kSuffixes) {
    if (known.suffix == suffix || known.suffix == lower_case(path.extension().string())) {
      return made(known.what, known.remedy, path);
    }
  }
  for (const Signature& known : kSignatures) {
    if (beginning.size() >= known.offset + known.bytes.size() &&
        beginning.substr(known.offset, known.bytes.size()) == known.bytes) {
      return made(known.what, known.remedy, path, known.command);
    }
  }
  return known_text(path, beginning);
}

std::optional<KnownFile> known_folder(const std::filesystem::path& path) {
  std::vector<std::string> folders;
  bool has_files = false;
  for (const FolderEntry& entry : folder_entries(path)) {
    const std::string name = entry.path.filename().string();
    if (name.starts_with('.')) continue;
    if (entry.kind == InputKind::folder) folders.push_back(name);
    if (entry.kind == InputKind::file) has_files = true;
  }
  if (has_files) return std::nullopt;
  if (folders.empty()) return KnownFile{"an empty folder", "give the folder that has the slices"};
  std::sort(folders.begin(), folders.end());
  return KnownFile{fmt::format("a folder with {} folder{} and no files", folders.size(),
                               folders.size() > 1 ? "s" : ""),
                   fmt::format("give one of them, such as {}", shell_word(path / folders[0]))};
}

}  // namespace isosplat::import
