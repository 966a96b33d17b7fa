// SPDX-License-Identifier: Apache-2.0
#include "master/commands/snapshot_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "master/image/image_file.h"

namespace tessera::master {
namespace {

constexpr std::array<const char*, 2> kSuffixes{".exr", ".png"};

// Makes a file name ours with an empty file, which writing replaces. The file is removed when
// nothing was written.
class ReservedName {
 public:
  explicit ReservedName(std::string path) : path_(std::move(path)) {
    const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    error_ = file < 0 ? errno : 0;
    if (file >= 0) ::close(file);
  }
  ~ReservedName() {
    if (error_ == 0 && !is_kept_) ::unlink(path_.c_str());
  }
  ReservedName(const ReservedName&) = delete;
  ReservedName& operator=(const ReservedName&) = delete;

  int error() const { return error_; }  // 0: the name is ours
  const std::string& path() const { return path_; }
  void keep() { is_kept_ = true; }

 private:
  const std::string path_;
  int error_ = 0;
  bool is_kept_ = false;
};

}  // namespace

SnapshotWriter::SnapshotWriter(std::string stem, Tell tell)
    : stem_(std::move(stem)), tell_(std::move(tell)), thread_([this] { run(); }) {}

SnapshotWriter::~SnapshotWriter() {
  jobs_.close();
  thread_.join();
}

bool SnapshotWriter::save(std::shared_ptr<const FrameImage> image, std::string what,
                          const WriteOptions& options) {
  return jobs_.try_push({std::move(image), std::move(what), options});
}

void SnapshotWriter::run() {
  while (auto job = jobs_.pop()) {
    const Result<std::string> written = write(*job);
    tell_(written.is_ok() ? *written : "the picture was not saved: " + written.status().message());
  }
}

Result<std::string> SnapshotWriter::write(const Job& job) {
  for (++number_; number_ <= kNumberMax; ++number_) {
    char number[16];
    std::snprintf(number, sizeof(number), "-%04d", number_);
    ReservedName exr(stem_ + number + kSuffixes[0]), png(stem_ + number + kSuffixes[1]);
    if (exr.error() == EEXIST || png.error() == EEXIST) continue;
    for (const ReservedName* name : {&exr, &png}) {
      if (name->error() == 0) continue;
      --number_;
      return Status::resource_exhausted("cannot write " + name->path() + ": " +
                                        std::strerror(name->error()));
    }
    WriteOptions options = job.options;
    options.is_half_exr = job.image->format == PixelFormat::kHalf;
    TESSERA_RETURN_IF_ERROR(write_image(*job.image, exr.path(), options));
    exr.keep();
    if (const Status status = write_image(*job.image, png.path(), options); !status.is_ok())
      return Status(status.code(), status.message() + " (" + exr.path() + " is written)");
    png.keep();
    return "saved " + exr.path() + " and " + png.path() + " (" + job.what + ")";
  }
  return Status::resource_exhausted("all names up to " + stem_ + "-" + std::to_string(kNumberMax) +
                                    " are taken: move some away");
}

std::string snapshot_stem(const std::string& scene) {
  const std::size_t colon = scene.starts_with("builtin:") ? scene.find(':') + 1 : 0;
  const std::string stem = std::filesystem::path(scene.substr(colon)).stem().string();
  return stem.empty() || stem.front() == '.' ? "picture" : stem;
}

}  // namespace tessera::master
