// SPDX-License-Identifier: Apache-2.0
#include "master/loader/file_watch.h"

#include <sys/stat.h>

#include <utility>

namespace tessera::master {

std::optional<FileLook> look_at_file(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return std::nullopt;
  FileLook look;
  look.device = static_cast<std::uint64_t>(info.st_dev);
  look.inode = static_cast<std::uint64_t>(info.st_ino);
  look.bytes = static_cast<std::uint64_t>(info.st_size);
  look.changed_seconds = info.st_mtim.tv_sec;
  look.changed_ns = info.st_mtim.tv_nsec;
  return look;
}

bool FileWatch::is_changed(const std::optional<FileLook>& look) {
  const bool is_settled = std::exchange(last_, look) == look;
  if (!is_settled || look == read_) return false;
  read_ = look;
  return true;
}

}  // namespace tessera::master
