// SPDX-License-Identifier: Apache-2.0
// Who a slave is, whichever session it has.
//
// Threads. A plain value.
#pragma once

#include <cstdint>
#include <string>

namespace tessera::master {

struct SlaveIdentity {
  std::string name;            // for people
  std::string key;             // its certificate's name; empty without keys
  std::uint64_t instance = 0;  // of its process, random; 0: the slave does not say

  // What tells this slave from every other one.
  const std::string& id() const { return key.empty() ? name : key; }
  // Whether the very process that `other` was is here again. A process that says no number never
  // is: it is taken for one that was started anew.
  bool is_same_process(const SlaveIdentity& other) const {
    return instance != 0 && instance == other.instance && id() == other.id();
  }
};

// How a slave's session ended.
enum class SlaveEnd {
  kLost,      // without a word: one of the tiles that it held may be why
  kLeft,      // in order
  kExpelled,  // for what it said or sent
};

}  // namespace tessera::master
