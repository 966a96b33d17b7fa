// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/slave_process.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>

namespace tessera::bench {

Result<std::unique_ptr<SlaveProcess>> SlaveProcess::start(std::uint16_t master_port) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = self.parent_path() / "tessera-slave";
  if (error || access(program.c_str(), X_OK) != 0)
    return Status::not_found(program + " is not there: build the target tessera-slave");
  const std::string master = "127.0.0.1:" + std::to_string(master_port);
  const char* const words[] = {program.c_str(), "--master", master.c_str(),
                               "--plain",       "--quiet",  nullptr};
  // Between fork and exec nothing takes memory or a lock, since threads of the parent may hold
  // some.
  const pid_t child = fork();
  if (child < 0) return Status::resource_exhausted("a process for the slave cannot be made");
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execv(words[0], const_cast<char* const*>(words));
    _exit(127);
  }
  return std::unique_ptr<SlaveProcess>(new SlaveProcess(child));
}

SlaveProcess::~SlaveProcess() {
  kill(child_, SIGTERM);
  waitpid(child_, nullptr, 0);
}

double SlaveProcess::cpu_seconds() const {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(child_, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace tessera::bench
