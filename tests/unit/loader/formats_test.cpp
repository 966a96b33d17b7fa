// SPDX-License-Identifier: Apache-2.0
// The real tessera-import reads what files of every format hold. Suffix and content have to agree.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "common/scene/validate.h"
#include "master/loader/load_scene.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

// All files here hold the same red plate, [-1, 1]^2, moved by 1 along the file's third axis.
const std::string kCollada = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_cameras><camera id="cam" name="Eye"><optics><technique_common><perspective>
<yfov sid="yfov">40</yfov><aspect_ratio>1.5</aspect_ratio><znear>0.1</znear><zfar>100</zfar>
</perspective></technique_common></optics></camera></library_cameras>
<library_lights><light id="lamp" name="Lamp"><technique_common><point><color sid="color">10 5 5</color>
<constant_attenuation>0</constant_attenuation><quadratic_attenuation>4</quadratic_attenuation>
</point></technique_common></light></library_lights>
<library_effects><effect id="red-fx"><profile_COMMON><technique sid="common"><lambert><diffuse>
<color sid="diffuse">0.8 0.1 0.1 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="red" name="Red"><instance_effect url="#red-fx"/></material></library_materials>
<library_geometries><geometry id="quad" name="Quad"><mesh><source id="p">
<float_array id="pa" count="12">-1 -1 0 1 -1 0 1 1 0 -1 1 0</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist material="red" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<vcount>4</vcount><p>0 1 2 3</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s" name="s">
<node id="n" name="Plate"><translate>0 0 1</translate><instance_geometry url="#quad"><bind_material><technique_common>
<instance_material symbol="red" target="#red"/></technique_common></bind_material></instance_geometry></node>
<node id="c" name="CamNode"><translate>0 0 6</translate><instance_camera url="#cam"/></node>
<node id="l" name="LampNode"><translate>1 2 4</translate><instance_light url="#lamp"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";

const std::string kFbx = R"(; FBX 7.3.0 project file
FBXHeaderExtension:  {
	FBXHeaderVersion: 1003
	FBXVersion: 7300
}
GlobalSettings:  {
	Version: 1000
	Properties70:  {
		P: "UpAxis", "int", "Integer", "",1
		P: "UpAxisSign", "int", "Integer", "",1
		P: "FrontAxis", "int", "Integer", "",2
		P: "FrontAxisSign", "int", "Integer", "",1
		P: "CoordAxis", "int", "Integer", "",0
		P: "CoordAxisSign", "int", "Integer", "",1
		P: "UnitScaleFactor", "double", "Number", "",1
	}
}
Objects:  {
	Geometry: 10, "Geometry::quad", "Mesh" {
		Vertices: *12 {
			a: -1,-1,0,1,-1,0,1,1,0,-1,1,0
		}
		PolygonVertexIndex: *4 {
			a: 0,1,2,-4
		}
		GeometryVersion: 124
		LayerElementMaterial: 0 {
			Version: 101
			Name: ""
			MappingInformationType: "AllSame"
			ReferenceInformationType: "IndexToDirect"
			Materials: *1 {
				a: 0
			}
		}
		Layer: 0 {
			Version: 100
			LayerElement:  {
				Type: "LayerElementMaterial"
				TypedIndex: 0
			}
		}
	}
	Model: 20, "Model::Plate", "Mesh" {
		Version: 232
		Properties70:  {
			P: "Lcl Translation", "Lcl Translation", "", "A",0,0,1
		}
	}
	Material: 30, "Material::Red", "" {
		Version: 102
		ShadingModel: "lambert"
		MultiLayer: 0
		Properties70:  {
			P: "DiffuseColor", "Color", "", "A",0.8,0.1,0.1
		}
	}
}
Connections:  {
	C: "OO",20,0
	C: "OO",10,20
	C: "OO",30,20
}
)";

const std::string kTextStl =
    "solid plate\nfacet normal 0 0 1\nouter loop\nvertex -1 -1 1\nvertex 1 -1 1\nvertex 1 1 "
    "1\nendloop\n"
    "endfacet\nfacet normal 0 0 1\nouter loop\nvertex -1 -1 1\nvertex 1 1 1\nvertex -1 1 "
    "1\nendloop\n"
    "endfacet\nendsolid plate\n";

// The plate as a binary STL file, whose header begins with the word of the text form, as many do.
std::string binary_stl() {
  std::string bytes = "solid of anything";
  bytes.resize(80);
  const auto put = [&bytes](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  put(std::uint32_t{2});
  const float corners[2][9] = {{-1, -1, 1, 1, -1, 1, 1, 1, 1}, {-1, -1, 1, 1, 1, 1, -1, 1, 1}};
  for (const auto& facet : corners) {
    for (int i = 0; i < 3; ++i) put(0.0f);
    for (const float x : facet) put(x);
    put(std::uint16_t{0});
  }
  return bytes;
}

class Formats : public ::testing::Test {
 protected:
  Result<LoadedScene> load(const std::string& name, const std::string& bytes) {
    return load_scene(folder_.write(name, bytes), [](const std::string&, double) { return true; });
  }
  std::string refusal(const std::string& name, const std::string& bytes) {
    const auto loaded = load(name, bytes);
    EXPECT_FALSE(loaded.is_ok()) << name;
    return loaded.is_ok() ? "" : loaded.status().message();
  }
  const test::TempFolder folder_;
};

void expect_plate(const Scene& scene, float x, float y, float z) {
  const Bounds3f bounds = scene_bounds(scene);
  EXPECT_EQ(scene.triangle_count(), 2u);
  EXPECT_NEAR(bounds.extent().x, x, 1e-5);
  EXPECT_NEAR(bounds.extent().y, y, 1e-5);
  EXPECT_NEAR(bounds.extent().z, z, 1e-5);
}

TEST_F(Formats, Collada) {
  const auto loaded = load("plate.dae", kCollada);
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  const Scene& scene = loaded->scene;
  expect_plate(scene, 2, 0, 2);  // z of the file is up
  EXPECT_NEAR(scene_bounds(scene).lower.y, 1, 1e-5);
  EXPECT_NEAR(scene.materials[scene.meshes[0]->materials[0]].albedo.x, 0.8f, 1e-6);
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_NEAR(scene.cameras[0].camera.eye.y, 6, 1e-4);
  EXPECT_NEAR(scene.cameras[0].camera.target.y, 5, 1e-4);
  EXPECT_NEAR(scene.cameras[0].camera.vfov_degrees, 40, 0.1);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_NEAR(scene.lights[0].position.y, 4, 1e-4);
  EXPECT_NEAR(scene.lights[0].intensity.x, 10 / 4.0, 1e-5);
  EXPECT_TRUE(loaded->warnings.empty()) << loaded->warnings[0];
}

TEST_F(Formats, Fbx) {
  const auto loaded = load("plate.FBX", kFbx);
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  expect_plate(loaded->scene, 2, 2, 0);
  const Scene& scene = loaded->scene;
  EXPECT_NEAR(scene_bounds(scene).lower.z, 1, 1e-5);
  EXPECT_NEAR(scene.materials[scene.meshes[0]->materials[0]].albedo.y, 0.1f, 1e-6);
}

TEST_F(Formats, StlOfBothForms) {
  for (const std::string& bytes : {kTextStl, binary_stl()}) {
    const auto loaded = load("plate.stl", bytes);
    ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
    expect_plate(loaded->scene, 2, 2, 0);
  }
}

TEST_F(Formats, PatchesStayPatches) {
  const std::string bytes =
      "1\n1 1\n-1 -1 1\n-1 1 1\n1 -1 1\n1 1 1\ntrim 1 out\nloop 3 1\n0 0\n1 0\n0 1\n";
  const auto loaded = load("plate.bpt", bytes);
  ASSERT_TRUE(loaded.is_ok()) << loaded.status().message();
  EXPECT_EQ(loaded->scene.patch_count(), 1u);
  EXPECT_EQ(loaded->scene.triangle_count(), 0u);
  EXPECT_EQ(loaded->scene.surfaces.at(0)->patches, (std::vector<PatchForm>{{1, 1, 0, 1}}));
  EXPECT_EQ(loaded->scene.surfaces[0]->trim_points.size(), 3u);
  EXPECT_EQ(scene_bounds(loaded->scene).extent(), (Vec3f{2, 2, 0}));
  EXPECT_NE(refusal("a.bpt", "1\n0 3\n").find("a.bpt:2: patch 0: degrees must lie in 1 to 15"),
            std::string::npos);
  EXPECT_NE(refusal("a.stl", bytes).find("is a file of Bezier patches by its content; rename it"),
            std::string::npos);
  EXPECT_NE(refusal("a.bpt", "v 0 0 0\n").find("is an OBJ file by its content"), std::string::npos);
}

// The content of a file decides what it is; a name that says something else is refused with a line.
TEST_F(Formats, SuffixAndContentHaveToAgree) {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  EXPECT_NE(refusal("a.gltf", obj).find("is an OBJ file by its content; rename it to"),
            std::string::npos);
  EXPECT_NE(refusal("a.fbx", kCollada).find("is a COLLADA file by its content"), std::string::npos);
  EXPECT_NE(refusal("a.dae", kFbx).find("is an FBX file by its content"), std::string::npos);
  EXPECT_NE(refusal("a.obj", binary_stl()).find("is an STL file by its content"),
            std::string::npos);
  EXPECT_NE(refusal("a.stl", "\x89PNG\r\n").find("is a PNG picture"), std::string::npos);
  EXPECT_NE(
      refusal("a.glb", "<html><body>404</body>").find("is a web page: the download has failed"),
      std::string::npos);
  EXPECT_NE(
      refusal("a.blend", obj).find("unknown suffix '.blend'; known are .obj, .ply, .stl, .gltf"),
      std::string::npos);
}

TEST_F(Formats, RandomBytesReachNoReader) {
  std::string bytes(4096, '\0');
  std::uint32_t state = 1;
  for (char& c : bytes) c = static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  for (const char* name :
       {"a.obj", "a.ply", "a.stl", "a.gltf", "a.glb", "a.fbx", "a.dae", "a.bpt"}) {
    EXPECT_NE(refusal(name, bytes).find("the file is damaged or something else"), std::string::npos)
        << name;
  }
}

TEST_F(Formats, CutFilesAreOneLine) {
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"a.dae", kCollada},
                                    {"a.fbx", kFbx},
                                    {"a.stl", binary_stl()},
                                    {"a.bpt", "1\n1 1\n-1 -1 1\n-1 1 1\n1 -1 1\n1 1 1\n"}}) {
    for (const double share : {0.3, 0.6, 0.9}) {
      const std::string line = refusal(
          name,
          bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
      EXPECT_NE(line.find(name), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
  }
}

}  // namespace
}  // namespace tessera::master
