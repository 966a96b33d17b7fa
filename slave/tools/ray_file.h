// SPDX-License-Identifier: Apache-2.0
// Files of rays. If the name ends in .csv, a file has lines `ox,oy,oz,dx,dy,dz,tmin,tmax`; a header
// line may come first, and empty lines are passed over. With any other name it has little-endian
// float32, 8 to a ray. Numbers may be infinite or NaN; the caster decides what that means.
//
// Threads. One.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "slave/core/scene/ray_caster.h"

namespace tessera::tools {

class RayFile {
 public:
  // Returns: kNotFound, kInvalidArgument naming the file and what is wrong with it.
  static Result<RayFile> open(const std::string& path);

  // Reads the next rays, at most count_max; empty at the end. Returns: kInvalidArgument naming file
  // and line.
  Result<std::vector<core::CastRay>> read(std::size_t count_max);

 private:
  Status read_line(const std::string& line, std::vector<core::CastRay>& rays);

  std::string path_;
  std::ifstream file_;
  bool is_csv_ = false;
  std::uint64_t line_ = 0;
};

}  // namespace tessera::tools
