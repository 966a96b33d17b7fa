// SPDX-License-Identifier: Apache-2.0
// Shuts this process in for good, before it looks at a file that a stranger may have made: limits
// on memory and time, no files but those that are named and those for reading alone, and no system
// calls but those that reading and computing need. README.md has the table.
//
// Threads. Call once, from the only thread. In builds with sanitizers, whose own threads and calls
// it would stop, only the limits on time hold.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace tessera::import {

struct SandboxOptions {
  // Files, and folders with all below them, that may be read. Those that do not exist are passed
  // over. Names of all others can be asked for (stat), but none can be opened.
  std::vector<std::string> readable;
  // Loads plug-ins, which may start threads, with these files readable besides. May be empty.
  std::function<void()> load;
  std::vector<std::string> readable_for_load;
  std::uint64_t memory_bytes = 0;  // of address space
  std::uint64_t cpu_seconds = 0;
};

// Enters the sandbox. All descriptors but 0, 1, 2 are closed and the environment is emptied.
// Returns: empty where everything holds, else one line that names what this kernel cannot do; all
// the rest holds then.
std::string enter_sandbox(const SandboxOptions& options);

// The parts of it, each of which may be entered alone.

// Memory, processor time, size of files, descriptors, no core; dies with its parent.
void limit_resources(std::uint64_t memory_bytes, std::uint64_t cpu_seconds);

// Landlock (Salaün, "Landlock LSM: toward unprivileged sandboxing", 2017): every right to a file
// that the kernel knows is taken but reading what `readable` names; so are TCP ports, signals and
// abstract sockets of others, where the kernel knows of these.
// Requires: no_new_privs. Returns: empty, or why the kernel cannot do it.
std::string limit_files(const std::vector<std::string>& readable);

// seccomp: every system call but those of a table is refused with EPERM; one that was made by
// another machine's convention ends the process. Holds for all threads.
// Requires: no_new_privs. Returns: empty, or why the kernel cannot do it.
std::string limit_system_calls();

}  // namespace tessera::import
