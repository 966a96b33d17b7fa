// SPDX-License-Identifier: Apache-2.0
// Which slave sent a result of a tile, for as long as the tile's frame is open: a slave that comes
// back in another session is the same slave, and one that is gone may still be judged.
//
// Threads. A plain value.
#pragma once

#include <string>

#include "common/base/ids.h"
#include "master/schedule/slave_identity.h"

namespace tessera::master {

struct ResultAuthor {
  SessionId session = 0;  // that sent the result
  SessionId newest = 0;   // of the same slave; 0: it is gone
  std::string id{};       // SlaveIdentity::id(); empty until `session` has ended

  static ResultAuthor of(SessionId session) { return {session, session}; }
  void left(SessionId gone, const SlaveIdentity& slave) {
    if (newest != gone) return;
    newest = 0;
    id = slave.id();
  }
  void joined(SessionId here, const SlaveIdentity& slave) {
    if (newest == 0 && id == slave.id()) newest = here;
  }
};

}  // namespace tessera::master
