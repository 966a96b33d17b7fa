// SPDX-License-Identifier: Apache-2.0
#include "master/commands/run_command.h"

int main(int argc, char** argv) { return tessera::master::run_command(argc, argv); }
