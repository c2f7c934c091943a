#include <tiffio.h>

#include <algorithm>
#include <regex>
#include <set>

#include "tests/native/dicom_files.h"
#include "tests/native/import_checks.h"

// A note must not contradict the content of the file. The table below has each note that says "the
// file does not state …". Each row has a file that must have this note, and files that state the
// property, in each form that the format allows, and must not have the note.
namespace isosplat::import {
namespace {

using test::bytes_of;
using test::pattern_voxels;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

std::string voxels() {
  return bytes_of(pattern_voxels<int16_t>(kSize));
}

/// Writes a file or folder, and returns its path.
using Write = std::function<std::filesystem::path(const TempFolder&)>;

Write file(const std::string& name, const std::string& content) {
  return [=](const TempFolder& folder) {
    write_file(folder / name, content);
    return folder / name;
  };
}

Write nrrd(const std::string& fields) {
  return file(
      "v.nrrd",
      test::nrrd_header(kSize, "short", fields + "endian: little\nencoding: raw\n\n") + voxels());
}

Write meta_image(const std::string& fields) {
  return file("v.mha", "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\n" + fields +
                           "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" + voxels());
}

Write vtk(const std::string& fields) {
  return file(
      "v.vtk",
      "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n" +
          fields + "POINT_DATA 60\nSCALARS p short\nLOOKUP_TABLE default\n" +
          bytes_of(test::byte_swapped(pattern_voxels<int16_t>(kSize))));
}

constexpr const char* kTurned = "Direction=\"0 -1 0 1 0 0 0 0 1\"";

/// A VTK XML image with attributes; `naming`: those of a file that names it as its piece, if any.
Write vti(const std::string& attributes, const std::string& naming) {
  const std::string extent = "Extent=\"0 4 0 3 0 2\"";
  const auto grid = [&](const std::string& type, const std::string& fields,
                        const std::string& piece) {
    return fmt::format("<VTKFile type=\"{0}\"><{0} Whole{1} {2}><Piece {1} {3}</{0}></VTKFile>",
                       type, extent, fields, piece);
  };
  std::string values;
  for (int i = 0; i < 60; ++i) values += fmt::format("{} ", i * i);
  const std::string piece =
      grid("ImageData", attributes,
           "><PointData><DataArray type=\"Int16\" Name=\"p\" format=\"ascii\">" + values +
               "</DataArray></PointData></Piece>");
  const std::string whole = grid("PImageData", naming, "Source=\"p.vti\"/>");
  return [=](const TempFolder& folder) {
    write_file(folder / "p.vti", piece);
    write_file(folder / "v.pvti", whole);
    return folder / (naming.empty() ? "p.vti" : "v.pvti");
  };
}

/// Sets numbers in a NIfTI header by their offset.
template <class T>
struct At {
  size_t offset;
  T value;
};

template <class... T>
Write nifti(At<T>... fields) {
  test::NiftiFile file_of;
  file_of.sizes = {5, 4, 3};
  file_of.voxels = voxels();
  std::string bytes = file_of.bytes();
  (std::memcpy(&bytes[fields.offset], &fields.value, sizeof fields.value), ...);
  return file("v.nii", bytes);
}

/// FreeSurfer's format; `flag`: whether the header has spacing and directions.
Write mgh(int16_t flag) {
  const auto put = [](std::string& out, auto value) {
    const auto* const bytes = reinterpret_cast<const char*>(&value);
    for (size_t i = sizeof value; i-- > 0;) out += bytes[i];
  };
  std::string bytes;
  for (const int32_t word : {1, 5, 4, 3, 1, 4, 0}) put(bytes, word);
  put(bytes, flag);
  for (const float number : {2, 2, 2, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0}) put(bytes, number);
  bytes.resize(284);
  return file("v.mgh", bytes + bytes_of(test::byte_swapped(pattern_voxels<int16_t>(kSize))));
}

/// An MRC file of bytes (mode 0); numbers by their word, from 1.
template <class... T>
Write mrc(const std::string& labels, At<T>... words) {
  std::string bytes(1024, '\0');
  const auto set = [&](size_t word, auto value) { std::memcpy(&bytes[4 * (word - 1)], &value, 4); };
  const int32_t first[] = {5, 4, 3, 0, 0, 0, 0, 5, 4, 3};
  for (size_t i = 0; i < 10; ++i) set(1 + i, first[i]);
  const float cell[] = {10, 12, 15, 90, 90, 90};
  for (size_t i = 0; i < 6; ++i) set(11 + i, cell[i]);
  for (size_t i = 0; i < 3; ++i) set(17 + i, static_cast<int32_t>(i + 1));
  set(21, 100.0f);
  set(23, int32_t{1});
  bytes.replace(208, 6, "MAP DD");
  (set(words.offset, words.value), ...);
  return file("v.mrc", bytes + bytes_of(pattern_voxels<uint8_t>(kSize)) + labels);
}

Write tiff(const std::string& description) {
  return [=](const TempFolder& folder) {
    const auto path = folder / "v.tif";
    TIFF* out = TIFFOpen(path.c_str(), "wl");
    std::string data = voxels();
    for (uint32_t page = 0; page < 3; ++page) {
      TIFFSetField(out, TIFFTAG_IMAGEWIDTH, 5);
      TIFFSetField(out, TIFFTAG_IMAGELENGTH, 4);
      TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, 16);
      TIFFSetField(out, TIFFTAG_SAMPLESPERPIXEL, 1);
      TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
      if (page == 0 && !description.empty()) {
        TIFFSetField(out, TIFFTAG_IMAGEDESCRIPTION, description.c_str());
      }
      for (uint32_t y = 0; y < 4; ++y) TIFFWriteScanline(out, &data[40 * page + 10 * y], y);
      TIFFWriteDirectory(out);
    }
    TIFFClose(out);
    return path;
  };
}

/// Three PNG files of 2 × 2 grey pixels; `per_metre`: their density, if it is not 0.
Write png_slices(uint32_t per_metre) {
  return [=](const TempFolder& folder) {
    const auto number = [](uint32_t n) {
      std::string bytes;
      for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(n >> shift);
      return bytes;
    };
    const auto chunk = [&](const std::string& content) {
      const auto* bytes = reinterpret_cast<const Bytef*>(content.data());
      const uLong sum = ::crc32(0, bytes, static_cast<uInt>(content.size()));
      return number(static_cast<uint32_t>(content.size() - 4)) + content +
             number(static_cast<uint32_t>(sum));
    };
    const std::string density =
        per_metre ? chunk("pHYs" + number(per_metre) + number(per_metre) + "\1") : "";
    for (int z = 0; z < 3; ++z) {
      write_file(folder / fmt::format("s{}.png", z),
                 "\x89PNG\r\n\x1a\n" +
                     chunk("IHDR" + number(2) + number(2) + std::string("\x08\0\0\0\0", 5)) +
                     density + chunk("IDAT" + test::deflated(std::string("\0ab\0cd", 6), 15)) +
                     chunk("IEND"));
    }
    return folder.path();
  };
}

Write hdf5(const std::string& name) {
  return [=](const TempFolder&) {
    return std::filesystem::path(ISOSPLAT_SOURCE_DIR) / "tests/native/hdf5" / name;
  };
}

/// A series of DICOM slices without some elements.
Write dicom(const std::vector<uint32_t>& without) {
  return [=](const TempFolder& folder) {
    const test::BallSeries series;
    for (int z = 0; z < series.size.z; ++z) {
      test::DicomItem data = series.slice(z);
      for (const uint32_t tag : without) data.erase(tag);
      series.write_slice(folder, z, data);
    }
    return folder.path();
  };
}

struct Row {
  const char* note;  ///< a part of the note; as in the source, with {} for what is inserted
  Write silent;      ///< a file that does not state the property, so that it has the note
  std::vector<Write> stating;  ///< files that state it
};

const std::string kSpacings = "spacings: 1 2 3\n";
const std::string kDirections =
    "space: LPS\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (0,0,0)\n";

// Add a row for each new note of this kind.
const Row kRows[] = {
    {"the header has no voxel spacing",
     nrrd(""),
     {nrrd(kSpacings), nrrd(kDirections), nrrd("axis mins: 0 0 0\naxis maxs: 4 6 6\n")}},
    {"the header has no space origin",
     nrrd("space: LPS\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (nan,nan,nan)\n"),
     {nrrd(kDirections)}},
    {"the header has no space directions",
     nrrd("space: LPS\nspacings: 1 2 3\n"),
     {nrrd(kDirections)}},
    {"since the header has no 'centers'",
     nrrd("axis mins: 0 0 0\naxis maxs: 4 6 6\n"),
     {nrrd("axis mins: 0 0 0\naxis maxs: 4 6 6\ncenters: node node node\n"),
      nrrd("axis mins: 0 0 0\naxis maxs: 5 8 9\ncenterings: cell cell cell\n")}},
    {"the header has no voxel spacing",
     meta_image(""),
     {meta_image("ElementSpacing = 1 2 3\n"), meta_image("ElementSize = 1 2 3\n")}},
    {"the header has no voxel spacing",
     vtk("ORIGIN 0 0 0\n"),
     {vtk("ORIGIN 0 0 0\nSPACING 1 2 3\n"), vtk("ASPECT_RATIO 1 2 3\nORIGIN 0 0 0\n")}},
    {"the header has no voxel spacing",
     vti("Origin=\"0 0 0\"", ""),
     {vti("Spacing=\"1 2 3\"", ""), vti("Origin=\"0 0 0\" Spacing=\"1 1 1\"", "")}},
    {"the file has no Direction",
     vti(kTurned, "Spacing=\"1 2 3\""),
     {vti(kTurned, std::string("Spacing=\"1 2 3\" ") + kTurned),
      vti("Spacing=\"1 2 3\"", "Spacing=\"1 2 3\"")}},
    {"the header has no voxel spacing and orientation", mgh(0), {mgh(1)}},
    {"the header has no orientation",
     nifti(At<int16_t>{254, 0}),
     {nifti(), nifti(At<int16_t>{254, 0}, At<int16_t>{252, 1})}},
    {"the header has no unit of lengths",
     nifti(At<char>{123, 0}),
     {nifti(), nifti(At<char>{123, 1}), nifti(At<char>{123, 3}), nifti(At<char>{123, 2 + 8})}},
    {"the header has no voxel spacing",
     mrc("", At<float>{11, 0}, At<float>{12, 0}, At<float>{13, 0}),
     {mrc("")}},
    {"the header has no angles between its axes",
     mrc("", At<float>{14, 0}, At<float>{15, 0}, At<float>{16, 0}),
     {mrc("")}},
    {"the header does not say which axes its columns, rows and sections are",
     mrc("", At<int32_t>{17, 0}, At<int32_t>{18, 0}, At<int32_t>{19, 0}),
     {mrc("")}},
    {"the header's machine stamp does not state the byte order",
     mrc("", At<int32_t>{54, 0}),
     {mrc("")}},
    {"the header does not say whether its bytes are signed",
     mrc(""),
     {mrc("", At<int32_t>{28, 20140}), mrc("", At<float>{20, -5.0f})}},
    {"the TIFF file has no distance between slices",
     tiff(""),
     {tiff("ImageJ=1.53t\nimages=3\nslices=3\nunit=mm\nspacing=2.0\n"),
      tiff(
          "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\">"
          "<Image ID=\"Image:0\"><Pixels ID=\"Pixels:0\" DimensionOrder=\"XYZCT\" Type=\"uint16\" "
          "SizeX=\"5\" SizeY=\"4\" SizeZ=\"3\" SizeC=\"1\" SizeT=\"1\" PhysicalSizeX=\"1\" "
          "PhysicalSizeY=\"1\" PhysicalSizeZ=\"2\"><TiffData/></Pixels></Image></OME>")}},
    {"the pictures state no distance between voxels", png_slices(0), {png_slices(2835)}},
    {"the slices have no pixel spacing", dicom({0x00280030}), {dicom({})}},
    {"does not name the array's axes",
     hdf5("contiguous.h5"),
     {hdf5("ilastik.h5"), hdf5("nexus.h5")}},
    {"no voxel spacing was found in the HDF5 file",
     hdf5("filtered.h5"),
     {hdf5("contiguous.h5"), hdf5("nexus.h5")}},
};

/// Notes that are not in the table, and why.
const std::pair<const char*, const char*> kExempt[] = {
    {"a NumPy array has no voxel spacing", "the format cannot state it"},
    {"an OpenDX file does not state its unit of length", "the format cannot state it"},
    {"a raw file has no voxel spacing", "there is no header"},
    {"a MATLAB array does not say what its axes are", "the format cannot state it"},
    {"the axes of the array have no names", "only where the description lists sizes alone"},
    {"the voxels of the missing pages have no value", "says what was done, not what is absent"},
    {"slices have no frame in the file", "counts what was read"},
    {"the file has no distance between slices (Spacing Between Slices)",
     "the element itself was looked for; tested with segments"},
    {"the Imaris file does not state the image's size", "both of its attributes are absent"},
};

std::vector<std::string> notes_of(const Write& write) {
  const TempFolder folder;
  const auto volume = open_volume(write(folder), {});
  EXPECT_TRUE(volume) << volume.error().message;
  return volume ? volume->notes : std::vector<std::string>{};
}

bool says(const std::vector<std::string>& notes, const std::string& part) {
  return std::ranges::any_of(
      notes, [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

TEST(FalseNotes, NoNoteDeniesAPropertyThatTheFileStates) {
  for (const Row& row : kRows) {
    SCOPED_TRACE(fmt::format("row {}: {}", &row - kRows, row.note));
    EXPECT_TRUE(says(notes_of(row.silent), row.note)) << "the file that does not state it";
    ASSERT_FALSE(row.stating.empty());
    for (const Write& stating : row.stating) {
      EXPECT_FALSE(says(notes_of(stating), row.note))
          << "file " << &stating - row.stating.data() << " that states it";
    }
  }
}

/// The texts of all notes in a source: those in the arguments of push_back.
std::vector<std::string> notes_in(const std::string& source) {
  std::vector<std::string> texts;
  constexpr std::string_view kCall = "push_back(";
  for (size_t at = source.find(kCall); at != source.npos; at = source.find(kCall, at + 1)) {
    std::string text;
    int depth = 1;
    bool in_text = false;
    for (size_t i = at + kCall.size(); i < source.size() && depth > 0; ++i) {
      const char c = source[i];
      if (in_text && c == '\\') {
        text += source[++i];
      } else if (c == '"') {
        in_text = !in_text;
      } else if (in_text) {
        text += c;
      } else {
        depth += c == '(' ? 1 : c == ')' ? -1 : 0;
      }
    }
    if (!text.empty()) texts.push_back(text);
  }
  return texts;
}

// Checks that the table is complete.
TEST(FalseNotes, EveryDenialHasARow) {
  const std::regex denial(
      "(header|file|array|slices?|pictures|image|dataset|pages|axis \\{\\})('s \\w+( \\w+)?)? "
      "(has|have|names?|states?) no |(does|do) not (say|name|state|have|describe)");
  size_t found = 0;
  const auto folder = std::filesystem::path(ISOSPLAT_SOURCE_DIR) / "shared/import";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".cpp") continue;
    for (const std::string& text : notes_in(test::read_file(entry.path()))) {
      if (!std::regex_search(text, denial)) continue;
      ++found;
      const auto has = [&](const auto& row) { return text.find(row) != std::string::npos; };
      EXPECT_TRUE(std::ranges::any_of(kRows, [&](const Row& row) { return has(row.note); }) ||
                  std::ranges::any_of(kExempt, [&](const auto& row) { return has(row.first); }))
          << entry.path().filename() << " has the note \"" << text
          << "\": add a row with a file that states it";
    }
  }
  EXPECT_GT(found, 12u);
}

}  // namespace
}  // namespace isosplat::import
