// SPDX-License-Identifier: Apache-2.0
// One line about a wrong command line, for the person who typed it. It is what CLI11 says; where a
// word looks like an option but none has that name, it is that word and the options that may have
// been meant (near_word.h). Each program includes this in its one file that knows CLI11.
//
// An unknown option is reported first, whatever else is wrong: it is the reason why the next word
// is taken for a file, or why something that is needed is missing.
//
// Threads. Main thread, after app.parse() has thrown.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "common/base/near_word.h"

namespace tessera {

// Names, as they are typed, of the options of `app` and of its commands that were given. Options
// that no help shows are for tests and are left out.
inline std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  for (const CLI::App* command : app.get_subcommands()) {
    for (std::string& name : option_names(*command)) names.push_back(std::move(name));
  }
  return names;
}

inline std::string usage_text(const CLI::App& app, const CLI::Error& error) {
  for (const std::string& word : app.remaining(/*recurse=*/true)) {
    const bool is_number = word.size() > 1 && word[1] >= '0' && word[1] <= '9';
    if (word.size() < 2 || word[0] != '-' || is_number) continue;
    const std::string name = word.substr(0, word.find('='));
    return "unknown option '" + name + "'" + did_you_mean(name, option_names(app));
  }
  std::string line = error.what();
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

}  // namespace tessera
