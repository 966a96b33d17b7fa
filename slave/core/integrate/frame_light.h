// SPDX-License-Identifier: Apache-2.0
// What the tiles of one frame share beyond the scene: its VPLs, made by the first tile that needs
// them.
//
// Threads. Any; the first call of vpls() makes the VPLs, others wait for it.
#pragma once

#include <mutex>
#include <optional>

#include "slave/core/integrate/igi/vpl_set.h"
#include "slave/core/integrate/render_context.h"

namespace tessera::core {

class FrameLight {
 public:
  // Requires: the same scene, tracer and settings at each call. Adds the rays that this call traced
  // to ray_count.
  const VplSets& vpls(const RenderContext& context, std::uint64_t& ray_count) {
    std::call_once(once_, [&] {
      // All tiles take what is made here, so this one may not be left.
      const MetBuilds met(MetBuilds::WhenBusy::kWait);
      sets_.emplace(context.scene, context.tracer, context.settings);
      ray_count += sets_->ray_count();
    });
    return *sets_;
  }

 private:
  std::once_flag once_;
  std::optional<VplSets> sets_;
};

}  // namespace tessera::core
