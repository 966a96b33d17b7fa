// SPDX-License-Identifier: Apache-2.0
#include "master/loader/import_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "common/base/clock.h"

namespace tessera::master {
namespace {

constexpr int kPollMs = 100;
constexpr std::size_t kErrorBytesMax = 4096;

std::string importer_path() {
  if (const char* override_path = std::getenv("TESSERA_IMPORT")) return override_path;
  std::error_code error;
  const std::filesystem::path bin =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  for (const auto& candidate :
       {bin / "tessera-import", bin / "../libexec/tessera/tessera-import"}) {
    if (std::filesystem::exists(candidate, error)) return candidate.string();
  }
  return (bin / "tessera-import").string();
}

struct Pipe {
  int ends[2] = {-1, -1};
  ~Pipe() {
    close_read();
    close_write();
  }
  bool open() { return ::pipe2(ends, O_CLOEXEC) == 0; }
  void close_read() { close_end(ends[0]); }
  void close_write() { close_end(ends[1]); }

 private:
  static void close_end(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }
};

// The importer's environment: empty, but for what builds with sanitizers say to each other.
std::vector<char*> environment_of_child() {
  std::vector<char*> kept;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (std::strstr(*variable, "SAN_OPTIONS=") != nullptr) kept.push_back(*variable);
  }
#endif
  kept.push_back(nullptr);
  return kept;
}

// Starts the importer with an empty signal mask, whatever the master's is.
Result<pid_t> spawn(const std::string& program, const std::string& file, ImportKind kind,
                    double seconds_max, const Pipe& out, const Pipe& err) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out.ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.ends[1], STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, defaults;
  sigemptyset(&none);
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  const auto seconds = static_cast<long>(std::ceil(std::max(seconds_max, 1.0)));
  std::vector<std::string> words{program, "--cpu-seconds=" + std::to_string(seconds)};
  if (kind == ImportKind::kPicture) words.push_back("--picture");
  words.insert(words.end(), {"--", file});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  const int error = posix_spawn(&child, program.c_str(), &actions, &attributes, argv.data(),
                                environment_of_child().data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0)
    return Status::not_found("cannot start " + program + ": " + std::strerror(error) +
                             "; install tessera completely");
  return child;
}

// Reads the bytes that are there. Returns: false at the end of the file.
template <typename Container>
bool read_some(int file, Container& into) {
  char buffer[65536];
  const ssize_t size = ::read(file, buffer, sizeof(buffer));
  if (size < 0) return errno == EINTR || errno == EAGAIN;
  if (size == 0) return false;
  const auto* begin = reinterpret_cast<const typename Container::value_type*>(buffer);
  into.insert(into.end(), begin, begin + size);
  return true;
}

// The importer's own line; libraries that it uses may have printed others before.
std::string refusal_in(const std::string& errors) {
  constexpr std::string_view kPrefix = "tessera-import: ";
  std::size_t at = errors.starts_with(kPrefix) ? 0 : errors.find("\n" + std::string(kPrefix));
  if (at == std::string::npos) return errors.substr(0, errors.find('\n'));
  at += (errors[at] == '\n' ? 1 : 0) + kPrefix.size();
  return errors.substr(at, errors.find('\n', at) - at);
}

Status verdict(int wait_status, const std::string& path, const std::string& errors) {
  if (WIFSIGNALED(wait_status)) {
    const int signal = WTERMSIG(wait_status);
    const bool is_limit = signal == SIGXCPU || signal == SIGKILL;
    return Status(
        is_limit ? StatusCode::kResourceExhausted : StatusCode::kInternal,
        path + ": the importer was ended by " + strsignal(signal) +
            (is_limit ? " (a limit on time or memory); give --import-seconds, or a smaller file"
                      : "; the file is probably damaged"));
  }
  if (WEXITSTATUS(wait_status) == 0) return Status::ok();
  const std::string line = refusal_in(errors);
  return Status::invalid_argument(line.empty() ? path + ": cannot be imported" : line);
}

}  // namespace

Result<SceneStream> run_import(const std::string& path, const ImportLimits& limits,
                               const std::function<bool(std::uint64_t bytes)>& progress) {
  const auto bytes = run_importer(path, ImportKind::kScene, limits, progress);
  if (!bytes.is_ok()) return bytes.status();
  return decode_scene_stream(*bytes);
}

Result<std::vector<std::byte>> run_importer(
    const std::string& path, ImportKind kind, const ImportLimits& limits,
    const std::function<bool(std::uint64_t bytes)>& progress) {
  Pipe out, err;
  if (!out.open() || !err.open())
    return Status::resource_exhausted(std::string("cannot make a pipe: ") + std::strerror(errno));
  auto child = spawn(importer_path(), path, kind, limits.seconds_max, out, err);
  if (!child.is_ok()) return child.status();
  out.close_write();
  err.close_write();
  std::vector<std::byte> bytes;
  std::string errors;
  const TimePoint start = Clock::now();
  Status limit;
  for (bool has_out = true, has_err = true; has_out || has_err;) {
    pollfd files[2] = {{has_out ? out.ends[0] : -1, POLLIN, 0},
                       {has_err ? err.ends[0] : -1, POLLIN, 0}};
    ::poll(files, 2, kPollMs);
    if (files[0].revents != 0) has_out = read_some(out.ends[0], bytes);
    if (files[1].revents != 0) has_err = read_some(err.ends[0], errors);
    errors.resize(std::min(errors.size(), kErrorBytesMax));
    if (!progress(bytes.size())) limit = Status::cancelled("interrupted while reading " + path);
    if (bytes.size() > limits.bytes_max)
      limit = Status::resource_exhausted(path + ": what it holds is larger than the limit");
    if (seconds(Clock::now() - start) > limits.seconds_max) {
      limit = Status::resource_exhausted(path + ": reading took longer than " +
                                         std::to_string(static_cast<int>(limits.seconds_max)) +
                                         " s; give --import-seconds");
    }
    if (!limit.is_ok()) {
      ::kill(*child, SIGKILL);
      break;
    }
  }
  int wait_status = 0;
  while (::waitpid(*child, &wait_status, 0) < 0 && errno == EINTR) {
  }
  TESSERA_RETURN_IF_ERROR(limit);
  TESSERA_RETURN_IF_ERROR(verdict(wait_status, path, errors));
  return bytes;
}

}  // namespace tessera::master
