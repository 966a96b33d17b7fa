// SPDX-License-Identifier: Apache-2.0
#include "slave/pixel_coder.h"

#include <utility>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/wire/pixel_coding.h"

namespace tessera::slave {

void PixelCoder::code(const wire::FrameBegin& begin, wire::TileResult& result) {
  wire::ByteCoding coding = wire::ByteCoding::kNone;
  {
    MutexLock lock(mutex_);
    coding = chooser_.next(begin.pixel_codings);
  }
  if (coding == wire::ByteCoding::kNone) return;
  const TimePoint began = Clock::now();
  std::vector<std::byte> coded;
  const bool is_smaller =
      wire::code_pixels(coding, PixelLayout(begin.settings), result.pixels, coded);
  const double took = seconds(Clock::now() - began);
  const std::size_t plain_bytes = result.pixels.size();
  if (is_smaller) {
    result.coding = coding;
    result.pixels = std::move(coded);
  }
  MutexLock lock(mutex_);
  chooser_.measured(coding, plain_bytes, result.pixels.size(), took);
}

void PixelCoder::observe(const net::LinkCounters& counters) {
  std::optional<double> rate;
  wire::ByteCoding now = wire::ByteCoding::kNone;
  {
    MutexLock lock(mutex_);
    link_.observe(counters);
    rate = link_.bytes_per_second();
    chooser_.set_link(rate);
    now = chooser_.chosen();
  }
  const wire::ByteCoding before = std::exchange(told_, now);
  if (now == before) return;
  // That pixels are coded is news; which of two close codecs is ahead is not. The log is written
  // without the mutex, since a terminal that stands still must not hold up the render threads.
  const bool is_news = now == wire::ByteCoding::kNone || before == wire::ByteCoding::kNone;
  log_event(is_news ? LogLevel::kInfo : LogLevel::kDebug, "pixel-coding",
            "the link to the master decides how pixels travel",
            {{"coding", wire::coding_name(now)},
             {"link_mbit_per_s", rate ? std::to_string(8e-6 * *rate) : "no queue seen"}});
}

void PixelCoder::forget_link() {
  MutexLock lock(mutex_);
  link_ = {};
  chooser_.set_link(std::nullopt);
}

}  // namespace tessera::slave
