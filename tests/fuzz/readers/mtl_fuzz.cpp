// SPDX-License-Identifier: Apache-2.0
// Any bytes as the material file of a good OBJ file give a valid scene, perhaps with warnings.
#include <cstdlib>

#include "common/scene/validate.h"
#include "common/scene_io/scene_reader.h"
#include "tests/fuzz/readers/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string kObj =
      "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl red\nf 1 2 3\nusemtl b\nf 3 2 1\n";
  tessera::test::fuzz_file("a.mtl", data, size);
  const std::string obj = tessera::test::fuzz_file(
      "a.obj", reinterpret_cast<const std::uint8_t*>(kObj.data()), kObj.size());
  const auto read = tessera::read_obj(obj, {});
  if (!read.is_ok() || !tessera::validate_scene(read->scene).is_ok()) std::abort();
  return 0;
}
