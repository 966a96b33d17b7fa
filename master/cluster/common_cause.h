// SPDX-License-Identifier: Apache-2.0
// Says why no slave is left, where all of them were lost in one way at one time: then it is not
// the slaves that are ill, but what all of them have in common, the master's own link or port.
//
// Threads. Pure: times go in. Io thread only.
//
// Invariants. (1) It speaks only while no slave is here. (2) One loss of another kind in the same
// time, as of a slave that crashed, and it says nothing. (3) At most kLossesMax losses are kept.
#pragma once

#include <cstddef>
#include <deque>
#include <string>

#include "common/base/clock.h"

namespace tessera::master {

enum class LossKind {
  kOther,    // it closed, crashed, hung, left or was expelled
  kSilent,   // nothing was heard of it
  kUnheard,  // its packets came, and what was sent to it did not arrive there
};

class CommonCause {
 public:
  static constexpr std::size_t kLossesMax = 4096;  // as many as slaves (kConnectionsMax)

  // `together`: losses that are not further apart than this may be of one cause.
  explicit CommonCause(Duration together) : together_(together) {}

  // `left`: slaves that are still here. Returns: whether there is a new thing to say.
  bool lost(LossKind kind, std::size_t left, TimePoint now);
  void joined();

  // For a person, without what to do about slaves; empty where nothing is known.
  const std::string& text() const { return text_; }

 private:
  struct Loss {
    LossKind kind;
    TimePoint at;
  };

  const Duration together_;
  std::deque<Loss> losses_;  // oldest first
  std::string text_;
};

}  // namespace tessera::master
