// SPDX-License-Identifier: Apache-2.0
// Saves what the window shows as EXR and PNG, on its own thread (the image thread of `view`), under
// numbered names that no file has yet.
//
// Threads. Any thread calls; `tell` is called on the inner one. Only the destructor waits: it first
// writes what was asked for.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "common/base/bounded_queue.h"
#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "master/image/image_file.h"

namespace tessera::master {

class SnapshotWriter {
 public:
  // A line for a person: which files there are now, or why there are none.
  using Tell = std::function<void(const std::string& line)>;

  // Names begin with `stem`, a path without suffix.
  SnapshotWriter(std::string stem, Tell tell);
  ~SnapshotWriter();
  SnapshotWriter(const SnapshotWriter&) = delete;
  SnapshotWriter& operator=(const SnapshotWriter&) = delete;

  // `what`: the picture in a few words; `options`: how the PNG shows linear pixels, and what the
  // files say of themselves. Returns: false while kWaitingMax others wait.
  [[nodiscard]] bool save(std::shared_ptr<const FrameImage> image, std::string what,
                          const WriteOptions& options = {});

  static constexpr std::size_t kWaitingMax = 4;
  static constexpr int kNumberMax = 9999;

 private:
  struct Job {
    std::shared_ptr<const FrameImage> image;
    std::string what;
    WriteOptions options;
  };
  void run();
  Result<std::string> write(const Job& job);

  const std::string stem_;
  const Tell tell_;
  int number_ = 0;  // of the last pair of files; inner thread
  BoundedQueue<Job> jobs_{kWaitingMax};
  std::thread thread_;
};

// The name without folder and suffix of what a person gave as SCENE, fit for a file's name.
std::string snapshot_stem(const std::string& scene);

}  // namespace tessera::master
