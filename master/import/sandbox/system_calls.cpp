// SPDX-License-Identifier: Apache-2.0
// The table of system calls, and the program of the Berkeley packet filter that is made of it
// (McCanne and Jacobson, "The BSD Packet Filter", 1993; the kernel's
// Documentation/userspace-api/seccomp_filter.rst). Numbers of calls and of flags are the machine's.
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "master/import/sandbox/sandbox.h"

namespace tessera::import {
namespace {

#if defined(__x86_64__)
#define TESSERA_AUDIT_ARCH AUDIT_ARCH_X86_64
#elif defined(__aarch64__)
#define TESSERA_AUDIT_ARCH AUDIT_ARCH_AARCH64
#endif

// How an argument decides: kAny lets the call pass whatever it says; the others look at the low
// half of the argument, but kNull at all of it.
enum class Look { kAny, kNoneOf, kAllOf, kNotAllOf, kEquals, kNull };

// A call that passes where its argument agrees. Rows of one call are alternatives.
struct Row {
  long call;
  Look look = Look::kAny;
  unsigned argument = 0;
  std::uint32_t bits = 0;
};

// Flags of an open() that could change anything.
constexpr std::uint32_t kWrites =
    O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | (O_TMPFILE & ~O_DIRECTORY);
constexpr std::uint32_t kWriteAndRun = PROT_WRITE | PROT_EXEC;
constexpr std::uint32_t kThread = CLONE_THREAD | CLONE_VM | CLONE_SIGHAND;

constexpr Row kRows[] = {
    // Bytes of files that are open, and the two pipes.
    {SYS_read},
    {SYS_readv},
    {SYS_pread64},
    {SYS_preadv},
    {SYS_write},
    {SYS_writev},
    {SYS_lseek},
    {SYS_close},
    {SYS_dup},
    {SYS_dup3},
    {SYS_ppoll},
    {SYS_fcntl, Look::kEquals, 1, F_GETFD},
    {SYS_fcntl, Look::kEquals, 1, F_SETFD},
    {SYS_fcntl, Look::kEquals, 1, F_GETFL},
    {SYS_fcntl, Look::kEquals, 1, F_DUPFD_CLOEXEC},
    {SYS_fadvise64},
    // Files, for reading.
    {SYS_openat, Look::kNoneOf, 2, kWrites},
    {SYS_faccessat},
    {SYS_faccessat2},
    {SYS_fstat},
    {SYS_newfstatat},
    {SYS_statx},
    {SYS_statfs},
    {SYS_fstatfs},
    {SYS_readlinkat},
    {SYS_getdents64},
    {SYS_getcwd},
#if defined(__x86_64__)
    {SYS_open, Look::kNoneOf, 1, kWrites},
    {SYS_access},
    {SYS_stat},
    {SYS_lstat},
    {SYS_readlink},
    {SYS_dup2},
    {SYS_poll},
    {SYS_time},
#endif
    // Memory. What is written is never run, and what was not run is not made so.
    {SYS_brk},
    {SYS_mmap, Look::kNotAllOf, 2, kWriteAndRun},
    {SYS_munmap},
    {SYS_mremap},
    {SYS_mprotect, Look::kNoneOf, 2, PROT_EXEC},
    {SYS_madvise},
    {SYS_mlock},  // a library of OpenImageIO complains without
    // Threads of this process.
    {SYS_clone, Look::kAllOf, 0, kThread},
    {SYS_futex},
    {SYS_set_robust_list},
    {SYS_rseq},
    {SYS_sched_yield},
    {SYS_sched_getaffinity},
    {SYS_gettid},
    {SYS_getpid},
    {SYS_exit},
    {SYS_exit_group},
    {SYS_prctl, Look::kEquals, 0, PR_SET_NAME},
    {SYS_prlimit64, Look::kNull, 2},
    {SYS_rt_sigaction},
    {SYS_rt_sigprocmask},
    {SYS_rt_sigreturn},
    {SYS_sigaltstack},
    {SYS_restart_syscall},
    {SYS_getuid},
    {SYS_geteuid},
    {SYS_getgid},
    {SYS_getegid},
    // Clocks and facts of the machine.
    {SYS_clock_gettime},
    {SYS_clock_getres},
    {SYS_clock_nanosleep},
    {SYS_nanosleep},
    {SYS_gettimeofday},
    {SYS_getrusage},
    {SYS_times},
    {SYS_uname},
    {SYS_sysinfo},
    {SYS_getrandom},
    {SYS_getcpu},
    {SYS_get_mempolicy},
    {SYS_membarrier},
};

// Calls that libraries do without where the kernel is too old for them: their arguments lie in
// memory, where no filter looks.
constexpr long kUnknown[] = {SYS_clone3, SYS_openat2};

constexpr std::uint32_t kPass = SECCOMP_RET_ALLOW, kRefuse = SECCOMP_RET_ERRNO | EPERM;

class Program {
 public:
  Program() {
    load(offsetof(seccomp_data, arch));
    answer_unless_equal(TESSERA_AUDIT_ARCH, SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
    for (const long call : kUnknown) answer_if_equal(call, SECCOMP_RET_ERRNO | ENOSYS);
    for (const Row& row : kRows) add(row);
    // A process may end itself by a signal (abort), and nobody else.
    add({SYS_tgkill, Look::kEquals, 0, static_cast<std::uint32_t>(getpid())});
    code_.push_back(BPF_STMT(BPF_RET | BPF_K, kRefuse));
  }

  bool enter() {
    sock_fprog program{static_cast<unsigned short>(code_.size()), code_.data()};
    return syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &program) == 0;
  }

 private:
  void load(std::size_t offset) {
    code_.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)));
  }
  void jump(unsigned short kind, std::uint32_t value, std::uint8_t if_true, std::uint8_t if_false) {
    code_.push_back(
        BPF_JUMP(static_cast<unsigned short>(BPF_JMP | kind | BPF_K), value, if_true, if_false));
  }
  void answer(std::uint32_t verdict) { code_.push_back(BPF_STMT(BPF_RET | BPF_K, verdict)); }
  void answer_if_equal(long value, std::uint32_t verdict) {
    jump(BPF_JEQ, static_cast<std::uint32_t>(value), 0, 1);
    answer(verdict);
  }
  void answer_unless_equal(long value, std::uint32_t verdict) {
    jump(BPF_JEQ, static_cast<std::uint32_t>(value), 1, 0);
    answer(verdict);
  }

  // Requires: the number of the call is loaded. It is loaded again behind the row.
  void add(const Row& row) {
    if (row.look == Look::kAny) {
      answer_if_equal(row.call, kPass);
      return;
    }
    const std::size_t skip = code_.size();
    jump(BPF_JEQ, static_cast<std::uint32_t>(row.call), 0, 0);
    look_at(row);
    answer(kPass);
    load(offsetof(seccomp_data, nr));
    // The jump past the row, and those of the look that found no agreement, meet at the load.
    code_[skip].jf = static_cast<std::uint8_t>(code_.size() - skip - 1);
  }

  // Goes on behind the next instruction where the argument does not agree.
  void look_at(const Row& row) {
    const std::size_t low = offsetof(seccomp_data, args) + 8 * row.argument;
    load(low);
    switch (row.look) {
      case Look::kAny:
        break;
      case Look::kNoneOf:
        jump(BPF_JSET, row.bits, 1, 0);
        break;
      case Look::kAllOf:
        code_.push_back(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, row.bits));
        jump(BPF_JEQ, row.bits, 0, 1);
        break;
      case Look::kNotAllOf:
        code_.push_back(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, row.bits));
        jump(BPF_JEQ, row.bits, 1, 0);
        break;
      case Look::kEquals:
        jump(BPF_JEQ, row.bits, 0, 1);
        break;
      case Look::kNull:
        jump(BPF_JEQ, 0, 0, 3);
        load(low + 4);
        jump(BPF_JEQ, 0, 0, 1);
        break;
    }
  }

  std::vector<sock_filter> code_;
};

}  // namespace

std::string limit_system_calls() {
#ifdef TESSERA_AUDIT_ARCH
  if (Program().enter()) return {};
  return std::string("no filter of system calls: ") + std::strerror(errno);
#else
  return "no table of system calls for this machine";
#endif
}

}  // namespace tessera::import
