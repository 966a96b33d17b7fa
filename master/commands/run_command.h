// From the words of the command line to an exit code; all that main() does.
#pragma once

namespace tessera::master {

int run_command(int argc, const char* const* argv);

}  // namespace tessera::master
