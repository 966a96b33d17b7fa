// SPDX-License-Identifier: Apache-2.0
#include "slave/tools/hit_file.h"

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "common/base/path_suffix.h"

namespace tessera::tools {

Result<HitFile> HitFile::create(const std::string& path) {
  HitFile hits;
  hits.path_ = path;
  hits.unfinished_ = path + "." + std::to_string(getpid()) + ".part";
  hits.is_csv_ = suffix_of(path) == ".csv";
  hits.file_.open(hits.unfinished_, std::ios::binary | std::ios::trunc);
  if (!hits.file_) {
    hits.unfinished_.clear();
    return Status::unavailable(path + ": cannot be written; is its folder there, and yours?");
  }
  if (hits.is_csv_) hits.file_ << "ray,hit,t,prim,u,v,ngx,ngy,ngz\n";
  return hits;
}

HitFile::~HitFile() {
  if (unfinished_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove(unfinished_, ignored);
}

void HitFile::write(std::span<const core::CastHit> hits) {
  for (const core::CastHit& hit : hits) {
    if (is_csv_) {
      std::array<char, 256> line;
      const auto number = static_cast<unsigned long long>(number_++);
      if (!hit.is_hit) {
        std::snprintf(line.data(), line.size(), "%llu,0,,,,,,,\n", number);
      } else {
        std::snprintf(line.data(), line.size(), "%llu,1,%.9g,%u,%.9g,%.9g,%.9g,%.9g,%.9g\n", number,
                      double{hit.t}, hit.primitive, double{hit.u}, double{hit.v},
                      double{hit.normal.x}, double{hit.normal.y}, double{hit.normal.z});
      }
      file_ << line.data();
      continue;
    }
    struct Record {
      std::uint32_t is_hit;
      float t;
      std::uint32_t primitive;
      float rest[5];
    };
    static_assert(sizeof(Record) == 32);
    const Record record{hit.is_hit ? 1u : 0u,
                        hit.t,
                        hit.primitive,
                        {hit.u, hit.v, hit.normal.x, hit.normal.y, hit.normal.z}};
    file_.write(reinterpret_cast<const char*>(&record), sizeof(record));
  }
}

Status HitFile::finish() {
  file_.close();
  std::error_code error;
  if (file_) std::filesystem::rename(unfinished_, path_, error);
  if (!file_ || error) return Status::unavailable(path_ + ": cannot be written; is the disk full?");
  unfinished_.clear();
  return Status::ok();
}

}  // namespace tessera::tools
