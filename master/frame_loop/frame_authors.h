// SPDX-License-Identifier: Apache-2.0
// Who rendered tiles of which frames, remembered after the frames are gone: when an audit convicts
// a slave of wrong pixels, somebody has to know which pictures to render again.
//
// Threads. One owner. Pure.
// Invariants. (1) Of at most kSessionsMax sessions, the newest, at most kRangesMax ranges of frames
// each are kept, the newest. (2) Frames of a session are added in rising order.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>

#include "common/base/ids.h"

namespace tessera::master {

class FrameAuthors {
 public:
  static constexpr std::size_t kSessionsMax = 8192, kRangesMax = 64;
  static constexpr std::size_t kRangesTold = 8;  // of those in a line

  // The slave is known by this name: its certificate's where there are keys.
  void slave_joined(SessionId session, const std::string& name);
  // A frame that holds tiles of the slave is given away, or may be.
  void add(SessionId session, FrameId frame);

  // Whether the session is, or was, one of the slave of this name.
  bool is_of(SessionId session, const std::string& name) const;
  // The frames of all sessions of the slave, for a person: "3-17, 20"; empty when there are none.
  // Where there are many, the newest are named.
  std::string frames_of(const std::string& name) const;

 private:
  struct Range {
    FrameId first = 0, last = 0;
  };
  struct Author {
    std::string name;
    std::deque<Range> frames;
    bool is_cut = false;  // older ranges were dropped
  };

  std::map<SessionId, Author> authors_;
  std::deque<SessionId> sessions_;  // of authors_, in the order in which they joined
};

}  // namespace tessera::master
