// SPDX-License-Identifier: Apache-2.0
// Writes the scene blocks of a field of CAD files (field.h). It takes the place of tessera-import
// (the variable TESSERA_IMPORT names it):
//
//   TESSERA_IMPORT=build/release/bin/cad_field tessera-master render field.step -o field.png
//
// What was made is printed as JSON on standard error.
#include <unistd.h>

#include <cstdio>
#include <string>

#include "common/base/json.h"
#include "common/scene/scene_stream.h"
#include "tests/bench/cad_field/field.h"

namespace tessera::bench {
namespace {

Status run(const std::string& path) {
  const auto plan = read_plan(path);
  if (!plan.is_ok()) return plan.status();
  const auto field = make_field(*plan);
  if (!field.is_ok()) return field.status();
  const FieldCounts counts = counts_of(*field);
  SceneEncoder encoder;
  EncodedScene encoded = encoder.encode(*field);
  const auto bytes = encode_scene_stream({std::move(encoded), {}});
  JsonObject json;
  json.add("arrange", plan->is_flat ? "flat" : "instances").add("surfaces", field->surfaces.size());
  json.add("instances", field->instances.size()).add("patches", counts.patches);
  json.add("patches_with_loops", counts.patches_with_loops).add("loops", counts.loops);
  json.add("segments", counts.segments).add("block_bytes", bytes.size());
  std::fprintf(stderr, "%s\n", json.text().c_str());
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = ::write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (written <= 0) return Status::resource_exhausted(path + ": cannot hand over the scene");
    done += static_cast<std::size_t>(written);
  }
  return Status::ok();
}

}  // namespace
}  // namespace tessera::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: cad_field FILE\n");
    return 2;
  }
  const tessera::Status status = tessera::bench::run(argv[argc - 1]);
  if (status.is_ok()) return 0;
  std::fprintf(stderr, "tessera-import: %s\n", status.message().c_str());
  return 1;
}
