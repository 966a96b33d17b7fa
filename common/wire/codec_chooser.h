// SPDX-License-Identifier: Apache-2.0
// Chooses the coding that pays on a link: the one with which a byte is soonest at the other end,
// the time of coding counted. A link of r bytes a second takes 1 / r for a plain byte; a codec of c
// bytes a second that leaves the share q of them takes 1 / c + q / r. Speed and share are measured
// on the pieces that are sent, for each codec alone.
//
// Threads. One owner. Pure.
// Invariants. (1) A link without a measured rate is never coded for. (2) A codec is taken up
// only for a gain of more than kGainMin and given up when it loses, so that the choice does not
// swing about the break-even. (3) On a slow
// link each codec is tried on the first piece and on one of kTryEvery after it, so that one that
// has begun to pay is found; such a piece travels coded.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "common/wire/byte_coding.h"

namespace tessera::wire {

class CodecChooser {
 public:
  static constexpr double kGainMin = 0.1;    // of the time per byte
  static constexpr unsigned kTryEvery = 64;  // pieces between two trials of a codec not in use
  static constexpr double kNewestWeight = 0.125;

  // Sets the measured rate, bytes per second; nothing: the link was never seen with a queue.
  void set_link(std::optional<double> bytes_per_second);

  // The coding for the next piece, one of `allowed` or none.
  ByteCoding next(ByteCodingMask allowed);

  // Takes the measurement of one piece. `coded_bytes` is `plain_bytes` for a piece that would not
  // have shrunk.
  void measured(ByteCoding coding, std::size_t plain_bytes, std::size_t coded_bytes,
                double seconds);

  // The choice that stands, trials left aside.
  ByteCoding chosen() const { return chosen_; }

 private:
  struct Measure {
    double seconds_per_byte = 0;
    double share = 1;  // of the bytes that coding leaves
    bool is_known = false;
    unsigned pieces_since = 0;
  };
  double seconds_per_byte(ByteCoding coding) const;

  std::optional<double> link_;
  std::array<Measure, kByteCodingCount> measures_{};
  ByteCoding chosen_ = ByteCoding::kNone;
};

}  // namespace tessera::wire
