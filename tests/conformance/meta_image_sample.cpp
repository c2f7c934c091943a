#include <fmt/format.h>

#include "tests/conformance/sample.h"

// Written from MetaIO's description of MetaImage (https://itk.org/Wiki/ITK/MetaIO/Documentation).
namespace isosplat::conformance {
namespace {

const char* type_name(Number type) {
  constexpr const char* kNames[] = {"MET_UCHAR", "MET_CHAR",  "MET_USHORT",     "MET_SHORT",
                                    "MET_UINT",  "MET_INT",   "MET_ULONG_LONG", "MET_LONG_LONG",
                                    "MET_FLOAT", "MET_DOUBLE"};
  return kNames[static_cast<size_t>(type)];
}

/// The lines of sizes, spacing, transform, offset and unit. `times`: steps of the fourth axis, or 1
/// without it.
std::string geometry_lines(Random& random, int times, Truth& truth) {
  const bool has_time = times > 1;
  std::string header;
  std::string sizes = "DimSize =", spacing = "ElementSpacing =", matrix = "TransformMatrix =",
              offset = "Offset =";
  const auto steps = choose_steps(random, true);
  const double unit = random.one_of({1.0, 1.0, 0.001});
  const bool has_matrix = random.chance(75), has_offset = random.chance(80);
  const Vec3d origin = has_offset ? choose_place(random) : Vec3d{0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    const double negative = !has_matrix && random.chance(15) ? -1 : 1;
    const double distance = length(steps[i]) * negative;
    sizes += fmt::format(" {}", truth.sizes[i]);
    spacing += fmt::format(" {:.17g}", distance);
    const Vec3d unit_step = has_matrix
                                ? steps[i] * (1 / distance)
                                : Vec3d{i == 0 ? 1.0 : 0, i == 1 ? 1.0 : 0, i == 2 ? 1.0 : 0};
    matrix += fmt::format(" {:.17g} {:.17g} {:.17g}", unit_step.x, unit_step.y, unit_step.z);
    if (has_time) matrix += " 0";
    truth.steps[i] = unit_step * (distance * unit);
  }
  truth.origin = origin * unit;
  offset += fmt::format(" {:.17g} {:.17g} {:.17g}", origin.x, origin.y, origin.z);
  if (has_time) {
    sizes += fmt::format(" {}", times);
    spacing += " 2.5";
    matrix += " 0 0 0 1";
    offset += " 0";
  }
  header += sizes + "\n" + spacing + "\n";
  if (has_matrix) header += matrix + "\n";
  if (has_offset) header += offset + "\n";
  if (unit != 1 || random.chance(20)) {
    header += fmt::format("DistanceUnits = {}\n", unit == 1 ? "mm" : "um");
  }
  return header;
}

/// Writes the header and the encoded voxels to one file, two, or a file for each step of the
/// slowest axis. `is_plain`: the voxels are binary and not compressed.
void add_files(Random& random, std::string header, std::string data, bool is_plain, int times,
               Sample& sample) {
  const int layout = random.between(0, 3);
  if (layout == 0 || (layout > 1 && !is_plain)) {
    sample.main = "v.mha";
    if (is_plain && random.chance(40)) {  // the voxels end with the file
      header += "HeaderSize = -1\n";
      sample.open_ended = {"v.mha"};
      sample.damages.push_back([](auto& files) { files["v.mha"].pop_back(); });
    }
    sample.files["v.mha"] = header + "ElementDataFile = LOCAL\n" + data;
  } else if (layout == 1) {
    sample.main = "v.mhd";
    if (is_plain && random.chance(50)) {
      const bool at_end = random.chance(50);
      if (at_end) sample.open_ended = {"v.mhd", "v.raw"};
      header += fmt::format("HeaderSize = {}\n", at_end ? -1 : 11);
      data = "12345678901" + data;
    }
    sample.files["v.raw"] = data;
    sample.removable.insert("v.raw");
    sample.files["v.mhd"] = header + "ElementDataFile = v.raw\n";
  } else {
    sample.main = "v.mhd";
    const int count = times > 1 ? times : sample.truth.sizes[2];
    const size_t each = data.size() / static_cast<size_t>(count);
    std::string list;
    for (int i = 0; i < count; ++i) {
      const std::string name = fmt::format("s{:02}.raw", i + 1);
      sample.files[name] = data.substr(each * static_cast<size_t>(i), each);
      list += name + "\n";
      sample.removable.insert(name);
    }
    sample.files["v.mhd"] =
        header + (layout == 2 ? fmt::format("ElementDataFile = LIST{}\n{}",
                                            times > 1 ? " 3" : random.one_of({"", " 2"}), list)
                              : fmt::format("ElementDataFile = s%02d.raw 1 {} 1\n", count));
  }
  sample.text = header;
}

/// `text`: the voxels are text.
void add_damages(bool text, Sample& sample) {
  const std::string main = sample.main;
  if (sample.open_ended.empty())
    sample.damages.push_back([=](auto& files) {
      std::string& h = files[main];
      const size_t at = h.find("DimSize = ") + 10;
      h[at] = h[at] == '2' ? '3' : '2';
    });
  if (text) {
    for (const char* word : {"x", "nanx", "1ee"}) {
      sample.damages.push_back([=](auto& files) {
        auto& file = files.count("v.raw") ? files["v.raw"] : files[main];
        file.insert(file.find_last_of(" \n", file.size() - 4) + 1, word);
      });
    }
  }
}

}  // namespace

Sample make_meta_image(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const auto type = static_cast<Number>(random.between(0, 9));
  choose_voxels(random, type, truth);
  const int times = random.chance(25) ? random.between(2, 3) : 1;
  const int step = random.between(0, times - 1);
  if (times > 1) sample.options.time_step = step;
  std::vector<double> stored;
  for (int t = 0; t < times; ++t) {
    for (const double value : truth.values) stored.push_back(t == step ? value : 5);
  }

  std::string header = random.chance(80) ? "ObjectType = Image\n" : "";
  header += fmt::format("NDims = {}\n", times > 1 ? 4 : 3);
  header += geometry_lines(random, times, truth);
  header += fmt::format("ElementType = {}\n", type_name(type));
  if (random.chance(20)) header += "ElementNumberOfChannels = 1\n";

  const bool big_endian = random.chance(40);
  const int coding = random.between(0, 3);  // 2: compressed, 3: text
  std::string data = binary_of(stored, type, big_endian);
  header += fmt::format("BinaryData = {}\n", coding == 3 ? "False" : "True");
  header += fmt::format("BinaryDataByteOrderMSB = {}\n", big_endian ? "True" : "False");
  if (coding == 2) {
    data = gzipped(data, true);
    header += fmt::format("CompressedData = True\nCompressedDataSize = {}\n", data.size());
  } else if (random.chance(50)) {
    header += "CompressedData = False\n";
  }
  if (coding == 3) data = text_of(stored, random);
  add_files(random, header, data, coding < 2, times, sample);
  add_damages(coding == 3, sample);
  return sample;
}

}  // namespace isosplat::conformance
