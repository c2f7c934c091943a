#include <fmt/format.h>

#include <algorithm>

#include "tests/conformance/sample.h"
#include "tests/conformance/tiff_writer.h"

// Written from the TIFF 6.0 specification, and the descriptions of ImageJ's and OME's formats.
namespace isosplat::conformance {
namespace {

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
    Page page;
    page.width = nx, page.height = ny, page.type = type;
    page.white_is_zero = white, page.orientation = orientation;
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
