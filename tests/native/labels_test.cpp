// Tables of labels: names and colours, also of damaged files.

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "native/labels/cie_lab.h"
#include "native/labels/label_colours.h"
#include "native/labels/label_table.h"
#include "tests/native/test_files.h"

namespace isosplat {
namespace {

using test::TempFolder;
using test::write_file;

std::string message_of(const Result<LabelTable>& table) {
  return table ? "" : table.error().message;
}

TEST(Labels, CsvNamesItsColumns) {
  const auto table = parse_csv_table(
      "# organs\nname,Value,r,g,b,a\r\n\"liver, \"\"left\"\"\",3,255,0,51,102\nspleen,-7,,,\n\n");
  ASSERT_TRUE(table) << message_of(table);
  ASSERT_EQ(table->size(), 2u);
  EXPECT_EQ(table->at(3).name, "liver, \"left\"");
  EXPECT_FLOAT_EQ((*table->at(3).colour)[2], 0.2f);
  EXPECT_FLOAT_EQ(table->at(3).opacity, 0.4f);
  EXPECT_EQ(table->at(-7).name, "spleen");
  EXPECT_FALSE(table->at(-7).colour);
  EXPECT_EQ(message_of(parse_csv_table("a,b\n1,2\n")).substr(0, 7), "line 1:");
  EXPECT_NE(message_of(parse_csv_table("value,name\n1.5,x")).find("line 2: expected an integer"),
            std::string::npos);
  EXPECT_FALSE(parse_csv_table("value,r,g,b\n1,256,0,0"));
  EXPECT_FALSE(parse_csv_table("value,name\n1,\"x"));
}

TEST(Labels, ItkSnapHasVisibilityAndOpacity) {
  const auto table = parse_itk_snap_table(
      "# ITK-SnAP Label Description File\n    0     0    0    0        0  0  0    \"Clear Label\"\n"
      "    1   255    0    0        1  1  1    \"Left lung\"\n"
      "    2   0  255    0      0.5  1  0    \"Right\"\n");
  ASSERT_TRUE(table) << message_of(table);
  EXPECT_EQ(table->at(1).name, "Left lung");
  EXPECT_FALSE(table->at(2).visible);
  EXPECT_EQ(table->at(2).opacity, 0.5f);
  EXPECT_FALSE(is_zero_a_label(*table));
  EXPECT_FALSE(parse_itk_snap_table("1 2 3 4 5 6 7 name"));
  EXPECT_FALSE(parse_itk_snap_table("1 2 3 4 5 6 \"name\""));
}

TEST(Labels, FreeSurferIsOpaque) {
  const auto table = parse_freesurfer_table(
      "#No. Label Name:   R G B A\n0   Unknown   0   0   0   0\n"
      "17  Left-Hippocampus  220 216 20  0\n");
  ASSERT_TRUE(table) << message_of(table);
  EXPECT_EQ(table->at(17).name, "Left-Hippocampus");
  EXPECT_EQ(table->at(17).opacity, 1);
  EXPECT_FALSE(is_zero_a_label(*table));
  EXPECT_FALSE(parse_freesurfer_table("17 Left Hippocampus 220 216 20 0 0"));
}

TEST(Labels, TablesOfWorkbenchAndSlicerAreRead) {
  const LabelTable table = parse_workbench_table(
      "<?xml version=\"1.0\"?><CaretExtension><LabelTable>"
      "<Label Key=\"0\" Red=\"1\" Green=\"1\" Blue=\"1\" Alpha=\"0\">?\?\?</Label>"
      "<Label Key=\"5\" Red=\"0.5\" Green=\"0\" Blue=\"1\" Alpha=\"1\"><![CDATA[]]>A &amp; "
      "B</Label>"
      "<Label Key=\"x\">no</Label></LabelTable></CaretExtension>");
  ASSERT_EQ(table.size(), 2u);
  EXPECT_FLOAT_EQ((*table.at(5).colour)[0], 0.5f);
  EXPECT_FALSE(is_zero_a_label(table));
  const std::string header =
      "NRRD0004\ntype: uint8\nSegment0_Name:=Liver\nSegment0_LabelValue:=2\n"
      "Segment0_Color:=0.25 0.5 1\nSegment0_Layer:=0\nSegment1_Name:=Tumour\n"
      "Segment1_LabelValue:=2\nSegment1_Layer:=1\nSegmentX_Name:=no\n\nSegment2_LabelValue:=9\n";
  const LabelTable first = parse_slicer_segments(header, 0),
                   second = parse_slicer_segments(header, 1);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first.at(2).name, "Liver");
  EXPECT_EQ((*first.at(2).colour)[1], 0.5f);
  EXPECT_EQ(second.at(2).name, "Tumour");
}

TEST(Labels, CieLabBecomesSrgb) {
  const auto check = [](std::array<double, 3> lab, std::array<float, 3> srgb) {
    const auto found = srgb_of_cie_lab(lab);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], srgb[i], 0.004) << i;
  };
  check({100, 0, 0}, {1, 1, 1});
  check({0, 0, 0}, {0, 0, 0});
  check({53.585, 0, 0}, {0.5, 0.5, 0.5});
  // The primaries of sRGB in L*a*b* for D50.
  check({54.29, 80.81, 69.89}, {1, 0, 0});
  check({87.82, -79.29, 80.99}, {0, 1, 0});
  check({29.57, 68.30, -112.03}, {0, 0, 1});
  for (const float c : srgb_of_cie_lab({100, 127, -128})) EXPECT_TRUE(c >= 0 && c <= 1);
}

TEST(Labels, ZeroIsALabelIfATableNamesIt) {
  EXPECT_FALSE(is_zero_a_label({}));
  EXPECT_TRUE(is_zero_a_label({{0, {"bone", {}, 1, true}}}));
  EXPECT_FALSE(is_zero_a_label({{0, {"bone", {}, 0, true}}}));
  EXPECT_FALSE(is_zero_a_label({{0, {"Background", {}, 1, true}}}));
}

TEST(Labels, FormatsAreRecognized) {
  const TempFolder folder;
  const auto name_of_one = [&](const std::string& text) {
    write_file(folder / "table", text);
    const auto table = read_label_table(folder / "table");
    return table ? table->at(1).name : table.error().message;
  };
  EXPECT_EQ(name_of_one("value,name\n1,a\n"), "a");
  EXPECT_EQ(name_of_one("\xEF\xBB\xBFvalue,name\n1,a\n"), "a");
  EXPECT_EQ(name_of_one("# x\n1 1 2 3 1 1 1 \"b\"\n"), "b");
  EXPECT_EQ(name_of_one("1 c 1 2 3 0\n"), "c");
  EXPECT_EQ(name_of_one("<LabelTable><Label Key=\"1\">d</Label></LabelTable>"), "d");
  EXPECT_NE(name_of_one("").find("found no label"), std::string::npos);
  EXPECT_FALSE(read_label_table(folder / "missing"));
}

TEST(Labels, LongNamesAreTruncatedAndControlCharactersRemoved) {
  std::string name("a\x1b[31m");
  while (name.size() < 1000) name.append("ü");
  const auto table = parse_csv_table(std::string("value,name\n1,").append(name));
  ASSERT_TRUE(table);
  const std::string& cut = table->at(1).name;
  EXPECT_LE(cut.size(), kMaxLabelName);
  EXPECT_EQ(cut.find('\x1b'), std::string::npos);
  EXPECT_EQ(cut.substr(cut.size() - 2), "ü");
  std::string many = "value\n";
  for (size_t i = 0; i <= kMaxTableEntries; ++i) many.append(std::to_string(i)).append("\n");
  EXPECT_NE(message_of(parse_csv_table(many)).find("at most 65536"), std::string::npos);
}

TEST(Labels, DamagedTablesAreErrorsOrTables) {
  const std::vector<std::string> texts{
      "value,name,r,g,b,a\n1,\"x\",1,2,3,4\n2,y,1,2,3,4\n",
      "1 1 2 3 1 1 1 \"b\"\n2 1 2 3 1 1 1 \"c\"\n", "1 c 1 2 3 0\n2 d 1 2 3 0\n",
      "<LabelTable><Label Key=\"1\" Red=\"1\">d</Label></LabelTable>",
      "NRRD\nSegment0_Name:=Liver\nSegment0_LabelValue:=2\nSegment0_Color:=0.25 0.5 1\n\n"};
  std::mt19937 random(1);
  for (int i = 0; i < 3000; ++i) {
    std::string text = texts[random() % texts.size()];
    for (int edits = 0; edits < 3; ++edits) {
      const size_t at = random() % text.size();
      if (random() % 2 == 0)
        text[at] = static_cast<char>(random() % 256);
      else
        text.erase(at, random() % 4);
      if (text.empty()) text.push_back('x');
    }
    for (const auto& table :
         {parse_csv_table(text), parse_itk_snap_table(text), parse_freesurfer_table(text)}) {
      EXPECT_NE(table.has_value(), message_of(table) != "");
    }
    EXPECT_LE(parse_workbench_table(text).size(), 2u);
    EXPECT_LE(parse_slicer_segments(text, 0).size(), 2u);
  }
}

TEST(Labels, DefaultColoursDiffer) {
  std::set<std::array<int, 3>> seen;
  for (int64_t value = 1; value <= 105; ++value) {
    const auto colour = label_colour(value);
    const auto next = label_colour(value + 1);
    float difference = 0;
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_GE(colour[i], 0);
      EXPECT_LE(colour[i], 1);
      difference += std::abs(colour[i] - next[i]);
    }
    EXPECT_GT(difference, 0.2f) << value;
    seen.insert({static_cast<int>(colour[0] * 255), static_cast<int>(colour[1] * 255),
                 static_cast<int>(colour[2] * 255)});
  }
  EXPECT_EQ(seen.size(), 105u);
}

}  // namespace
}  // namespace isosplat
