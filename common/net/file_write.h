// SPDX-License-Identifier: Apache-2.0
// Small files that must be there whole or not at all, also after a power cut. For common/net alone.
//
// Threads. Any; nothing is shared.
#pragma once

#include <sys/types.h>

#include <string>

#include "common/base/status.h"

namespace tessera::net {

// Writes a new file. Returns: kPermissionDenied (it exists, the folder cannot be written) or
// kResourceExhausted (disk full), naming it.
Status write_new_file(const std::string& path, const std::string& text, mode_t mode);

// A replacement of a file that is still to be committed: its text is written under another name and
// synced, so that one rename is left to do. A replacement that was not committed is removed.
class Replacement {
 public:
  static Result<Replacement> write(const std::string& path, const std::string& text, mode_t mode);
  Replacement(Replacement&& other) noexcept;
  Replacement& operator=(Replacement&&) = delete;
  ~Replacement();
  Status commit();  // a reader sees the old file or the new one

 private:
  explicit Replacement(std::string path) : path_(std::move(path)) {}
  std::string path_;  // empty: committed or moved from
};
Status replace_file(const std::string& path, const std::string& text, mode_t mode);

// Appends a line to a file, which is made when it is not there.
Status append_line(const std::string& path, const std::string& line, mode_t mode);

}  // namespace tessera::net
