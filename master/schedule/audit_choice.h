// SPDX-License-Identifier: Apache-2.0
// Which tiles two slaves render, whose pixels are then compared. Pure.
//
// A slave that knew which of its tiles are compared could lie about the others, so the choice
// depends on a secret of the master. A third slave decides between two that differ; where it must
// not be one of the two under another name, audits wait until enough certificates are here.
//
// Threads. The scheduler's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "common/base/ids.h"
#include "master/schedule/slave_identity.h"

namespace tessera::master {

struct AuditOptions {
  double share = 0;          // of the tiles, 0 to 1
  std::size_t keys_min = 0;  // certificates that must be here; 0: audits need none
  std::uint64_t secret = 0;
};

class AuditChoice {
 public:
  explicit AuditChoice(const AuditOptions& options) : options_(options) {}

  void joined(const SlaveIdentity& slave) {
    if (!slave.key.empty()) ++sessions_[slave.key];
  }
  // Requires: the slave has joined.
  void left(const SlaveIdentity& slave) {
    const auto found = sessions_.find(slave.key);
    if (found != sessions_.end() && --found->second == 0) sessions_.erase(found);
  }

  // Whether there may be audits at some time.
  bool is_possible() const { return options_.share > 0; }
  // The same answer for a tile whenever enough certificates are here.
  bool has_chosen(FrameId frame, TileIndex tile) const {
    if (!is_possible() || sessions_.size() < options_.keys_min) return false;
    const std::uint64_t bits = mix(mix(mix(options_.secret) ^ frame) ^ tile);
    return static_cast<double>(bits >> 11) * 0x1p-53 < options_.share;
  }

 private:
  // 64 bits in which every bit of the input matters (Steele, Lea, Flood 2014: SplitMix64).
  static std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

  const AuditOptions options_;
  std::map<std::string, std::uint32_t> sessions_;  // by certificate
};

}  // namespace tessera::master
