// SPDX-License-Identifier: Apache-2.0
// SHA-256 of a frame's pixels, computed beside the network thread: at 1.4 GB/s it costs as much as
// all else that a tile takes there.
//
// Threads. The home loop's thread calls; the hasher's, where there is one, does the sums. Pixels
// once given are not written any more.
#pragma once

#include <functional>
#include <memory>

#include "common/base/digest.h"
#include "common/frame/frame_image.h"
#include "common/net/event_loop.h"

namespace tessera::master {

class FrameDigest {
 public:
  // Null `hasher`: the calling thread does all at once (in virtual time, say).
  FrameDigest(net::EventLoop& home, net::EventLoop* hasher)
      : home_(home), hasher_(hasher), hash_(std::make_shared<Sha256>()) {}

  // Adds the next bytes of `image`.
  void update(const std::shared_ptr<const FrameImage>& image, std::size_t begin,
              std::size_t bytes) {
    run([hash = hash_, image, begin, bytes] {
      hash->update(std::span<const std::byte>(image->bytes).subspan(begin, bytes));
    });
  }

  // Call after the last byte. `on_done` is called on the home loop; at once without a hasher.
  void finish(std::function<void(const Digest&)> on_done) {
    run([hash = hash_, on_done = std::move(on_done), home = hasher_ != nullptr ? &home_ : nullptr] {
      const Digest digest = hash->finish();
      if (home == nullptr) return on_done(digest);
      home->post([on_done, digest] { on_done(digest); });
    });
  }

 private:
  template <typename Task>
  void run(Task task) {
    hasher_ != nullptr ? hasher_->post(std::move(task)) : task();
  }

  net::EventLoop& home_;
  net::EventLoop* hasher_;
  std::shared_ptr<Sha256> hash_;
};

}  // namespace tessera::master
