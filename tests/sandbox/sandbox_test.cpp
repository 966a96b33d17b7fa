// SPDX-License-Identifier: Apache-2.0
// What a program can do in the importer's sandbox: each attempt runs in a process of its own that
// has entered it, as the person who runs the test and, where that is root, as nobody, too.
#include "master/import/sandbox/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <functional>
#include <thread>

#include "tests/support/temp_folder.h"

namespace tessera::import {
namespace {

constexpr uid_t kNobody = 65534;
constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;

// Exit codes of a child: what came of its attempt.
enum Outcome { kDone = 10, kRefused = 11, kFailed = 12, kNoSandbox = 13 };

// An attempt returns what the system call did: -1 with errno for "no".
using Attempt = std::function<long()>;

Outcome outcome_of(long answer) {
  if (answer != -1) return kDone;
  return errno == EPERM || errno == EACCES || errno == ENOSYS ? kRefused : kFailed;
}

// Runs an attempt in a child, and gives its exit code, or minus the signal that ended it.
int run_child(const std::function<int()>& child) {
  const pid_t pid = fork();
  if (pid == 0) _exit(child());
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

class Sandbox : public ::testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer's own calls would be refused";
#endif
    std::filesystem::create_directories(folder_ / "scene");
    folder_.write("scene/inside.txt", "inside");
    folder_.write("key.pem", "a secret");
    // Nobody, too, may look at these: only the sandbox stands before them.
    for (const char* name : {"", "scene"})
      std::filesystem::permissions(folder_ / name, std::filesystem::perms(0755));
    for (const char* name : {"scene/inside.txt", "key.pem"})
      std::filesystem::permissions(folder_ / name, std::filesystem::perms(0666));
    for (const uid_t user : users_) {
      const int seen = run_child([&] { return enter(user).empty() ? kDone : kNoSandbox; });
      if (seen != kDone) GTEST_SKIP() << "this kernel lacks a part of the sandbox";
    }
  }

  // Becomes `user`, and enters. Returns: what is missing.
  std::string enter(uid_t user) const {
    if (user != getuid() && (setgid(user) != 0 || setuid(user) != 0)) _exit(kNoSandbox);
    SandboxOptions options;
    options.readable = {folder_ / "scene"};
    options.memory_bytes = kMemory;
    options.cpu_seconds = 10;
    return enter_sandbox(options);
  }
  int within(uid_t user, const Attempt& attempt) const {
    return run_child([&] {
      if (!enter(user).empty()) return static_cast<int>(kNoSandbox);
      errno = 0;
      return static_cast<int>(outcome_of(attempt()));
    });
  }
  void expect(Outcome expected, const char* what, const Attempt& attempt) const {
    for (const uid_t user : users_)
      EXPECT_EQ(within(user, attempt), expected) << what << ", as user " << user;
  }
  void refuses(const char* what, const Attempt& attempt) const { expect(kRefused, what, attempt); }

  const pid_t test_ = getpid();  // the parent of what runs in the sandbox
  const test::TempFolder folder_;
  const std::vector<uid_t> users_ =
      getuid() == 0 ? std::vector<uid_t>{0, kNobody} : std::vector<uid_t>{getuid()};
};

TEST_F(Sandbox, FilesOfTheFolderAreReadAndNoOthers) {
  const std::string inside = folder_ / "scene/inside.txt", key = folder_ / "key.pem";
  expect(kDone, "a file of the folder", [&] { return open(inside.c_str(), O_RDONLY); });
  refuses("a key outside of the folder", [&] { return open(key.c_str(), O_RDONLY); });
  refuses("a key by way of the folder",
          [&] { return open((folder_ / "scene/../key.pem").c_str(), O_RDONLY); });
  refuses("the passwords", [] { return open("/etc/shadow", O_RDONLY); });
  refuses("the users", [] { return open("/etc/passwd", O_RDONLY); });
  refuses("the memory of its parent",
          [this] { return open(("/proc/" + std::to_string(test_) + "/mem").c_str(), O_RDONLY); });
  refuses("the folder above", [&] { return open(folder_.path().c_str(), O_RDONLY | O_DIRECTORY); });
}

TEST_F(Sandbox, LinksDoNotLeadOut) {
  std::filesystem::create_symlink(folder_ / "key.pem", folder_ / "scene/link");
  refuses("a link to the key", [&] { return open((folder_ / "scene/link").c_str(), O_RDONLY); });
}

TEST_F(Sandbox, NothingIsWritten) {
  const std::string inside = folder_ / "scene/inside.txt", made = folder_ / "scene/made";
  std::filesystem::permissions(folder_ / "scene", std::filesystem::perms(0777));
  refuses("to write", [&] { return open(inside.c_str(), O_WRONLY); });
  refuses("to read and write", [&] { return open(inside.c_str(), O_RDWR); });
  refuses("to shorten while opening", [&] { return open(inside.c_str(), O_RDONLY | O_TRUNC); });
  refuses("to shorten", [&] { return truncate(inside.c_str(), 0); });
  refuses("to create", [&] { return open(made.c_str(), O_RDONLY | O_CREAT, 0600); });
  refuses("a file without a name",
          [&] { return open(folder_.path().c_str(), O_TMPFILE | O_RDWR); });
  refuses("to make a folder", [&] { return mkdir(made.c_str(), 0700); });
  refuses("to make a pipe", [&] { return mkfifo(made.c_str(), 0600); });
  refuses("to make a link", [&] { return symlink("inside.txt", made.c_str()); });
  refuses("to delete", [&] { return unlink(inside.c_str()); });
  refuses("to rename", [&] { return rename(inside.c_str(), made.c_str()); });
  refuses("to change rights", [&] { return chmod(inside.c_str(), 0777); });
  EXPECT_EQ(std::filesystem::file_size(inside), 6u);
}

TEST_F(Sandbox, NoProgramIsRunAndNoProcessMade) {
  refuses("to run a program", [] {
    char name[] = "/bin/true";
    char* const words[] = {name, nullptr};
    return execv(name, words);
  });
  refuses("to make a process",
          [] { return static_cast<long>(syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0)); });
  refuses("clone3, whose flags no filter sees", [] { return syscall(SYS_clone3, nullptr, 0); });
  refuses("memory that is written and run", [] {
    void* const memory =
        mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return memory == MAP_FAILED ? -1L : 0L;
  });
  refuses("to run what was written", [] {
    void* const memory =
        mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return static_cast<long>(mprotect(memory, 4096, PROT_READ | PROT_EXEC));
  });
}

TEST_F(Sandbox, OtherProcessesAreOutOfReach) {
  refuses("to trace its parent", [this] { return ptrace(PTRACE_ATTACH, test_, nullptr, nullptr); });
  refuses("to be traced", [] { return ptrace(PTRACE_TRACEME, 0, nullptr, nullptr); });
  refuses("to read the memory of its parent", [this] {
    char byte = 0;
    iovec here{&byte, 1}, there{&byte, 1};
    return syscall(SYS_process_vm_readv, test_, &here, 1, &there, 1, 0);
  });
  refuses("to signal its parent", [this] { return kill(test_, 0); });
  refuses("to end its parent's thread",
          [this] { return syscall(SYS_tgkill, test_, test_, SIGCONT); });
  refuses("to raise its parent's limits", [this] {
    const rlimit64 limit{1, 1};
    return syscall(SYS_prlimit64, test_, RLIMIT_CORE, &limit, nullptr);
  });
  refuses("to raise its own limits", [] {
    const rlimit limit{RLIM_INFINITY, RLIM_INFINITY};
    return setrlimit(RLIMIT_AS, &limit);
  });
}

TEST_F(Sandbox, TheSystemAndTheNetworkAreOutOfReach) {
  refuses("a socket", [] { return socket(AF_INET, SOCK_STREAM, 0); });
  refuses("a local socket", [] { return socket(AF_UNIX, SOCK_STREAM, 0); });
  refuses("to mount", [] { return mount("none", "/tmp", "tmpfs", 0, nullptr); });
  refuses("another root", [] { return chroot("/"); });
  refuses("a namespace", [] { return unshare(CLONE_NEWUSER); });
  refuses("a user", [] { return static_cast<long>(syscall(SYS_setuid, 0)); });
  refuses("a kernel's program", [] { return syscall(SYS_bpf, 0, nullptr, 0); });
  refuses("counters", [] { return syscall(SYS_perf_event_open, nullptr, 0, -1, -1, 0); });
  refuses("a ring", [] { return syscall(SYS_io_uring_setup, 1, nullptr); });
  refuses("the keys of the kernel", [] { return syscall(SYS_keyctl, 0, 0, 0, 0, 0); });
  refuses("a machine's time", [] {
    const timespec time{0, 0};
    return clock_settime(CLOCK_REALTIME, &time);
  });
}

// By another machine's convention every number means another call.
#if defined(__x86_64__)
TEST_F(Sandbox, CallsOfAnotherConventionEndTheProcess) {
  const Attempt foreign = [] {
    long answer = 20;  // getpid there
    asm volatile("int $0x80" : "+a"(answer) : : "memory");
    return answer;
  };
  // A kernel without that convention ends any process that calls by it, in a sandbox or not.
  const int outside = run_child([&] { return static_cast<int>(outcome_of(foreign())); });
  const int ended = outside == kDone ? -SIGSYS : outside;
  EXPECT_LT(ended, 0);
  for (const uid_t user : users_) EXPECT_EQ(within(user, foreign), ended) << user;
  refuses("a call of x32", [] { return syscall(0x40000000 | SYS_getpid); });
}
#endif

TEST_F(Sandbox, ReadingAndComputingGoOn) {
  expect(kDone, "threads", [] {
    long sum = 0;
    std::thread([&] { sum = 1; }).join();
    return sum;
  });
  expect(kDone, "memory", [] {
    const std::vector<char> bytes(64 << 20, 1);
    return static_cast<long>(bytes.back());
  });
  expect(kDone, "its limits can be asked for", [] {
    rlimit limit{};
    return getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur == kMemory ? 0L : -1L;
  });
  expect(kDone, "an empty environment",
         [] { return environ == nullptr || *environ == nullptr ? 0L : -1L; });
  for (const uid_t user : users_) {
    EXPECT_EQ(within(user, []() -> long { std::abort(); }), -SIGABRT) << "a check that fails";
  }
}

TEST_F(Sandbox, DescriptorsOfTheParentAreClosed) {
  const int open_one = open((folder_ / "key.pem").c_str(), O_RDONLY);
  ASSERT_GE(open_one, 3);
  expect(kFailed, "a descriptor that was left open", [&] { return fcntl(open_one, F_GETFD); });
  close(open_one);
}

// Plug-ins start threads as they are loaded; these are bound, too.
TEST_F(Sandbox, AThreadThatALibraryStartsIsInIt) {
  const std::string key = folder_ / "key.pem", library = folder_.write("library.so", "x");
  std::filesystem::permissions(library, std::filesystem::perms(0644));
  const int outcome = run_child([&] {
    std::atomic<int> turn{0}, seen{0};
    std::thread early;
    SandboxOptions options;
    options.readable = {folder_ / "scene"};
    options.readable_for_load = {library};
    options.memory_bytes = kMemory;
    options.cpu_seconds = 10;
    options.load = [&] {
      if (open(library.c_str(), O_RDONLY) < 0) seen = kFailed;
      early = std::thread([&] {
        turn.wait(0);
        const bool is_key = open(key.c_str(), O_RDONLY) >= 0,
                   is_socket = socket(AF_UNIX, SOCK_STREAM, 0) >= 0;
        if (is_key || is_socket) seen = kDone;
      });
    };
    if (!enter_sandbox(options).empty()) return static_cast<int>(kNoSandbox);
    turn = 1;
    turn.notify_all();
    early.join();
    if (open(library.c_str(), O_RDONLY) >= 0) return static_cast<int>(kFailed);
    return seen == 0 ? static_cast<int>(kRefused) : seen.load();
  });
  EXPECT_EQ(outcome, kRefused);
}

// Each part stands alone: what one lets pass another refuses.
TEST_F(Sandbox, EachPartHoldsWithoutTheOther) {
  const std::string key = folder_ / "key.pem";
  const auto alone = [&](const std::function<std::string()>& part, const Attempt& attempt) {
    return run_child([&] {
      if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || !part().empty()) return kNoSandbox;
      return outcome_of(attempt());
    });
  };
  const auto files = [&] { return limit_files({folder_ / "scene"}); };
  EXPECT_EQ(alone(files, [&] { return open(key.c_str(), O_RDONLY); }), kRefused);
  EXPECT_EQ(alone(files, [&] { return open(key.c_str(), O_WRONLY); }), kRefused);
  EXPECT_EQ(alone(limit_system_calls, [&] { return open(key.c_str(), O_RDONLY); }), kDone);
  EXPECT_EQ(alone(limit_system_calls, [&] { return open(key.c_str(), O_WRONLY); }), kRefused);
  EXPECT_EQ(alone(limit_system_calls, [&] { return truncate(key.c_str(), 0); }), kRefused);
  const std::string made = folder_ / "scene/made", inside = folder_ / "scene/inside.txt";
  EXPECT_EQ(alone(files, [&] { return mkdir(made.c_str(), 0700); }), kRefused);
  EXPECT_EQ(alone(files, [&] { return open(inside.c_str(), O_WRONLY); }), kRefused);
  EXPECT_EQ(alone(files, [&] { return unlink(inside.c_str()); }), kRefused);
  const Attempt signal = [this] { return syscall(SYS_tgkill, test_, test_, SIGCONT); };
  EXPECT_EQ(alone(limit_system_calls, signal), kRefused);
}

}  // namespace
}  // namespace tessera::import
