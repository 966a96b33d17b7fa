// SPDX-License-Identifier: Apache-2.0
// When a certificate begins and ends, and what that asks for: a renewal in time, and a word to
// people the day before its end.
//
// Threads. Values and pure functions; a notice has one owner. Unix time and steady time come in.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/clock.h"

namespace tessera::net {

struct CertificateLife {
  std::int64_t begin_s = 0, end_s = 0;  // Unix time
};

// Whether two thirds of the life are over. A third is left for a master that is away and for people
// who are asked; of the usual year that is four months.
bool is_renewal_due(const CertificateLife& life, std::int64_t now_s);

// Says a day before the end, and then once an hour, that the certificate ends; and that it has
// ended, since who is refused for it must learn why.
class ExpiryNotice {
 public:
  static constexpr std::int64_t kAheadSeconds = 86400;
  static constexpr std::chrono::hours kPause{1};

  // Returns: the words "ends in 23 h 10 min" or "has ended", when it is time to say them; nothing
  // otherwise.
  std::optional<std::string> look(const CertificateLife& life, std::int64_t now_s, TimePoint now);

 private:
  std::optional<TimePoint> told_;
  std::int64_t told_end_s_ = 0;  // of the certificate that it was told of
  bool was_over_ = false;
};

}  // namespace tessera::net
