// SPDX-License-Identifier: Apache-2.0
#include "common/wire/codec_chooser.h"

namespace tessera::wire {
namespace {

constexpr std::array kCodecs = {ByteCoding::kLz4, ByteCoding::kZstd};

}  // namespace

void CodecChooser::set_link(std::optional<double> bytes_per_second) {
  link_ = bytes_per_second;
  if (!link_) chosen_ = ByteCoding::kNone;
}

// Requires: the rate is known.
double CodecChooser::seconds_per_byte(ByteCoding coding) const {
  if (coding == ByteCoding::kNone) return 1 / *link_;
  const Measure& m = measures_[static_cast<std::size_t>(coding)];
  return m.seconds_per_byte + m.share / *link_;
}

ByteCoding CodecChooser::next(ByteCodingMask allowed) {
  if (!link_ || allowed == kByteCodingsNone) return ByteCoding::kNone;
  for (const ByteCoding codec : kCodecs) {
    if ((allowed & coding_bit(codec)) == 0) continue;
    Measure& m = measures_[static_cast<std::size_t>(codec)];
    if (!m.is_known || ++m.pieces_since >= kTryEvery) {
      m.pieces_since = 0;
      return codec;
    }
  }
  if (chosen_ != ByteCoding::kNone && (allowed & coding_bit(chosen_)) == 0) {
    chosen_ = ByteCoding::kNone;
  }
  ByteCoding best = ByteCoding::kNone;
  for (const ByteCoding codec : kCodecs) {
    const bool is_allowed = (allowed & coding_bit(codec)) != 0;
    if (is_allowed && seconds_per_byte(codec) < seconds_per_byte(best)) best = codec;
  }
  // Leaving a codec that only costs time needs no gain.
  const double gain_min = best == ByteCoding::kNone ? 0 : kGainMin;
  if (seconds_per_byte(best) < (1 - gain_min) * seconds_per_byte(chosen_)) chosen_ = best;
  return chosen_;
}

void CodecChooser::measured(ByteCoding coding, std::size_t plain_bytes, std::size_t coded_bytes,
                            double seconds) {
  if (coding == ByteCoding::kNone || plain_bytes == 0) return;
  Measure& m = measures_[static_cast<std::size_t>(coding)];
  const double plain = static_cast<double>(plain_bytes);
  const double weight = m.is_known ? kNewestWeight : 1;
  m.seconds_per_byte += weight * (seconds / plain - m.seconds_per_byte);
  m.share += weight * (static_cast<double>(coded_bytes) / plain - m.share);
  m.is_known = true;
  m.pieces_since = 0;
}

}  // namespace tessera::wire
