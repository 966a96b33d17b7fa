// SPDX-License-Identifier: Apache-2.0
#include "common/net/certificate_life.h"

namespace tessera::net {

bool is_renewal_due(const CertificateLife& life, std::int64_t now_s) {
  return now_s - life.begin_s >= (life.end_s - life.begin_s) / 3 * 2;
}

std::optional<std::string> ExpiryNotice::look(const CertificateLife& life, std::int64_t now_s,
                                              TimePoint now) {
  const std::int64_t left = life.end_s - now_s;
  if (left > kAheadSeconds) {
    told_.reset();
    return std::nullopt;
  }
  const bool is_over = left <= 0;
  const bool is_news = !told_ || told_end_s_ != life.end_s || was_over_ != is_over;
  if (!is_news && now - *told_ < kPause) return std::nullopt;
  told_ = now;
  told_end_s_ = life.end_s;
  was_over_ = is_over;
  if (is_over) return "has ended";
  return "ends in " + std::to_string(left / 3600) + " h " + std::to_string(left % 3600 / 60) +
         " min";
}

}  // namespace tessera::net
