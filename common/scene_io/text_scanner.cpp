// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/text_scanner.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace tessera {

Result<std::string> read_whole_file(const std::string& path, std::uint64_t bytes_max) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                             &std::fclose);
  if (!file) {
    const StatusCode code = errno == ENOENT ? StatusCode::kNotFound : StatusCode::kPermissionDenied;
    return Status(code, path + ": " + std::strerror(errno));
  }
  struct stat info {};
  if (fstat(fileno(file.get()), &info) != 0 || !S_ISREG(info.st_mode)) {
    return Status::invalid_argument(path + ": not a regular file");
  }
  if (static_cast<std::uint64_t>(info.st_size) > bytes_max) {
    return Status::resource_exhausted(path + ": larger than " + std::to_string(bytes_max >> 20) +
                                      " MiB");
  }
  std::string text(static_cast<std::size_t>(info.st_size), '\0');
  if (std::fread(text.data(), 1, text.size(), file.get()) != text.size()) {
    return Status::data_loss(path + ": cannot be read to its end");
  }
  return text;
}

}  // namespace tessera
