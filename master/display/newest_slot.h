// SPDX-License-Identifier: Apache-2.0
// One place for the newest value: a writer replaces what was not taken yet, a reader takes it or
// finds nothing.
//
// Threads. Any thread puts and takes. Nothing here waits longer than a move; the value that is
// replaced is destroyed outside the lock (a frame's pixels may be large).
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "common/base/mutex.h"

namespace tessera::master {

template <typename T>
class NewestSlot {
 public:
  void put(T value) TESSERA_EXCLUDES(mutex_) {
    std::optional<T> replaced(std::move(value));
    MutexLock lock(mutex_);
    std::swap(value_, replaced);
    ++put_count_;
  }

  std::optional<T> take() TESSERA_EXCLUDES(mutex_) {
    std::optional<T> taken;
    MutexLock lock(mutex_);
    std::swap(value_, taken);
    return taken;
  }

  bool is_empty() const TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return !value_.has_value();
  }

  std::uint64_t put_count() const TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return put_count_;
  }

 private:
  mutable Mutex mutex_;
  std::optional<T> value_ TESSERA_GUARDED_BY(mutex_);
  std::uint64_t put_count_ TESSERA_GUARDED_BY(mutex_) = 0;
};

}  // namespace tessera::master
