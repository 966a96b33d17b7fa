// SPDX-License-Identifier: Apache-2.0
// CAD files that are cut off, empty, go round in a circle or have nothing but curves get one line.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

#include "master/import/cad/reader.h"
#include "tests/support/temp_folder.h"
#include "tests/support/written_cad.h"

namespace tessera::import::cad {
namespace {

constexpr const char* kHead =
    "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
    "FILE_NAME('','',(''),(''),'','','');\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n";
constexpr const char* kEnd = "ENDSEC;\nEND-ISO-10303-21;\n";

std::string refusal(const std::string& name, const std::string& text) {
  const test::TempFolder folder;
  const std::string path = folder.path() + "/" + name;
  std::ofstream(path, std::ios::binary) << text;
  const auto read = read_cad(path);
  if (read.is_ok()) return "was read";
  const std::string& message = read.status().message();
  EXPECT_EQ(message.find('\n'), message.npos);
  EXPECT_TRUE(message.starts_with(path + ": ")) << message;
  return message.substr(std::min(path.size() + 2, message.size()));
}

std::string card(const std::string& text, char section, int number) {
  char line[96];
  std::snprintf(line, sizeof line, "%-72s%c%7d\n", text.c_str(), section, number);
  return line;
}

// Lines of IGES, and nothing else.
std::string iges_lines(int count) {
  std::string text = card("", 'S', 1);
  text += card("1H,,1H;,4Htest,5Hx.igs,4Htest,4Htest,32,38,6,308,15,4Htest,1.,2,2HMM,1,", 'G', 1);
  text += card("0.01,15H20261125.000000,0.0001,100.,4Htest,4Htest,11,0,", 'G', 2);
  text += card("15H20261125.000000;", 'G', 3);
  std::string places;
  for (int i = 0; i < count; ++i) {
    char line[96];
    std::snprintf(line, sizeof line, "%8d%8d%8d%8d%8d%8d%8d%8d%s", 110, i + 1, 0, 0, 0, 0, 0, 0,
                  "00000000");
    text += card(line, 'D', 2 * i + 1);
    std::snprintf(line, sizeof line, "%8d%8d%8d%8d%8d", 110, 0, 0, 1, 0);
    text += card(line, 'D', 2 * i + 2);
    std::snprintf(line, sizeof line, "110,%d.,0.,0.,%d.,1.,0.;", i, i);
    char place[128];
    std::snprintf(place, sizeof place, "%-64s%8d", line, 2 * i + 1);
    places += card(place, 'P', i + 1);
  }
  char end[96];
  std::snprintf(end, sizeof end, "S%7dG%7dD%7dP%7d", 1, 3, 2 * count, count);
  return text + places + card(end, 'T', 1);
}

TEST(CadRefusals, NameWhatIsWrong) {
  const std::string head = kHead, end = kEnd;
  EXPECT_EQ(refusal("a.step", head), "is cut off: its end is missing");
  EXPECT_EQ(refusal("a.stp", head + end), "no surfaces");
  EXPECT_EQ(refusal("a.step", head + "#1=CARTESIAN_POINT('',(0.,0.,0.));\n" + end), "no surfaces");
  EXPECT_EQ(refusal("a.igs", iges_lines(12).substr(0, 600)), "is cut off: its end is missing");
  EXPECT_EQ(refusal("x.igs", iges_lines(12)), "no surfaces, only 12 curves");
}

TEST(CadRefusals, FilesThatAreNotThere) {
  for (const std::string name : {"--help", "none.step", "none.igs"}) {
    const auto read = read_cad(name);
    ASSERT_FALSE(read.is_ok());
    EXPECT_EQ(read.status().message(), name + ": cannot be opened");
  }
}

TEST(CadRefusals, SolidsWithoutExtent) {
  std::string text = test::step_text(test::tray());
  ASSERT_FALSE(text.empty());
  // All points of space, which have three coordinates, become one.
  const std::string begin = "CARTESIAN_POINT('',(";
  for (std::size_t at = text.find(begin); at != text.npos; at = text.find(begin, at + 1)) {
    const std::size_t first = at + begin.size(), size = text.find(')', first) - first;
    const std::string numbers = text.substr(first, size);
    if (std::ranges::count(numbers, ',') == 2) text.replace(first, size, "7.,7.,7.");
  }
  const std::string said = refusal("a.step", text);
  EXPECT_TRUE(said.starts_with("no face is left: face 1 (")) << said;
}

TEST(CadRefusals, FilesCutAnywhere) {
  const std::string step = test::step_text(test::tray());
  const std::string iges = iges_lines(12);
  for (std::size_t i = 1; i < 20; ++i) {
    EXPECT_EQ(refusal("a.step", step.substr(0, step.size() * i / 20)),
              "is cut off: its end is missing");
    EXPECT_EQ(refusal("a.igs", iges.substr(0, iges.size() * i / 20)),
              "is cut off: its end is missing");
  }
}

TEST(CadRefusals, FindCircles) {
  const std::string shell = "#1=CLOSED_SHELL('',(#2));\n#2=FACE_OUTER_BOUND('',#1,.T.);\n";
  EXPECT_NE(refusal("a.step", kHead + shell + kEnd).find("refers to itself by way of others"),
            std::string::npos);
  const std::string product = "=PRODUCT_DEFINITION('','',$,$);\n";
  const std::string usages =
      "#3=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','','',#1,#2,$);\n"
      "#4=NEXT_ASSEMBLY_USAGE_OCCURRENCE('2','','',#2,#1,$);\n";
  EXPECT_EQ(refusal("a.step", kHead + ("#1" + product) + "#2" + product + usages + kEnd),
            "an assembly is a part of itself by way of others");
}

}  // namespace
}  // namespace tessera::import::cad
