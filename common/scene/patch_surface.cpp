// SPDX-License-Identifier: Apache-2.0
#include "common/scene/patch_surface.h"

namespace tessera {

void PatchCursor::advance() {
  for (std::size_t loop = loop_count(); loop > 0; --loop) {
    for (std::uint32_t i = surface_->segment_counts[first_loop_++]; i > 0; --i)
      first_trim_point_ += surface_->degrees[first_segment_++];
  }
  first_number_ += form().number_count();
  ++patch_;
}

}  // namespace tessera
