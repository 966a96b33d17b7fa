// SPDX-License-Identifier: Apache-2.0
// Notices that a file has another content than the one that was read: by looks at its size and
// times. A file is not read while it is being written: only what two looks found alike counts.
//
// Threads. FileWatch: one owner, pure. look_at_file(): any.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera::master {

// What a look finds. Programs that save a file write it anew or put another in its place.
struct FileLook {
  std::uint64_t device = 0, inode = 0, bytes = 0;
  std::int64_t changed_seconds = 0, changed_ns = 0;  // when the content changed
  bool operator==(const FileLook&) const = default;
};

// Returns: nothing when there is no file that can be looked at.
std::optional<FileLook> look_at_file(const std::string& path);

class FileWatch {
 public:
  // first: from before the file was read, so that what changed meanwhile is noticed.
  explicit FileWatch(const std::optional<FileLook>& first) : read_(first), last_(first) {}

  // Returns: whether the file is to be read again. It is told once for each content.
  bool is_changed(const std::optional<FileLook>& look);

 private:
  std::optional<FileLook> read_;  // of what was told last
  std::optional<FileLook> last_;
};

}  // namespace tessera::master
