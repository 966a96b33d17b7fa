// SPDX-License-Identifier: Apache-2.0
// From the words of the command line to an exit code; all that main() does.
// Threads. The main thread: GLFW insists on it.
#pragma once

namespace tessera::master {

int run_command(int argc, const char* const* argv);

}  // namespace tessera::master
