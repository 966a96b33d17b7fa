// SPDX-License-Identifier: Apache-2.0
// What a slave takes for a field of CAD files, by what it takes it for:
//
//   cad_memory PLAN   a plan as field.h has it
//
// Prints JSON: bytes of each kind of record, of the whole while it is prepared, and what the master
// reckons of that.
#include <malloc.h>
#include <time.h>

#include <cstdio>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "common/base/json.h"
#include "common/scene/scene_codec.h"
#include "common/scene/scene_footprint.h"
#include "slave/core/primitive/patch/fat_border.h"
#include "slave/core/scene/patch_footprint.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/bench/cad_field/field.h"

namespace tessera::bench {
namespace {

std::uint64_t status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  std::uint64_t kib = 0;
  for (std::string word; status >> word;) {
    if (word == key && status >> kib) break;
  }
  return kib * 1024;
}

double process_cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class T, class Allocator>
std::uint64_t bytes_of(const std::vector<T, Allocator>& items) {
  return items.size() * sizeof(T);
}

void add_store(const core::PatchStore& store, JsonObject& json) {
  std::uint64_t spans = 0, trimmed = 0;
  for (const core::SubPatch& part : store.parts) {
    spans += core::is_fat_border(part) ? 1 : 0;
    trimmed += part.is_trimmed ? 1 : 0;
  }
  json.add("parts", store.parts.size()).add("parts_of_borders", spans);
  json.add("parts_that_trims_cut", trimmed);
  json.add("numbers", bytes_of(store.numbers)).add("patch_records", bytes_of(store.patches));
  json.add("part_records", bytes_of(store.parts));
  std::uint64_t coefficients = 0, pieces = 0, listed = 0, cells = 0, grids = 0, orders = 0,
                masks = 0, borders = 0, all = 0, unshared = 0;
  std::set<const core::TrimLoops*> loops;
  for (const auto& trims : store.trims) {
    if (!trims) continue;
    borders += trims->borders().bytes();
    unshared += trims->loops().bytes();
    if (!loops.insert(&trims->loops()).second) continue;
    const core::TrimCells& of = trims->cells();
    coefficients += bytes_of(of.coefficients);
    pieces += bytes_of(of.pieces);
    listed += bytes_of(of.listed);
    cells += bytes_of(of.cells);
    grids += bytes_of(of.grids);
    orders += bytes_of(of.orders) + bytes_of(of.ranges);
    masks += bytes_of(trims->loops().masks);
    all += trims->loops().bytes();
  }
  json.add("trim_coefficients", coefficients).add("trim_pieces", pieces);
  json.add("trim_listed", listed).add("trim_cells", cells).add("trim_grids", grids);
  json.add("trim_masks", masks)
      .add("trim_orders", orders)
      .add("border_spans", borders)
      .add("trims", all + borders);
  json.add("trims_if_none_were_shared", unshared + borders);
}

Status run(const std::string& path) {
  const auto plan = read_plan(path);
  if (!plan.is_ok()) return plan.status();
  const auto field = make_field(*plan);
  if (!field.is_ok()) return field.status();
  JsonObject json;
  json.add("patches", counts_of(*field).patches);
  {
    const EncodedScene encoded = SceneEncoder().encode(*field);
    std::uint64_t bytes = 0;
    for (const SceneBlock& block : encoded.blocks) bytes += block.bytes->size();
    json.add("blocks", bytes);
    json.add("reckoned", index_bytes_of(encoded, core::PatchFootprint().surface_bytes()));
    json.add("reckoned_without_cutting", index_bytes_of(encoded));
  }
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;
  const std::uint64_t before = status_bytes("VmHWM:");
  const double start = process_cpu_seconds();
  core::BuildOptions options;
  options.threads = 2;
  const auto built = core::PreparedScene::build(*field, options);
  if (!built.is_ok()) return built.status();
  json.add("build_cpu_seconds", process_cpu_seconds() - start);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  json.add("taken_at_the_peak", 0);  // a sanitizer's own memory counts
#else
  json.add("taken_at_the_peak", status_bytes("VmHWM:") - before);
#endif
  malloc_trim(0);
  json.add("taken", status_bytes("VmRSS:") - before);
  json.add("prepared", (*built)->memory_bytes());
  json.add("hierarchy", (*built)->impl().index.memory_bytes());
  if ((*built)->impl().patches) add_store(*(*built)->impl().patches, json);
  std::printf("%s\n", json.text().c_str());
  return Status::ok();
}

}  // namespace
}  // namespace tessera::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: cad_memory PLAN\n");
    return 2;
  }
  const tessera::Status status = tessera::bench::run(argv[1]);
  if (status.is_ok()) return 0;
  std::fprintf(stderr, "cad_memory: %s\n", status.message().c_str());
  return 1;
}
