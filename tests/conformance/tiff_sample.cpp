#include <fmt/format.h>

#include <algorithm>

#include "tests/conformance/sample.h"

// Written from the TIFF 6.0 specification, and the descriptions of ImageJ's and OME's formats.
namespace isosplat::conformance {
namespace {

/// The contents of a page's directory.
struct Page {
  int width = 0, height = 0;
  Number type = Number::u8;
  bool white_is_zero = false;
  int orientation = 1;
  std::string description;
  double resolution = 0;
  std::string voxels;
};

int strip_count(const Page& page, int rows) {
  return (page.height + rows - 1) / rows;
}

uint32_t row_bytes(const Page& page) {
  return static_cast<uint32_t>(page.width * static_cast<int>(bytes_of(page.type)));
}

/// An entry of a directory.
struct Entry {
  uint16_t tag, type;
  uint32_t count;
  std::string value;
};

/// The entries of a page's directory, with 0 for the strips' offsets (tag 273). `rows`: of each
/// strip.
std::vector<Entry> entries_of(const Page& page, int rows, bool big_endian) {
  std::vector<Entry> entries;
  const auto add_short = [&](uint16_t tag, int value) {
    std::string raw;
    put(raw, static_cast<uint16_t>(value), big_endian);
    entries.push_back({tag, 3, 1, raw + std::string(2, '\0')});
  };
  const auto add_long = [&](uint16_t tag, uint32_t value) {
    std::string raw;
    put(raw, value, big_endian);
    entries.push_back({tag, 4, 1, raw});
  };
  const bool is_float = page.type == Number::f32 || page.type == Number::f64;
  const bool is_signed = page.type == Number::i8 || page.type == Number::i16 ||
                         page.type == Number::i32 || page.type == Number::i64;
  const int strips = strip_count(page, rows);
  add_long(256, static_cast<uint32_t>(page.width));
  add_long(257, static_cast<uint32_t>(page.height));
  add_short(258, 8 * static_cast<int>(bytes_of(page.type)));
  add_short(259, 1);
  add_short(262, page.white_is_zero ? 0 : 1);
  if (!page.description.empty()) {
    entries.push_back(
        {270, 2, static_cast<uint32_t>(page.description.size() + 1), page.description + '\0'});
  }
  const std::string offsets(4 * static_cast<size_t>(strips), '\0');
  entries.push_back({273, 4, static_cast<uint32_t>(strips), offsets});
  add_short(274, page.orientation);
  add_short(277, 1);
  add_long(278, static_cast<uint32_t>(rows));
  std::string counts;
  for (int i = 0; i < strips; ++i) {
    put(counts, static_cast<uint32_t>(std::min(rows, page.height - i * rows)) * row_bytes(page),
        big_endian);
  }
  entries.push_back({279, 4, static_cast<uint32_t>(strips), counts});
  if (page.resolution > 0) {
    std::string ratio;
    put(ratio, static_cast<uint32_t>(page.resolution * 1000), big_endian);
    put(ratio, uint32_t{1000}, big_endian);
    entries.push_back({282, 5, 1, ratio});
    entries.push_back({283, 5, 1, ratio});
  }
  add_short(339, is_float ? 3 : is_signed ? 2 : 1);
  return entries;
}

/// The offset at which a directory and its values end. Values longer than four bytes follow the
/// directory.
size_t end_of_directory(size_t directory, const std::vector<Entry>& entries) {
  size_t end = directory + 2 + 12 * entries.size() + 4;
  for (const Entry& entry : entries) {
    if (entry.value.size() > 4) end += (entry.value.size() + 1) / 2 * 2;
  }
  return end;
}

/// Appends a directory and its values. Returns the offset of the link to the next directory.
size_t append_directory(const std::vector<Entry>& entries, bool big_endian, std::string& out) {
  const size_t after_at = out.size() + 2 + 12 * entries.size() + 4;
  put(out, static_cast<uint16_t>(entries.size()), big_endian);
  std::string after;
  for (const Entry& entry : entries) {
    put(out, entry.tag, big_endian);
    put(out, entry.type, big_endian);
    put(out, entry.count, big_endian);
    if (entry.value.size() <= 4) {
      out += entry.value + std::string(4 - entry.value.size(), '\0');
    } else {
      put(out, static_cast<uint32_t>(after_at + after.size()), big_endian);
      after += entry.value;
      if (after.size() % 2) after.push_back('\0');
    }
  }
  const size_t link = out.size();
  put(out, uint32_t{0}, big_endian);
  out += after;
  return link;
}

/// A classic TIFF file. Directories are before or after their voxels.
std::string tiff_file(Random& random, const std::vector<Page>& pages, bool big_endian) {
  std::string out = big_endian ? "MM" : "II";
  put(out, uint16_t{42}, big_endian);
  const bool first = random.chance(50);
  size_t link = out.size();
  put(out, uint32_t{0}, big_endian);
  const auto append_voxels = [&](const Page& page) {
    out += page.voxels;
    if (out.size() % 2) out.push_back('\0');
  };
  for (const Page& page : pages) {
    const int rows = random.chance(50) ? page.height : random.between(1, page.height);
    size_t voxels_at = out.size();
    if (!first) append_voxels(page);
    std::vector<Entry> entries = entries_of(page, rows, big_endian);
    if (first) voxels_at = end_of_directory(out.size(), entries);
    std::string& offsets = std::ranges::find(entries, 273, &Entry::tag)->value;
    offsets.clear();
    for (int i = 0; i < strip_count(page, rows); ++i) {
      const uint32_t strip = static_cast<uint32_t>(i * rows) * row_bytes(page);
      put(offsets, static_cast<uint32_t>(voxels_at) + strip, big_endian);
    }
    std::string directory;
    put(directory, static_cast<uint32_t>(out.size()), big_endian);
    out.replace(link, 4, directory);
    link = append_directory(entries, big_endian, out);
    if (first) append_voxels(page);
  }
  return out;
}

double greatest(Number type) {
  return type == Number::u8 ? 255 : type == Number::u16 ? 65535 : 4294967295.0;
}

/// Describes the pages as ImageJ does, with the distances of voxels.
void describe_for_imagej(Random& random, int slices, int frames, std::vector<Page>& pages,
                         Truth& truth) {
  const char* unit = random.one_of({"micron", "mm", "um", "cm"});
  const std::string name = unit;
  const double mm = name == "mm"   ? 1
                    : name == "cm" ? 10
                                   : 0.001,
               between = random.between(1, 8) * 0.5;
  const double resolution = random.one_of({1.0, 2.0, 4.0, 8.0});
  for (Page& page : pages) page.resolution = resolution;
  pages[0].description = fmt::format(
      "ImageJ=1.53t\nimages={}\nslices={}\n{}unit={}\nspacing={}\nloop=false\n", slices * frames,
      slices, frames > 1 ? fmt::format("frames={}\nhyperstack=true\n", frames) : "", unit,
      random.chance(30) ? -between : between);
  truth.steps = {Vec3d{mm / resolution, 0, 0}, Vec3d{0, mm / resolution, 0},
                 Vec3d{0, 0, between * mm}};
}

/// Describes the pages as OME-TIFF does, with the distances of voxels.
void describe_for_ome(bool slices_first, int frames, std::vector<Page>& pages, Truth& truth) {
  pages[0].description = fmt::format(
      "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\">"
      "<Image ID=\"Image:0\"><Pixels ID=\"Pixels:0\" DimensionOrder=\"{}\" SizeX=\"{}\" "
      "SizeY=\"{}\" SizeZ=\"{}\" SizeC=\"1\" SizeT=\"{}\" PhysicalSizeX=\"0.5\" "
      "PhysicalSizeY=\"0.25\" PhysicalSizeZ=\"2\"></Pixels></Image></OME>",
      slices_first ? "XYCZT" : "XYCTZ", truth.sizes[0], truth.sizes[1], truth.sizes[2], frames);
  truth.steps = {Vec3d{5e-4, 0, 0}, Vec3d{0, 2.5e-4, 0}, Vec3d{0, 0, 2e-3}};
}

}  // namespace

Sample make_tiff(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const Number type = random.one_of({Number::u8, Number::i8, Number::u16, Number::i16, Number::u32,
                                     Number::i32, Number::f32, Number::f64});
  choose_voxels(random, type, truth);
  const bool big_endian = random.chance(40), white = random.chance(20);
  const bool is_unsigned = type == Number::u8 || type == Number::u16 || type == Number::u32;
  const int orientation = random.chance(25) ? random.between(1, 4) : 1;
  const int nx = truth.sizes[0], ny = truth.sizes[1], nz = truth.sizes[2];

  const auto page_of = [&](const std::vector<double>& values, int z) {
    Page page{nx, ny, type, white, orientation, "", 0, ""};
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const int from_x = orientation == 2 || orientation == 3 ? nx - 1 - x : x;
        const int from_y = orientation == 3 || orientation == 4 ? ny - 1 - y : y;
        double value = values[static_cast<size_t>((z * ny + from_y) * nx + from_x)];
        if (white && is_unsigned) value = greatest(type) - value;
        put_number(page.voxels, type, value, big_endian);
      }
    }
    return page;
  };
  sample.must_be_noted = true;  // the distance between slices, or 0 as white
  truth.steps = {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  sample.may_be_longer = true;

  const int kind = random.between(0, 3);
  if (kind == 3) {  // a folder with a file per slice
    const double spacing = random.between(1, 9);
    sample.options.spacing = Vec3d{1, 1, spacing};
    truth.steps[2].z = spacing;
    sample.must_be_noted = white;
    const int style = random.between(0, 3), step = random.between(1, 4);
    for (int z = 0; z < nz; ++z) {
      const int number = z * step + 7;
      const std::string name = style == 0   ? fmt::format("slice_{}.tif", number)
                               : style == 1 ? fmt::format("a-{:04}.tiff", number)
                               : style == 2
                                   ? fmt::format("z{}.tif", number - 7 - step)  // z-1, z0
                                   : fmt::format("run 2 z{}.{}.tif", number / 10, number % 10);
      sample.files[name] = tiff_file(random, {page_of(truth.values, z)}, big_endian);
      if (nz > 3 && z > 0 && z < nz - 1) sample.removable.insert(name);
    }
    sample.text = fmt::format("a folder, style {}", style);
    return sample;
  }

  const int frames = kind == 0 ? 1 : random.one_of({1, 1, 2, 3});
  const int step = random.between(0, frames - 1);
  if (frames > 1) sample.options.time_step = step;
  const bool slices_first = kind == 1 || random.chance(50);
  std::vector<Page> pages;
  const std::vector<double> other(truth.values.size(), 9);
  for (int i = 0; i < nz * frames; ++i) {
    const int z = slices_first ? i % nz : i / frames, t = slices_first ? i / nz : i % frames;
    pages.push_back(page_of(t == step ? truth.values : other, z));
  }
  if (kind == 1) describe_for_imagej(random, nz, frames, pages, truth);
  if (kind == 2) describe_for_ome(slices_first, frames, pages, truth);
  if (kind > 0) sample.must_be_noted = white;
  sample.main = "v.tif";
  sample.files["v.tif"] = tiff_file(random, pages, big_endian);
  sample.text = kind == 0 ? "pages" : pages[0].description;
  return sample;
}

}  // namespace isosplat::conformance
