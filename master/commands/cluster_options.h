// SPDX-License-Identifier: Apache-2.0
// Options that several commands have: of the cluster and its links, of keys, of the log; and how an
// option is checked. For the files that know CLI11 alone.
// Threads. One.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "master/commands/typed_options.h"

namespace tessera::master {

// A validator like CLI::Range, except that "nan" is out of range too.
CLI::Validator number_in(double low, double high);

// CLI::Range without its words in --help: they stand in the option's own text.
template <typename T>
CLI::Validator whole_in(T low, T high) {
  return CLI::Range(low, high).description("");
}

// An option whose text check_options() reads.
void add_text(CLI::App& app, const char* name, std::string& value, const char* type,
              const char* help);

// The values must outlive the app.
void add_log_options(CLI::App& app, MasterOptions& o, TypedOptions& t);
void add_key_options(CLI::App& app, MasterOptions& o);
void add_cluster_options(CLI::App& app, MasterOptions& o, TypedOptions& t);

}  // namespace tessera::master
