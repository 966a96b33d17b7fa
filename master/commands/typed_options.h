// SPDX-License-Identifier: Apache-2.0
// Option values as a person typed them, and what makes MasterOptions of them. Nothing here knows
// the library that takes the command line apart.
//
// Threads. Pure functions, except that config and scene names are looked up.
#pragma once

#include <cstdint>
#include <string>

#include "master/commands/options.h"

namespace tessera::master {

struct TypedOptions {
  std::string size, frames,
      renderer = "igi", pixels, isa = "auto", isa_policy = "same", pixel_coding = "auto",
      relay = "on", tile = "auto", samples = "auto", clamp = "auto", prefetch = "auto",
      heartbeat = "250", heartbeats_missed = "4", schedule = "dynamic", faulty_pixels = "colour",
      scene_transfer = "async", log_level = "info", log_format = "text", environment, config,
      light = "auto", background = "auto", exposure = "auto", tone = "agx", aov,
      patch_method = "auto";
  int local = kLocalAuto;
  std::uint32_t threads = 0;

  static constexpr int kLocalAuto = -1;  // one when nothing else gives slaves
};

// Completes `options`, whose command is set, from `typed`. Returns: kInvalidArgument naming the
// option and what it takes.
Status check_options(const TypedOptions& typed, MasterOptions& options);

}  // namespace tessera::master
