#include <fmt/format.h>

#include "tests/conformance/sample.h"

// Written from http://teem.sourceforge.net/nrrd/format.html.
namespace isosplat::conformance {
namespace {

struct SpaceName {
  const char* name;
  std::array<int, 3> signs;  ///< of x, y and z relative to LPS
  bool has_time;
};

constexpr SpaceName kSpaces[] = {
    {"right-anterior-superior", {-1, -1, 1}, false},
    {"RAS", {-1, -1, 1}, false},
    {"left-anterior-superior", {1, -1, 1}, false},
    {"LAS", {1, -1, 1}, false},
    {"left-posterior-superior", {1, 1, 1}, false},
    {"LPS", {1, 1, 1}, false},
    {"right-anterior-superior-time", {-1, -1, 1}, true},
    {"LAST", {1, -1, 1}, true},
    {"left-posterior-superior-time", {1, 1, 1}, true},
    {"scanner-xyz", {1, 1, 1}, false},
    {"3D-right-handed", {1, 1, 1}, false},
    {"3D-left-handed", {1, 1, -1}, false},
    {"", {1, 1, 1}, false},  // "space dimension: 3"
};

const char* type_name(Random& random, Number type) {
  switch (type) {
    case Number::u8:
      return random.one_of({"uchar", "unsigned char", "uint8", "uint8_t"});
    case Number::i8:
      return random.one_of({"signed char", "int8", "int8_t"});
    case Number::u16:
      return random.one_of({"ushort", "unsigned short", "unsigned short int", "uint16"});
    case Number::i16:
      return random.one_of({"short", "short int", "signed short", "int16", "int16_t"});
    case Number::u32:
      return random.one_of({"uint", "unsigned int", "uint32", "uint32_t"});
    case Number::i32:
      return random.one_of({"int", "signed int", "int32", "int32_t"});
    case Number::u64:
      return random.one_of({"ulonglong", "unsigned long long", "uint64"});
    case Number::i64:
      return random.one_of({"longlong", "long long", "signed long long int", "int64_t"});
    case Number::f32:
      return "float";
    case Number::f64:
      break;
  }
  return "double";
}

std::string vector_text(Vec3d v, const char* more = "") {
  return fmt::format("({:.17g},{:.17g},{:.17g}{})", v.x, v.y, v.z, more);
}

std::string hex_of(const std::string& bytes) {
  std::string out;
  for (size_t i = 0; i < bytes.size(); ++i) {
    out += fmt::format("{:02x}", static_cast<unsigned char>(bytes[i]));
    if (i % 35 == 34) out += "\n";
  }
  return out + "\n";
}

/// One of up to four axes of the file, in file order.
struct Axis {
  bool is_space = true;
  size_t index = 0;  ///< of the spatial axis: 0, 1, 2
  int size = 0;
};

/// Chooses the axes x, y and z, and sometimes time or a list at any position among them. `step`:
/// the step that is read.
std::vector<Axis> choose_axes(Random& random, Sample& sample, int& step) {
  std::vector<Axis> axes;
  for (size_t i = 0; i < 3; ++i) axes.push_back({true, i, sample.truth.sizes[i]});
  if (random.chance(40)) {
    const int steps = random.between(1, 3);
    step = random.between(0, steps - 1);
    axes.insert(axes.begin() + random.between(0, 3), {false, 0, steps});
    if (steps > 1 || random.chance(50)) sample.options.time_step = step;
  }
  return axes;
}

/// Values of all steps, the first axis fastest; other steps have different values.
std::vector<double> values_of_all_steps(const Truth& truth, const std::vector<Axis>& axes,
                                        int step) {
  std::vector<double> stored;
  size_t total = 1;
  for (const Axis& axis : axes) total *= static_cast<size_t>(axis.size);
  for (size_t n = 0; n < total; ++n) {
    size_t rest = n;
    std::array<int, 3> place{};
    int at_step = 0;
    for (const Axis& axis : axes) {
      const int i = static_cast<int>(rest % static_cast<size_t>(axis.size));
      rest /= static_cast<size_t>(axis.size);
      (axis.is_space ? place[axis.index] : at_step) = i;
    }
    const double value = truth.values[static_cast<size_t>(
        (place[2] * truth.sizes[1] + place[1]) * truth.sizes[0] + place[0])];
    stored.push_back(at_step == step ? value : 7);
  }
  return stored;
}

/// The lines of a header with a space. `kinds`: the line of the axes' kinds.
std::string space_lines(Random& random, const std::vector<Axis>& axes, const std::string& kinds,
                        Truth& truth) {
  std::string header, directions = "space directions:";
  const SpaceName& space = kSpaces[random.between(0, std::size(kSpaces) - 1)];
  const double unit = random.one_of({1.0, 1.0, 0.001, 10.0});
  const auto in_file = choose_steps(random, true);
  const Vec3d origin = choose_place(random);
  for (size_t i = 0; i < 3; ++i) truth.steps[i] = with_signs(in_file[i], space.signs) * unit;
  truth.origin = with_signs(origin, space.signs) * unit;
  for (const Axis& axis : axes) {
    directions += " ";
    if (axis.is_space) {
      directions += vector_text(in_file[axis.index], space.has_time ? ",0" : "");
    } else {
      directions += space.has_time ? "(0,0,0,2.5)" : "none";
    }
  }
  header += *space.name ? fmt::format("space: {}\n", space.name) : "space dimension: 3\n";
  header +=
      directions + "\nspace origin: " + vector_text(origin, space.has_time ? ",1" : "") + "\n";
  if (unit != 1 || random.chance(30)) {
    const char* name = unit == 1 ? "mm" : unit == 10 ? "cm" : "um";
    header += fmt::format("space units: \"{0}\" \"{0}\" \"{0}\"{1}\n", name,
                          space.has_time ? " \"s\"" : "");
  }
  if (axes.size() > 3 || random.chance(50)) header += kinds + "\n";
  if (random.chance(20)) header += "measurement frame: (1,0,0) (0,1,0) (0,0,1)\n";
  return header;
}

/// The lines of a header without a space: spacings, mins, maxs and centers.
std::string spacing_lines(Random& random, const std::vector<Axis>& axes, Sample& sample) {
  Truth& truth = sample.truth;
  std::string header;
  std::string spacings = "spacings:", mins = "axis mins:", maxs = "axis maxs:",
              centers = "centers:";
  const bool has_spacings = random.chance(60), has_mins = random.chance(60);
  const bool has_maxs = !has_spacings && has_mins;
  const bool cell = random.chance(50);
  for (const Axis& axis : axes) {
    if (!axis.is_space) {
      spacings += " nan";
      mins += " nan";
      maxs += " nan";
      centers += " ???";
      continue;
    }
    const double spacing =
        (random.chance(20) && (has_spacings || has_mins) ? -1 : 1) * random.between(1, 20) * 0.25;
    const double min = random.between(-50, 50) * 0.5;
    const double used = has_spacings || has_maxs ? spacing : 1;
    const double first = has_mins ? min + (cell ? used / 2 : 0) : 0;
    double* const origin[] = {&truth.origin.x, &truth.origin.y, &truth.origin.z};
    *origin[axis.index] = first;
    truth.steps[axis.index] = {axis.index == 0 ? used : 0, axis.index == 1 ? used : 0,
                               axis.index == 2 ? used : 0};
    spacings += fmt::format(" {:.17g}", spacing);
    mins += fmt::format(" {:.17g}", min);
    maxs += fmt::format(" {:.17g}", min + used * (cell ? axis.size : axis.size - 1));
    centers += cell ? " cell" : " node";
  }
  if (has_spacings) header += spacings + "\n";
  if (has_mins) header += mins + "\n";
  if (has_maxs) header += maxs + "\n";
  if (has_mins || random.chance(30)) header += centers + "\n";
  sample.must_be_noted = !has_spacings && !has_mins;
  return header;
}

/// Writes the header and the encoded voxels to one file, two, or a file for each step of the
/// slowest axis.
void add_files(Random& random, std::string header, const std::string& coding, std::string coded,
               const std::vector<Axis>& axes, Sample& sample) {
  const int layout = random.between(0, 3);
  if (layout == 0 || (layout > 1 && coding != "raw")) {
    sample.main = "v.nrrd";
    if (coding == "raw" && random.chance(40)) {  // the voxels end with the file
      header += "byte skip: -1\n";
      sample.open_ended = {"v.nrrd"};
      sample.damages.push_back([](auto& files) { files["v.nrrd"].pop_back(); });
    }
    sample.files["v.nrrd"] = header + "\n" + coded;
  } else if (layout == 1) {
    sample.main = "v.nhdr";
    if (coding == "raw" && random.chance(40)) {
      const bool at_end = random.chance(50);
      if (at_end) sample.open_ended = {"v.nhdr", "v.data"};
      header += at_end ? "byte skip: -1\n" : "line skip: 1\nbyte skip: 3\n";
      coded = (at_end ? "anything at all" : "a line\nabc") + coded;
    }
    sample.files["v.nhdr"] = header + "data file: v.data\n";
    sample.files["v.data"] = coded;
    sample.removable.insert("v.data");
  } else {  // a file for each step of the slowest axis
    sample.main = "v.nhdr";
    const int count = axes.back().size;
    const size_t each = coded.size() / static_cast<size_t>(count);
    std::string list;
    for (int i = 0; i < count; ++i) {
      const std::string name = fmt::format("slice_{:03}.raw", 2 * i + 5);
      sample.files[name] = coded.substr(each * static_cast<size_t>(i), each);
      list += name + "\n";
      sample.removable.insert(name);
    }
    header += layout == 2 ? "data file: LIST\n" + list
                          : fmt::format("data file: slice_%03d.raw 5 {} 2\n", 2 * count + 3);
    sample.files["v.nhdr"] = header;
  }
  sample.text = header;
}

/// `text`: the voxels are text.
void add_damages(bool text, Sample& sample) {
  const std::string main = sample.main;
  if (sample.open_ended.empty())
    sample.damages.push_back([=](auto& files) {  // a different size
      std::string& h = files[main];
      const size_t at = h.find("sizes: ") + 7;
      h[at] = h[at] == '2' ? '3' : '2';
    });
  if (text) {
    sample.damages.push_back([=](auto& files) {  // an invalid word among the numbers
      auto& file = files.count("v.data") ? files["v.data"] : files[main];
      file.insert(file.find_last_of(" \n", file.size() - 4) + 1, 1, 'x');
    });
  }
}

}  // namespace

Sample make_nrrd(Random& random) {
  Sample sample;
  const auto type = static_cast<Number>(random.between(0, 9));
  choose_voxels(random, type, sample.truth);
  int step = 0;
  const std::vector<Axis> axes = choose_axes(random, sample, step);
  const char* kind = random.one_of({"time", "list"});
  const std::vector<double> stored = values_of_all_steps(sample.truth, axes, step);

  std::string header = fmt::format("NRRD000{}\n# by a test\n", random.between(1, 5));
  std::string sizes = "sizes:", kinds = "kinds:";
  for (const Axis& axis : axes) {
    sizes += fmt::format(" {}", axis.size);
    kinds += fmt::format(" {}", axis.is_space ? random.one_of({"domain", "space"}) : kind);
  }
  header +=
      fmt::format("type: {}\ndimension: {}\n{}\n", type_name(random, type), axes.size(), sizes);

  header += random.chance(60) ? space_lines(random, axes, kinds, sample.truth)
                              : kinds + "\n" + spacing_lines(random, axes, sample);
  header += "a key:=with a value\n";

  const bool big_endian = random.chance(50);
  const std::string data = binary_of(stored, type, big_endian);
  const char* encoding = random.one_of({"raw", "raw", "gzip", "gz", "ascii", "txt", "hex"});
  const std::string coding = encoding;
  const bool gzip = coding[0] == 'g', text = coding == "ascii" || coding == "txt";
  const std::string coded = gzip              ? gzipped(data)
                            : text            ? text_of(stored, random)
                            : coding == "hex" ? hex_of(data)
                                              : data;
  header += fmt::format("encoding: {}\n", encoding);
  if (bytes_of(type) > 1 || random.chance(30)) {
    header += fmt::format("endian: {}\n", big_endian ? "big" : "little");
  }
  add_files(random, header, coding, coded, axes, sample);
  add_damages(text, sample);
  return sample;
}

}  // namespace isosplat::conformance
