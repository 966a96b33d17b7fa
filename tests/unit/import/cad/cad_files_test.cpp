// SPDX-License-Identifier: Apache-2.0
// Seven CAD files: no face is lost, the areas of what the patches keep are those that Open CASCADE
// computes from its own faces, and loops are not cut into more segments than the file explains.
#include <gtest/gtest.h>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <TopExp_Explorer.hxx>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "common/scene/validate.h"
#include "master/import/cad/document.h"
#include "master/import/cad/messages.h"
#include "master/import/cad/reader.h"
#include "tests/support/patch_area.h"

namespace tessera::import::cad {
namespace {

struct CadFile {
  const char* name;
  std::size_t faces, parts, instances;
  std::size_t segments;  // at most: those that there are now, and a tenth
};

std::string folder() {
  const char* given = std::getenv("TESSERA_CAD_FILES");
  return given != nullptr ? given : TESSERA_CAD_FILES;
}

class CadFiles : public testing::TestWithParam<CadFile> {};

TEST_P(CadFiles, KeepTheirFacesAndAreas) {
  const std::string path = folder() + "/" + GetParam().name;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  std::vector<PartReport> reports;
  const auto read = read_cad(path, &reports);
  ASSERT_TRUE(read.is_ok()) << read.status().message();
  for (const std::string& line : read->warnings) std::cout << line << "\n";
  ASSERT_TRUE(validate_scene(read->scene).is_ok()) << validate_scene(read->scene).message();
  Result<Document> document = Status::not_found("");
  {
    Messages messages;
    document = std::string(path).find(".iges") != path.npos ? read_iges(path) : read_step(path);
  }
  ASSERT_TRUE(document.is_ok());
  EXPECT_EQ(document->parts.size(), GetParam().parts);
  EXPECT_EQ(read->scene.instances.size(), GetParam().instances);
  if (GetParam().instances == 1) {  // what is up in the file is up in the scene
    const Vec3f up = read->scene.instances[0].object_to_world.direction({0, 0, 1});
    EXPECT_EQ(up.y, 1);
  }
  ASSERT_EQ(document->parts.size(), reports.size());
  std::size_t segments = 0;
  for (const auto& surface : read->scene.surfaces) segments += surface->degrees.size();
  EXPECT_LE(segments, GetParam().segments);
  std::size_t faces = 0;
  double whole_ours = 0, whole_theirs = 0, worst = 0;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    EXPECT_TRUE(reports[i].lost.empty()) << reports[i].lost[0];
    const std::vector<double> areas = test::patch_areas(*read->scene.surfaces[i]);
    if (document->parts[i].shape.ShapeType() == TopAbs_SOLID) {
      GProp_GProps properties;
      BRepGProp::VolumeProperties(document->parts[i].shape, properties, 1e-6);
      // Positive: normals point out.
      EXPECT_NEAR(test::surface_volume(*read->scene.surfaces[i]), properties.Mass(),
                  1e-4 * std::fabs(properties.Mass()))
          << "part " << i;
    }
    std::size_t face_number = 0;
    for (TopExp_Explorer face(document->parts[i].shape, TopAbs_FACE); face.More(); face.Next()) {
      const PartFace& ours = reports[i].faces.at(face_number++);
      double area = 0;
      for (std::size_t k = 0; k < ours.patch_count; ++k) area += areas.at(ours.first_patch + k);
      GProp_GProps properties;
      BRepGProp::SurfaceProperties(face.Current(), properties, 1e-7);
      const double theirs = std::fabs(properties.Mass());
      whole_ours += area, whole_theirs += theirs;
      const double off = std::fabs(area - theirs) / theirs;
      worst = std::max(worst, off);
      if (off > 1e-4) {
        std::cout << GetParam().name << " part " << i << " face " << face_number << " ("
                  << ours.kind << ", " << ours.patch_count << " patches): " << area
                  << " instead of " << theirs << "\n";
      }
    }
    faces += face_number;
  }
  EXPECT_EQ(faces, GetParam().faces);
  std::cout << GetParam().name << ": " << faces << " faces, " << segments << " segments, area "
            << whole_ours << ", off by " << std::fabs(whole_ours - whole_theirs) / whole_theirs
            << " of " << whole_theirs << ", worst face " << worst << "\n";
  EXPECT_LT(std::fabs(whole_ours - whole_theirs), 1e-4 * whole_theirs);
}

INSTANTIATE_TEST_SUITE_P(All, CadFiles,
                         testing::Values(CadFile{"linkrods.step", 37, 1, 1, 6280},
                                         CadFile{"as1-oc-214.stp", 53, 5, 18, 3340},
                                         // 42 solids, one of two lumps, which are two parts.
                                         CadFile{"car-wheel-assembly.step", 322, 43, 43, 5940},
                                         CadFile{"Bottom.step", 323, 1, 1, 4180},
                                         CadFile{"Bottom_nurbs.step", 323, 1, 1, 4450},
                                         CadFile{"Bottom_nurbs.iges", 323, 1, 1, 4620},
                                         CadFile{"bearing.iges", 213, 1, 1, 2120}),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           for (char& c : name)
                             if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
                           return name;
                         });

}  // namespace
}  // namespace tessera::import::cad
