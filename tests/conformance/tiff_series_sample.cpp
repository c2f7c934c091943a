#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tests/conformance/tiff_writer.h"

// TIFF files that describe themselves: written from tifffile's, OME's, ImageJ's, MetaMorph's and
// Zeiss' descriptions of their formats.
namespace isosplat::conformance {
namespace {

/// The sizes of the axes other than x, y and z, and the index of the volume to read. Voxels of
/// other volumes have the value 9.
struct Stack {
  int channels = 1, times = 1, channel = 0, time = 0;
};

Stack choose_stack(Random& random, Sample& sample) {
  Stack stack;
  stack.channels = random.one_of({1, 1, 2, 3});
  stack.times = random.one_of({1, 1, 2, 3});
  stack.channel = random.between(0, stack.channels - 1);
  stack.time = random.between(0, stack.times - 1);
  if (stack.channels > 1) sample.options.channel = stack.channel;
  if (stack.times > 1) sample.options.time_step = stack.time;
  sample.needs_choice = stack.channels * stack.times > 1;
  return stack;
}

/// The samples of a row. Each has this number of bits, the highest bit first.
void pack_row(const std::vector<double>& values, size_t first, int count, int bits,
              std::string& out) {
  unsigned byte = 0;
  int used = 0;
  for (int i = 0; i < count; ++i) {
    const auto value = static_cast<unsigned>(values[first + static_cast<size_t>(i)]);
    for (int bit = bits - 1; bit >= 0; --bit) {
      byte = byte << 1 | (value >> bit & 1);
      if (++used == 8) out.push_back(static_cast<char>(byte)), byte = 0, used = 0;
    }
  }
  if (used > 0) out.push_back(static_cast<char>(byte << (8 - used)));
}

class Writer {
 public:
  Writer(Random& random, Sample& sample, Number type, bool big_endian)
      : random_(random), truth_(sample.truth), type_(type), big_endian_(big_endian) {
    choose_voxels(random, type, truth_);
    truth_.steps = {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  }

  bool big_endian() const { return big_endian_; }

  /// The voxels of slice z, or of another volume.
  std::string voxels(int z, bool is_chosen) const {
    std::string out;
    const size_t count =
        static_cast<size_t>(truth_.sizes[0]) * static_cast<size_t>(truth_.sizes[1]);
    for (size_t i = 0; i < count; ++i) {
      put_number(out, type_, is_chosen ? truth_.values[static_cast<size_t>(z) * count + i] : 9,
                 big_endian_);
    }
    return out;
  }

  Page page(int z, bool is_chosen = true) const {
    Page page;
    page.width = truth_.sizes[0], page.height = truth_.sizes[1], page.type = type_;
    page.voxels = voxels(z, is_chosen);
    return page;
  }

  /// Pages in an order of axes, the fastest first: "CZT".
  std::vector<Page> pages(const Stack& stack, const std::string& order) const {
    std::vector<Page> all;
    const auto size = [&](char axis) {
      return axis == 'Z' ? truth_.sizes[2] : axis == 'C' ? stack.channels : stack.times;
    };
    for (int i = 0; i < size('Z') * size('C') * size('T'); ++i) {
      std::map<char, int> at;
      int rest = i;
      for (const char axis : order) at[axis] = rest % size(axis), rest /= size(axis);
      all.push_back(page(at['Z'], at['C'] == stack.channel && at['T'] == stack.time));
    }
    return all;
  }

  std::string file(const std::vector<Page>& pages) {
    return tiff_file(random_, pages, big_endian_);
  }

 private:
  Random& random_;
  Truth& truth_;
  Number type_;
  bool big_endian_;
};

/// An order of the axes C, Z and T.
std::string any_order(Random& random) {
  return random.one_of({"CZT", "CTZ", "ZCT", "ZTC", "TCZ", "TZC"});
}

/// The axes that have several samples, as tifffile names them: the slowest first, then y and x.
void write_shaped(Random& random, Sample& sample, Writer& writer) {
  const Stack stack = choose_stack(random, sample);
  const std::string order = any_order(random);
  std::string axes, shape;
  for (size_t i = 3; i-- > 0;) {
    const int size = order[i] == 'Z'   ? sample.truth.sizes[2]
                     : order[i] == 'C' ? stack.channels
                                       : stack.times;
    if (size == 1 && random.chance(50)) continue;
    axes += order[i];
    shape += std::to_string(size) + ", ";
  }
  std::vector<Page> pages = writer.pages(stack, order);
  const bool is_bare = random.chance(30);  // one directory before the voxels of all planes
  pages[0].description = fmt::format("{{\"axes\": \"{}YX\", {}\"shape\": [{}{}, {}]}}", axes,
                                     is_bare ? "\"truncated\": true, " : "", shape,
                                     sample.truth.sizes[1], sample.truth.sizes[0]);
  if (is_bare) {
    for (size_t i = 1; i < pages.size(); ++i) pages[0].voxels += pages[i].voxels;
    pages.resize(1);
  }
  sample.must_be_noted = true;  // the distance between slices
  const bool are_two = !is_bare && random.chance(30);
  if (are_two) {
    Page other;
    other.width = 3, other.height = 4, other.voxels = std::string(12, '\1');
    other.description = "{\"shape\": [2, 4, 3]}";
    pages.push_back(other);
    other.description.clear();
    pages.push_back(other);
    sample.options.series = "1";
    sample.needs_choice = true;
  }
  sample.files["v.tif"] = writer.file(pages);
}

/// Distances of OME and ImageJ, with a unit in any spelling.
std::string choose_unit(Random& random) {
  return random.one_of({"&#181;m", "&#xb5;m", "µm", "μm", "\xb5m", "um", "micron"});
}

void write_ome(Random& random, Sample& sample, Writer& writer) {
  const Stack stack = choose_stack(random, sample);
  const std::string order = any_order(random), prefix = random.chance(30) ? "OME:" : "",
                    unit = choose_unit(random);
  Truth& truth = sample.truth;
  const std::vector<Page> pages = writer.pages(stack, order);
  // Where the planes are: in any order, in one or several files.
  std::vector<int> planes(pages.size());
  for (size_t i = 0; i < planes.size(); ++i) planes[i] = static_cast<int>(i);
  const bool is_listed = random.chance(70);
  if (is_listed && random.chance(60)) {
    for (size_t i = planes.size(); i-- > 1;) {
      std::swap(planes[i], planes[static_cast<size_t>(random.between(0, static_cast<int>(i)))]);
    }
  }
  const int files =
      is_listed ? std::min(random.one_of({1, 1, 2, 3}), static_cast<int>(planes.size())) : 1;
  const bool has_z = random.chance(70), has_companion = files > 1 && random.chance(30);
  std::string text = fmt::format(
      "<{0}Image ID=\"Image:0\"><{0}Pixels ID=\"Pixels:0\" DimensionOrder=\"XY{1}\" SizeX=\"{2}\" "
      "SizeY=\"{3}\" SizeZ=\"{4}\" SizeC=\"{5}\" SizeT=\"{6}\" PhysicalSizeX=\"0.5\" "
      "PhysicalSizeXUnit=\"{7}\" PhysicalSizeY=\"0.25\" PhysicalSizeYUnit=\"{7}\" ",
      prefix, order, truth.sizes[0], truth.sizes[1], truth.sizes[2], stack.channels, stack.times,
      unit);
  if (has_z) text += fmt::format("PhysicalSizeZ='2' PhysicalSizeZUnit='{}'", unit);
  text += ">";
  std::vector<std::vector<Page>> contents(static_cast<size_t>(files));
  const auto name = [](size_t file) { return fmt::format("a{}.ome.tif", file); };
  for (size_t i = 0; i < planes.size(); ++i) {
    const size_t file = i * static_cast<size_t>(files) / planes.size();
    std::map<char, int> at;
    int rest = planes[i];
    for (const char axis : order) {
      const int size = axis == 'Z' ? truth.sizes[2] : axis == 'C' ? stack.channels : stack.times;
      at[axis] = rest % size, rest /= size;
    }
    if (is_listed) {
      text += fmt::format("<{0}TiffData FirstZ=\"{1}\" FirstC=\"{2}\" FirstT=\"{3}\" IFD=\"{4}\">",
                          prefix, at['Z'], at['C'], at['T'], contents[file].size());
      if (files > 1) {
        text += fmt::format("<{0}UUID FileName=\"{1}\">urn:uuid:{2}</{0}UUID>", prefix, name(file),
                            file);
      }
      text += fmt::format("</{}TiffData>", prefix);
    }
    contents[file].push_back(pages[static_cast<size_t>(planes[i])]);
  }
  text += fmt::format("</{0}Pixels></{0}Image></{0}OME>", prefix);
  const std::string head = "<?xml version=\"1.0\"?><!-- <OME> --><" + prefix + "OME ";
  for (size_t file = 0; file < contents.size(); ++file) {
    const std::string uuid = fmt::format("UUID=\"urn:uuid:{}\">", file);
    contents[file][0].description =
        has_companion
            ? head + uuid + "<BinaryOnly MetadataFile=\"x.companion.ome\" UUID=\"urn:uuid:" +
                  std::to_string(file) + "\"/></" + prefix + "OME>"
            : head + uuid + text;
    sample.files[name(file)] = writer.file(contents[file]);
  }
  if (has_companion) {
    sample.files["x.companion.ome"] = head + ">" + text;
    sample.open_ended.insert("x.companion.ome");
  }
  sample.main =
      random.chance(30) && files > 1 ? "" : name(static_cast<size_t>(random.between(0, files - 1)));
  truth.steps = {Vec3d{5e-4, 0, 0}, Vec3d{0, 2.5e-4, 0}, Vec3d{0, 0, has_z ? 2e-3 : 1e-3}};
  sample.must_be_noted = !has_z;
  sample.false_notes = {"1,1,1", has_z ? "no distance" : "no size of pixels"};
}

void write_imagej(Random& random, Sample& sample, Writer& writer) {
  const Stack stack = choose_stack(random, sample);
  const int nz = sample.truth.sizes[2];
  std::vector<Page> pages = writer.pages(stack, "CZT");
  const bool has_spacing = random.chance(60), is_scifio = random.chance(30);
  for (Page& page : pages) page.resolution = 4;
  pages[0].description = fmt::format(
      "{}\nimages={}\nslices={}\nchannels={}\nframes={}\nhyperstack=true\n{}unit={}\n{}",
      is_scifio ? "SCIFIO=0.42.0\naxes=X,Y,Channel,Z,Time" : "ImageJ=1.53t", pages.size(), nz,
      stack.channels, stack.times, random.chance(50) ? "mode=composite\n" : "",
      random.one_of({"um", "micron", "\\u00B5m"}), has_spacing ? "spacing=2.0\n" : "loop=false\n");
  sample.truth.steps = {Vec3d{2.5e-4, 0, 0}, Vec3d{0, 2.5e-4, 0},
                        Vec3d{0, 0, has_spacing ? 2e-3 : 1e-3}};
  sample.must_be_noted = !has_spacing;
  sample.false_notes = {"1,1,1"};
  sample.files["v.tif"] = writer.file(pages);
}

/// One axis of times or channels in place of slices.
void write_frames(Random& random, Sample& sample, Writer& writer) {
  Stack one;
  std::vector<Page> pages = writer.pages(one, "CZT");
  const char* axis = random.one_of({"frames", "channels"});
  pages[0].description = fmt::format("ImageJ=1.53t\nimages={0}\n{1}={0}\n", pages.size(), axis);
  sample.options.allowed.add(import::Allowance::frames);
  sample.needs_choice = true;
  sample.must_be_noted = true;
  sample.files["v.tif"] = writer.file(pages);
}

/// MetaMorph: the tables come first, then the voxels of all planes.
void write_metamorph(Random& random, Sample& sample, Writer& writer) {
  const int nz = sample.truth.sizes[2];
  Page page = writer.page(0);
  for (int z = 1; z < nz; ++z) page.voxels += writer.voxels(z, true);
  const auto u32 = [](std::string& out, uint32_t value) { put(out, value, false); };
  // UIC1's count is half the number of its values: pairs of an id and a value or offset. Its table
  // is written after the others, at an offset that the beginning of the file states.
  std::string distances, wavelengths;
  for (int z = 0; z < nz; ++z) {
    u32(distances, 1500), u32(distances, 1000);
    for (int i = 0; i < 4; ++i) u32(distances, 7);
    u32(wavelengths, 500), u32(wavelengths, 1);
  }
  // The counts of the tags state the number of planes; their tables are longer.
  page.further = {{33629, 5, static_cast<uint32_t>(nz), distances},
                  {33630, 5, static_cast<uint32_t>(nz), wavelengths}};
  page.rows_per_strip = random.between(1, page.height);
  sample.truth.steps[2].z = 1.5;
  sample.must_be_noted = true;  // the size of pixels
  sample.false_notes = {"no distance"};
  sample.files["v.stk"] = writer.file({page});
  sample.main = "v.stk";
}

/// Zeiss: channels are samples, and each page has a small copy.
void write_lsm(Random& random, Sample& sample, Writer& writer) {
  const Stack stack = choose_stack(random, sample);
  const int nz = sample.truth.sizes[2];
  std::string table(300, '\0');
  const auto set = [&](size_t at, auto value) {
    std::string raw;
    put(raw, value, false);
    table.replace(at, raw.size(), raw);
  };
  set(0, uint32_t{0x0400494c}), set(4, int32_t{300});
  set(8, static_cast<int32_t>(sample.truth.sizes[0])),
      set(12, static_cast<int32_t>(sample.truth.sizes[1]));
  set(16, static_cast<int32_t>(nz)), set(20, static_cast<int32_t>(stack.channels));
  set(24, static_cast<int32_t>(stack.times));
  set(40, 5e-7), set(48, 2.5e-7), set(56, 2e-6);
  set(88, static_cast<uint16_t>(stack.times > 1 ? 6 : 0));
  std::vector<Page> pages;
  for (int t = 0; t < stack.times; ++t) {
    for (int z = 0; z < nz; ++z) {
      Page page = writer.page(z);
      page.voxels.clear();
      page.samples = stack.channels;
      for (int c = 0; c < stack.channels; ++c) {
        page.voxels += writer.voxels(z, c == stack.channel && t == stack.time);
      }
      if (pages.empty()) page.further.push_back({34412, 1, 300, table});
      pages.push_back(page);
      Page copy;
      copy.width = copy.height = 2, copy.voxels = "1234";
      copy.further.push_back({254, 4, 1, std::string("\1\0\0\0", 4)});
      pages.push_back(copy);
    }
  }
  sample.truth.steps = {Vec3d{5e-4, 0, 0}, Vec3d{0, 2.5e-4, 0}, Vec3d{0, 0, 2e-3}};
  sample.false_notes = {"1,1,1", "no distance"};
  sample.files["v.lsm"] = writer.file(pages);
  sample.main = "v.lsm";
}

/// Samples whose bits do not fill bytes, and 16-bit floating-point numbers.
void write_bits(Random& random, Sample& sample, Writer& writer) {
  Truth& truth = sample.truth;
  const int bits = random.one_of({1, 2, 4, 6, 10, 12, 14}), nx = truth.sizes[0];
  std::vector<Page> pages;
  for (double& value : truth.values) {
    value = random.between(0, (1 << bits) - 1);
  }
  for (int z = 0; z < truth.sizes[2]; ++z) {
    Page page = writer.page(z);
    page.type = Number::u8, page.bits = bits;
    page.voxels.clear();
    for (int y = 0; y < truth.sizes[1]; ++y) {
      pack_row(truth.values, static_cast<size_t>((z * truth.sizes[1] + y) * nx), nx, bits,
               page.voxels);
    }
    pages.push_back(page);
  }
  sample.must_be_noted = true;
  sample.files["v.tif"] = writer.file(pages);
}

/// Slices in a page with a depth, and pages whose strips were not written.
void write_depth(Random& random, Sample& sample, Writer& writer) {
  Truth& truth = sample.truth;
  std::vector<Page> pages;
  sample.must_be_noted = true;
  if (random.chance(50)) {
    Page page = writer.page(0);
    for (int z = 1; z < truth.sizes[2]; ++z) page.voxels += writer.voxels(z, true);
    std::string depth;
    put(depth, static_cast<uint32_t>(truth.sizes[2]), writer.big_endian());
    page.further.push_back({32997, 4, 1, depth});
    page.rows_per_strip = page.height;
    pages.push_back(page);
  } else {
    const int left_out = random.between(1, truth.sizes[2] - 1);
    const size_t slice = static_cast<size_t>(truth.sizes[0]) * static_cast<size_t>(truth.sizes[1]);
    for (int z = 0; z < truth.sizes[2]; ++z) {
      pages.push_back(writer.page(z));
      if (z != left_out) continue;
      pages.back().is_left_out = true;
      std::fill_n(
          truth.values.begin() + static_cast<std::ptrdiff_t>(static_cast<size_t>(z) * slice), slice,
          0.0);
    }
  }
  sample.files["v.tif"] = writer.file(pages);
}

}  // namespace

Sample make_tiff_series(Random& random) {
  Sample sample;
  const int kind = random.between(0, 7);
  const bool is_little = kind == 4 || kind == 5;  // MetaMorph and LSM
  const Number type =
      kind == 6 ? Number::u8 : random.one_of({Number::u8, Number::i16, Number::u16, Number::f32});
  Writer writer(random, sample, type, !is_little && random.chance(40));
  sample.may_be_longer = true;
  sample.main = "v.tif";
  constexpr const char* kKinds[] = {"shaped",    "OME", "ImageJ", "frames",
                                    "MetaMorph", "LSM", "bits",   "depth or sparse"};
  sample.text = kKinds[kind];
  if (kind == 0) write_shaped(random, sample, writer);
  if (kind == 1) write_ome(random, sample, writer);
  if (kind == 2) write_imagej(random, sample, writer);
  if (kind == 3) write_frames(random, sample, writer);
  if (kind == 4) write_metamorph(random, sample, writer);
  if (kind == 5) write_lsm(random, sample, writer);
  if (kind == 6) write_bits(random, sample, writer);
  if (kind == 7) write_depth(random, sample, writer);
  return sample;
}

}  // namespace isosplat::conformance
