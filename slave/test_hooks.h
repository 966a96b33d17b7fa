// SPDX-License-Identifier: Apache-2.0
// What tests make of a slave, by options of the daemon that no help shows (--test-...): slow, dying
// or lying, as real ones are by nature.
#pragma once

namespace tessera::slave {

struct TestHooks {
  int tile_sleep_ms = 0;    // every tile takes at least so long
  int tile_aborted_at = 0;  // the process aborts in its n-th tile; 0: never
  int tile_wrong_every =
      0;  // of so many tiles one has a pixel that is not what it renders; 0: none
  bool is_scene_wrong = false;  // it says that it built another scene than the one it was sent
};

}  // namespace tessera::slave
