// SPDX-License-Identifier: Apache-2.0
// The suite "update": how soon an application sees what it has changed. It edits a scene of 64
// objects through the session library: the camera, a light, a material, places, vertices; a frame
// of one tile goes ahead of the whole one, so its end is the first right pixel. Each picture is
// compared with that of the same scene which a new session is given in one go.
//
// Threads. One; sessions make their own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::bench {

struct UpdateOptions {
  std::vector<std::uint64_t> triangles;  // empty: 10^4 to 10^7
  std::size_t objects = 64;              // that they consist of
  std::string listen;       // HOST:PORT for slaves; empty: one is started on this machine
  std::string keys_folder;  // of a master; with `listen`
  int slaves = 1;           // waited for before the first frame; with `listen`
  std::string link;         // what the slaves are reached by, for the reader
  std::string only;         // edits with this in their name, beside the camera; empty: all
  int repeats = 7;          // edits of each kind that are measured
  bool is_quick = false;    // small scenes, few edits
};

// Appends one JSON object per scene. Returns: kInternal where a picture differs.
Status run_update_suite(const UpdateOptions& options, std::vector<std::string>& rows);

}  // namespace tessera::bench
