// SPDX-License-Identifier: Apache-2.0
// A slave in a process of its own: the tessera-slave that lies beside this program.
//
// Threads. One at a time.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>

#include "common/base/status.h"

namespace tessera::bench {

// Ends with its parent, or in the destructor.
class SlaveProcess {
 public:
  // Starts one for the master at a port of this machine, without encryption.
  static Result<std::unique_ptr<SlaveProcess>> start(std::uint16_t master_port);
  ~SlaveProcess();
  SlaveProcess(const SlaveProcess&) = delete;
  SlaveProcess& operator=(const SlaveProcess&) = delete;

  double cpu_seconds() const;  // so far, of all its threads

 private:
  explicit SlaveProcess(pid_t child) : child_(child) {}
  pid_t child_;
};

}  // namespace tessera::bench
