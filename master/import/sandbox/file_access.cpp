// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "master/import/sandbox/sandbox.h"

namespace tessera::import {
namespace {

// The interface as linux/landlock.h has it since version 6; headers of older systems end earlier.
constexpr long kCreateRuleset = 444, kAddRule = 445, kRestrictSelf = 446;  // on every machine
constexpr unsigned kAskVersion = 1;
constexpr int kRulePathBeneath = 1;

struct RulesetAttr {
  std::uint64_t handled_access_fs = 0, handled_access_net = 0, scoped = 0;
};
struct PathBeneathAttr {
  std::uint64_t allowed_access = 0;
  std::int32_t parent = -1;
} __attribute__((packed));

constexpr std::uint64_t kReadFile = 1 << 2, kReadDir = 1 << 3;

// Number of the rights to files that a version knows; they are its lowest bits. Version 2 adds
// renaming across folders, 3 truncation, 5 control of devices.
int file_right_count(long version) {
  return version >= 5 ? 16 : version >= 3 ? 15 : version == 2 ? 14 : 13;
}

// Bytes of the attributes that a version knows: version 4 adds ports, 6 signals and sockets.
std::size_t attr_bytes(long version) {
  return version >= 6   ? sizeof(RulesetAttr)
         : version >= 4 ? offsetof(RulesetAttr, scoped)
                        : offsetof(RulesetAttr, handled_access_net);
}

// A descriptor that is closed at the end.
class Descriptor {
 public:
  explicit Descriptor(long number) : number_(static_cast<int>(number)) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

std::string because(const char* what) { return std::string(what) + ": " + std::strerror(errno); }

// Returns: whether the rule stands, or the file does not exist.
bool allow_reading(int ruleset, const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_PATH | O_CLOEXEC));
  struct stat info {};
  if (file.number() < 0 || fstat(file.number(), &info) != 0) return true;
  PathBeneathAttr rule;
  rule.allowed_access = S_ISDIR(info.st_mode) ? kReadFile | kReadDir : kReadFile;
  rule.parent = file.number();
  return syscall(kAddRule, ruleset, kRulePathBeneath, &rule, 0) == 0;
}

}  // namespace

std::string limit_files(const std::vector<std::string>& readable) {
  const long version = syscall(kCreateRuleset, nullptr, 0, kAskVersion);
  if (version < 1) return because("no Landlock");
  RulesetAttr attr;
  attr.handled_access_fs = (std::uint64_t{1} << file_right_count(version)) - 1;
  attr.handled_access_net = 3;  // to bind and to connect
  attr.scoped = 3;              // abstract sockets, signals
  const Descriptor ruleset(syscall(kCreateRuleset, &attr, attr_bytes(version), 0));
  if (ruleset.number() < 0) return because("no rules of Landlock");
  for (const std::string& path : readable) {
    if (!allow_reading(ruleset.number(), path)) return because("no rule of Landlock");
  }
  if (syscall(kRestrictSelf, ruleset.number(), 0) != 0) return because("Landlock is not entered");
  return {};
}

}  // namespace tessera::import
