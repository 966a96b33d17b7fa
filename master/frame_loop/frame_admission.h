// SPDX-License-Identifier: Apache-2.0
// The line of submitted frames in front of the memory for their pixels. A frame whose pixels fit
// goes on at once; one that does not, but would if those before it were over, waits for them; one
// that cannot fit is refused, with what it needs and what is there. So a frame that is too large
// costs that frame, and not the master.
//
// Pages of pixels take memory as tiles are written (UninitializedAllocator), so what frames in work
// have not written yet is counted as promised.
//
// Threads. One owner. Pure: the room is asked for through a function.
// Invariants. (1) Frames leave in the order in which they came. (2) None waits for longer than
// kWaitMax after the one before it has left, so that an application that keeps its pictures hears
// why it gets no more.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include "common/base/clock.h"
#include "common/base/ids.h"

namespace tessera::master {

// Bytes of pixels: `promised` to frames in work and not written yet; `written`, also those of
// finished frames that somebody still holds.
struct FrameHoldings {
  std::uint64_t promised = 0, written = 0;
};

class FrameAdmission {
 public:
  static constexpr std::chrono::seconds kWaitMax{60};
  // Who drops a picture gives its memory back a moment later: so long must a frame be found not to
  // fit, whatever others give back, before it is refused.
  static constexpr std::chrono::seconds kHopelessFor{1};
  // Left for what is no pixels of frames: results on their way, queues of links.
  static constexpr std::uint64_t kReserveBytes = std::uint64_t{32} << 20;

  // Returns: how many bytes this process may take now; nothing where no limit is known.
  using Room = std::function<std::optional<std::uint64_t>()>;
  explicit FrameAdmission(Room room) : room_(std::move(room)) {}

  void add(FrameId frame, std::uint64_t needed_bytes, TimePoint now);
  // The frame leaves as cancelled when its turn comes. Returns: false for one that is not in line.
  bool cancel(FrameId frame);
  bool is_empty() const { return line_.empty(); }

  enum class Verdict { kTaken, kCancelled, kRefused };
  struct Decision {
    FrameId frame = 0;
    Verdict verdict = Verdict::kTaken;
    std::uint64_t needed_bytes = 0, free_bytes = 0;  // kRefused
  };
  // Takes the first frame out of the line. Returns: nothing when there is none, or when it has to
  // wait.
  std::optional<Decision> next(const FrameHoldings& holdings, TimePoint now);

  // What may be taken by others than frames now; nothing where no limit is known.
  std::optional<std::uint64_t> free_bytes(const FrameHoldings& holdings) const;

 private:
  struct Waiting {
    FrameId frame = 0;
    std::uint64_t needed_bytes = 0;
    bool is_cancelled = false;
  };

  Room room_;
  std::deque<Waiting> line_;
  TimePoint first_since_;                    // the first one in line has been it since then
  std::optional<TimePoint> hopeless_since_;  // the first one would not fit, whatever others give
};

}  // namespace tessera::master
