// SPDX-License-Identifier: Apache-2.0
// Codes the pixels of results for the link to the master, where that pays (wire::CodecChooser):
// render threads code, so that the network thread does not; the network thread tells how fast the
// link is.
//
// Threads. Any; the chooser is behind a mutex, held for no more than a few additions.
// Invariant. What a master has not said it can decode never leaves: FrameBegin.pixel_codings.
#pragma once

#include "common/base/mutex.h"
#include "common/net/link_counters.h"
#include "common/wire/codec_chooser.h"
#include "common/wire/link_rate.h"
#include "common/wire/messages.h"

namespace tessera::slave {

class PixelCoder {
 public:
  // Replaces the pixels by coded ones where that pays and they shrink.
  void code(const wire::FrameBegin& begin, wire::TileResult& result) TESSERA_EXCLUDES(mutex_);

  // Takes the tile connection's counters, now and then while results go out.
  void observe(const net::LinkCounters& counters) TESSERA_EXCLUDES(mutex_);
  // Forgets the link's rate; another connection is used from now on.
  void forget_link() TESSERA_EXCLUDES(mutex_);

 private:
  Mutex mutex_;
  wire::LinkRate link_ TESSERA_GUARDED_BY(mutex_);
  wire::CodecChooser chooser_ TESSERA_GUARDED_BY(mutex_);

  wire::ByteCoding told_ = wire::ByteCoding::kNone;  // logged last; network thread
};

}  // namespace tessera::slave
