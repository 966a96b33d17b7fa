// SPDX-License-Identifier: Apache-2.0
// Faults that tests give to a slave, by options of the daemon that no help shows (--test-...):
// slow, dying or lying, as real slaves are by nature.
#pragma once

namespace tessera::slave {

struct TestHooks {
  int tile_sleep_ms = 0;        // every tile takes at least this long
  int tile_aborted_at = 0;      // the process aborts in its n-th tile; 0: never
  int tile_frozen_at = 0;       // from its n-th tile on, render threads stand still; 0: never
  int frame_aborted_in = -1;    // the process aborts in the tile of that number
  int tile_aborted_in = -1;     // of that frame; -1: in none
  int abort_after_ms = 0;       // of work in that tile
  int tile_wrong_every = 0;     // one of this many tiles has a wrong pixel; 0: none
  bool is_scene_wrong = false;  // it says that it built another scene than the one it was sent
};

}  // namespace tessera::slave
