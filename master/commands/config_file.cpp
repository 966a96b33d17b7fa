// SPDX-License-Identifier: Apache-2.0
#include <toml++/toml.h>
#include <algorithm>
#include <filesystem>

#include "common/base/near_word.h"
#include "master/commands/options.h"

namespace tessera::master {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Status at(const std::string& path, const toml::source_region& where, const std::string& text) {
  return Status::invalid_argument(path + ":" + std::to_string(where.begin.line) + ": " + text);
}

}  // namespace

Result<std::vector<std::string>> read_config_file(const std::string& path,
                                                  const std::vector<std::string>& known,
                                                  const std::vector<std::string>& given) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return Status::not_found("--config " + path + ": no such file");
  }
  toml::table table;
  try {
    table = toml::parse_file(path);
  } catch (const toml::parse_error& e) {
    return at(path, e.source(), std::string(e.description()));
  }
  std::vector<std::string> words;
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (!contains(known, name)) {
      return at(path, node.source(),
                "unknown key '" + name + "'; keys are the long options without dashes" +
                    did_you_mean(name, known));
    }
    if (contains(given, name)) continue;
    if (const auto text = node.value_exact<std::string>()) {
      words.push_back("--" + name + "=" + *text);
    } else if (const auto flag = node.value_exact<bool>()) {
      if (*flag) words.push_back("--" + name);
    } else if (const auto whole = node.value_exact<std::int64_t>()) {
      words.push_back("--" + name + "=" + std::to_string(*whole));
    } else if (const auto real = node.value_exact<double>()) {
      words.push_back("--" + name + "=" + std::to_string(*real));
    } else {
      return at(path, node.source(), "'" + name + "' needs a string, a number or true/false");
    }
  }
  return words;
}

}  // namespace tessera::master
