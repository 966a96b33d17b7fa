// SPDX-License-Identifier: Apache-2.0
// Files of hits, in the order of the rays. If the name ends in .csv, a file has a header, then
// lines `ray,hit,t,prim,u,v,ngx,ngy,ngz` with 9 significant digits; all behind `hit` is empty for a
// miss. With any other name it has 32-byte records: uint32 hit, float t, uint32 prim, float u, v,
// ngx, ngy, ngz, little-endian.
//
// The file appears under its name when it is whole.
//
// Threads. One.
#pragma once

#include <cstdint>
#include <fstream>
#include <span>
#include <string>

#include "common/base/status.h"
#include "slave/core/scene/ray_caster.h"

namespace tessera::tools {

class HitFile {
 public:
  // Returns: kUnavailable naming the file.
  static Result<HitFile> create(const std::string& path);
  HitFile(HitFile&& other) = default;
  HitFile& operator=(HitFile&&) = delete;
  ~HitFile();  // removes what was not finished

  void write(std::span<const core::CastHit> hits);
  // Returns: kUnavailable when the disk is full, or the like.
  Status finish();

 private:
  HitFile() = default;

  std::string path_, unfinished_;
  std::ofstream file_;
  bool is_csv_ = false;
  std::uint64_t number_ = 0;
};

}  // namespace tessera::tools
