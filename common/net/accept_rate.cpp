// SPDX-License-Identifier: Apache-2.0
#include "common/net/accept_rate.h"

#include <algorithm>

namespace tessera::net {
namespace {

// Pause between sweeps. A sweep looks at every bucket, and a flood from many addresses must not
// cause one each time.
constexpr std::chrono::milliseconds kSweepPause{100};

}  // namespace

double AcceptRate::tokens_of(const Bucket& bucket, TimePoint now) const {
  return std::min(limits_.burst, bucket.tokens + limits_.per_second * seconds(now - bucket.since));
}

bool AcceptRate::take(Bucket& bucket, TimePoint now) const {
  bucket = {tokens_of(bucket, now), now};
  if (bucket.tokens < 1) return false;
  bucket.tokens -= 1;
  return true;
}

bool AcceptRate::admit(const std::string& address, TimePoint now) {
  const auto found = buckets_.find(address);
  if (found != buckets_.end()) return take(found->second, now);
  if (buckets_.size() >= limits_.addresses_max && now >= sweep_at_) {  // a full bucket says nothing
    sweep_at_ = now + kSweepPause;
    std::erase_if(buckets_,
                  [&](const auto& entry) { return tokens_of(entry.second, now) >= limits_.burst; });
  }
  if (buckets_.size() >= limits_.addresses_max) return take(others_, now);
  return take(buckets_.try_emplace(address, Bucket{limits_.burst, now}).first->second, now);
}

}  // namespace tessera::net
