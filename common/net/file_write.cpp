// SPDX-License-Identifier: Apache-2.0
#include "common/net/file_write.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace tessera::net {
namespace {

std::string temporary_name(const std::string& path) { return path + ".new"; }

Status write_and_close(int file, const std::string& path, const std::string& text) {
  const bool is_written =
      ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
      ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  if (is_written) return Status::ok();
  return Status::resource_exhausted("cannot write " + path + ": " + std::strerror(error));
}

Status open_failure(const std::string& path) {
  return Status::permission_denied("cannot write " + path + ": " + std::strerror(errno));
}

void sync_folder_of(const std::string& path) {
  const std::string folder = path.substr(0, path.rfind('/'));
  const int directory = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return;
  ::fsync(directory);  // a file system that cannot is no failure
  ::close(directory);
}

}  // namespace

Status write_new_file(const std::string& path, const std::string& text, mode_t mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (file < 0) return open_failure(path);
  Status status = write_and_close(file, path, text);
  if (!status.is_ok()) ::unlink(path.c_str());
  return status;
}

Result<Replacement> Replacement::write(const std::string& path, const std::string& text,
                                       mode_t mode) {
  const std::string temporary = temporary_name(path);
  ::unlink(temporary.c_str());  // left by a run that was killed
  TESSERA_RETURN_IF_ERROR(write_new_file(temporary, text, mode));
  return Replacement(path);
}

Replacement::Replacement(Replacement&& other) noexcept : path_(std::exchange(other.path_, "")) {}

Replacement::~Replacement() {
  if (!path_.empty()) ::unlink(temporary_name(path_).c_str());
}

Status Replacement::commit() {
  if (::rename(temporary_name(path_).c_str(), path_.c_str()) != 0) {
    return Status::permission_denied("cannot replace " + path_ + ": " + std::strerror(errno));
  }
  sync_folder_of(std::exchange(path_, ""));
  return Status::ok();
}

Status replace_file(const std::string& path, const std::string& text, mode_t mode) {
  auto replacement = Replacement::write(path, text, mode);
  return replacement.is_ok() ? replacement->commit() : replacement.status();
}

Status append_line(const std::string& path, const std::string& line, mode_t mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, mode);
  if (file < 0) return open_failure(path);
  return write_and_close(file, path, line + "\n");
}

}  // namespace tessera::net
