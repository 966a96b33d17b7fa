// SPDX-License-Identifier: Apache-2.0
// tessera-import: reads one scene file and writes it as validated blocks to standard output. The
// master runs it with the file that a user names; whatever the file does to it, it does to this
// process only.
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>

#include "common/base/cli_usage.h"
#include "common/base/version.h"
#include "common/scene/scene_stream.h"
#include "common/scene/validate.h"
#include "master/import/read_file.h"

namespace {

using tessera::Status;

constexpr rlim_t kErrorFileBytesMax = 1 << 20;
constexpr std::size_t kWarningsMax = 50;  // a person reads no more

int report(const std::string& text, int exit_code) {
  std::string line = text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fprintf(stderr, "tessera-import: %s\n", line.c_str());
  return exit_code;
}

void limit(int resource, rlim_t value) {
  const rlimit both{value, value};
  setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

// Limits this process: memory, time, output files, descriptors, no core, no new rights, no network
// where the kernel allows that, and death with the parent.
void limit_self(std::uint64_t memory_mb, std::uint64_t cpu_seconds) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limit(RLIMIT_AS, memory_mb << 20);
#else
  (void)memory_mb;  // sanitizers reserve terabytes of address space
#endif
  // One second of grace, so that the kernel's word is "CPU time limit" and not "killed".
  const rlimit cpu{cpu_seconds, cpu_seconds + 1};
  setrlimit(RLIMIT_CPU, &cpu);
  // No file is written to but by messages on standard error, where that is a file.
  limit(RLIMIT_FSIZE, kErrorFileBytesMax);
  std::signal(SIGXFSZ, SIG_IGN);
  limit(RLIMIT_NOFILE, 256);
  limit(RLIMIT_CORE, 0);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
  if (unshare(CLONE_NEWNET) != 0) errno = 0;  // needs rights; the readers open no sockets anyway
}

int import_file(const std::string& path) {
  auto read = tessera::import::read_file(path);
  if (!read.is_ok()) return report(read.status().message(), 1);
  if (const Status status = tessera::validate_scene(read->scene); !status.is_ok()) {
    return report(path + ": " + status.message(), 1);
  }
  if (auto& warnings = read->warnings; warnings.size() > kWarningsMax) {
    const std::size_t more = warnings.size() - kWarningsMax;
    warnings.resize(kWarningsMax);
    warnings.push_back(path + ": and " + std::to_string(more) + " more warnings");
  }
  tessera::SceneEncoder encoder;
  const std::vector<std::byte> bytes =
      tessera::encode_scene_stream({encoder.encode(read->scene), std::move(read->warnings)});
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = ::write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (written <= 0 && errno != EINTR) return report("cannot hand over the scene", 1);
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Reads one scene file (" + tessera::suffix_list(false) + "), or a sky (" +
                   tessera::suffix_list(true) +
                   "), and writes it as scene blocks to standard output.",
               "tessera-import");
  app.set_version_flag("--version", std::string("tessera-import ") + tessera::kBuildId);
  std::string path;
  std::uint64_t memory_mb = 8192, cpu_seconds = 300;
  app.add_option("FILE", path)->required();
  app.add_option("--memory-mb", memory_mb, "most memory")
      ->check(CLI::Range(64, 1 << 20))
      ->capture_default_str();
  app.add_option("--cpu-seconds", cpu_seconds, "most processor time")
      ->check(CLI::Range(1, 86400))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::Error& error) {
    return report(tessera::usage_text(app, error) + " (see 'tessera-import --help')", 2);
  }
  struct stat out {};
  if (fstat(STDOUT_FILENO, &out) != 0 || !(S_ISFIFO(out.st_mode) || S_ISSOCK(out.st_mode))) {
    return report("standard output must be a pipe: tessera-master runs this program and reads it",
                  2);
  }
  limit_self(memory_mb, cpu_seconds);
  try {
    return import_file(path);
  } catch (const std::bad_alloc&) {
    return report(
        path + ": needs more memory than the limit of " + std::to_string(memory_mb) + " MiB", 1);
  } catch (const std::exception& error) {
    return report(path + ": " + error.what(), 1);
  }
}
