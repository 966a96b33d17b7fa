// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/bvh_build_config.h"

namespace tessera::core {

BvhBuildConfig usual_build(const PrimitiveClipper& clipper) {
  BvhBuildConfig config;
  config.clipper = &clipper;
  config.cuts_max = 0.03f;
  config.only_top_is_cut = true;
  config.cuts_have_to_pay = true;
  return config;
}

BvhBuildConfig spatial_build(const PrimitiveClipper& clipper) {
  BvhBuildConfig config;
  config.clipper = &clipper;
  config.cuts_have_to_pay = true;
  config.leaves_per_block = 2;
  config.reinsertions = 2;
  return config;
}

}  // namespace tessera::core
