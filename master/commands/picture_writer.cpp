// SPDX-License-Identifier: Apache-2.0
#include "master/commands/picture_writer.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

#include "master/commands/picture_attributes.h"

namespace tessera::master {
namespace {

// A picture without any light is rarely what was meant.
void warn_when_black(const FrameImage& image, const std::string& path, Progress& progress) {
  const auto is_zero = [](std::byte b) { return b == std::byte{0}; };
  const std::span<const std::byte> colour = image.colour();
  if (!std::all_of(colour.begin(), colour.end(), is_zero)) return;
  progress.say("tessera-master: warning: " + path +
               " is black all over: the camera sees nothing, or no light of the scene reaches it");
}

}  // namespace

PictureWriter::PictureWriter(const OutputPattern& pattern, StatsFile& stats, Progress& progress,
                             Options options)
    : pattern_(pattern),
      stats_(stats),
      progress_(progress),
      options_(std::move(options)),
      thread_([this] { run(); }) {}

PictureWriter::~PictureWriter() { (void)finish(); }  // its outcome has been asked for

Status PictureWriter::write(long number, int pass, FrameResult result,
                            const FrameSettings& settings) {
  Job job{number, pass, std::move(result), settings};
  while (failure().is_ok() && !jobs_.try_push(job))
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return failure();
}

Status PictureWriter::finish() {
  jobs_.close();
  if (thread_.joinable()) thread_.join();
  return failure();
}

void PictureWriter::run() {
  while (auto job = jobs_.pop()) {
    if (!failure().is_ok()) continue;
    Status status = process(*job);
    if (status.is_ok()) continue;
    MutexLock lock(mutex_);
    failure_ = std::move(status);
  }
}

Status PictureWriter::process(const Job& job) {
  const FrameImage& image = *job.result.image;
  if (job.pass == 0) picture_seconds_ = 0;
  picture_seconds_ += job.result.stats.seconds;
  PassReport report{job.pass, options_.passes, 0, std::nullopt};
  const bool has_reference = options_.reference.width_px > 0;
  if (options_.passes > 1 || has_reference) {
    if (job.pass == 0) {
      mean_.reset();
      pass_seconds_ = 0;
    }
    mean_.add(image);
    pass_seconds_ += job.result.stats.seconds;
    report.seconds = pass_seconds_;
  }
  if (has_reference) {
    report.error = image_error(seen_like(options_.reference, mean_.mean()), options_.reference.rgb,
                               image.width_px, image.height_px);
    if (!options_.is_quiet) {
      char line[200];
      std::snprintf(line, sizeof(line),
                    "pass %d of %d: %.3f s, RMSE %.6g, relMSE %.6g, FLIP %.4f, mean %+.3f %%",
                    job.pass + 1, options_.passes, report.seconds, report.error->rmse,
                    report.error->rel_mse, report.error->flip, 100 * report.error->mean_off);
      progress_.say(line);
    }
  }
  if (job.pass + 1 == options_.passes) {
    const std::string path = pattern_.path(job.number);
    const FrameImage mean = options_.passes == 1 ? FrameImage{} : mean_.image();
    const FrameImage& picture = options_.passes == 1 ? image : mean;
    warn_when_black(picture, path, progress_);
    TESSERA_RETURN_IF_ERROR(write_image(
        picture, path,
        {options_.is_half, job.settings.display,
         picture_attributes(options_.scene, job.settings, options_.passes, picture_seconds_)}));
  }
  return stats_.write(job.result.stats, image, report);
}

Status PictureWriter::failure() {
  MutexLock lock(mutex_);
  return failure_;
}

}  // namespace tessera::master
