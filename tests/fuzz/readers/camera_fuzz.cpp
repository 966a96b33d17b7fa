// SPDX-License-Identifier: Apache-2.0
// Any bytes as a camera file and as camera text are refused, or give a camera for every frame.
#include <cmath>
#include <cstdlib>

#include "common/scene/validate.h"
#include "common/scene_io/camera_file.h"
#include "tests/fuzz/readers/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  const auto path = read_camera_file(test::fuzz_file("a.camera", data, size));
  if (path.is_ok() && !validate_camera(path->at(0)).is_ok()) std::abort();
  if (path.is_ok()) (void)path->at(3.5);
  const auto camera = parse_camera_text(std::string(reinterpret_cast<const char*>(data), size));
  if (camera.is_ok() && std::isnan(camera->vfov_degrees) && validate_camera(*camera).is_ok()) {
    std::abort();
  }
  return 0;
}
