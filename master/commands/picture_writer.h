// SPDX-License-Identifier: Apache-2.0
// Writes pictures on its own thread, so that the cluster renders on meanwhile: the mean of each
// picture's passes, and how far it is from a reference after each pass. At most two frames wait.
//
// Threads. One thread calls; the writer's own thread is inside.
#pragma once

#include <string>
#include <thread>

#include "common/base/bounded_queue.h"
#include "common/base/mutex.h"
#include "master/commands/progress.h"
#include "master/commands/stats_file.h"
#include "master/image/image_file.h"
#include "master/image/image_read.h"
#include "master/image/pass_mean.h"
#include "master/session/session.h"

namespace tessera::master {

class PictureWriter {
 public:
  struct Options {
    int passes = 1;
    bool is_half = false;    // of files that can hold half floats
    bool is_quiet = false;   // errors are not printed
    FloatImage reference{};  // of no width: none
    std::string scene{};     // as the command line names it
  };
  // `stats` and `progress` outlive the writer.
  PictureWriter(const OutputPattern& pattern, StatsFile& stats, Progress& progress,
                Options options);
  ~PictureWriter();

  // Takes one pass of picture `number`, with the settings that it was rendered and is shown with.
  // Passes come in order. Waits for room. Returns: the first failure so far.
  Status write(long number, int pass, FrameResult result, const FrameSettings& settings);

  // Writes what waits and joins the thread. Returns: the first failure.
  Status finish();

 private:
  struct Job {
    long number = 0;
    int pass = 0;
    FrameResult result;
    FrameSettings settings;
  };

  void run();
  Status process(const Job& job);
  Status failure();

  const OutputPattern pattern_;
  StatsFile& stats_;
  Progress& progress_;
  const Options options_;
  PassMean mean_;
  double pass_seconds_ = 0;
  double picture_seconds_ = 0;  // of the passes of one picture so far
  BoundedQueue<Job> jobs_{2};

  Mutex mutex_;
  Status failure_ TESSERA_GUARDED_BY(mutex_);

  std::thread thread_;
};

}  // namespace tessera::master
