// SPDX-License-Identifier: Apache-2.0
// Any bytes as a glTF file, through the reader alone (pictures are not decoded), give a valid scene
// or one line, never an index out of range.
#include <cstdlib>
#include <new>

#include "common/scene/validate.h"
#include "master/import/gltf/reader.h"
#include "tests/fuzz/readers/fuzz_file.h"

namespace {

tessera::Result<std::shared_ptr<const tessera::Texture>> one_texel(std::span<const std::byte>) {
  auto texture = std::make_shared<tessera::Texture>();
  texture->width_px = texture->height_px = 1;
  texture->rgba = {255, 128, 64, 32};
  return std::shared_ptr<const tessera::Texture>(std::move(texture));
}

bool is_one_line(const std::string& text) {
  return !text.empty() && text.find('\n') == std::string::npos;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string path = tessera::test::fuzz_file("a.gltf", data, size);
  try {
    const auto read = tessera::import::read_gltf(path, one_texel);
    if (!read.is_ok()) {
      if (!is_one_line(read.status().message())) std::abort();
      return 0;
    }
    for (const std::string& warning : read->warnings) {
      if (!is_one_line(warning)) std::abort();
    }
    if (const auto status = tessera::validate_scene(read->scene); !status.is_ok()) {
      // Numbers without a limit in the format may be beyond ours; the next check says so then.
      if (status.code() != tessera::StatusCode::kResourceExhausted &&
          status.message().find("too large") == std::string::npos)
        std::abort();
    }
  } catch (const std::bad_alloc&) {  // the program says so in its line
  }
  return 0;
}
