// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/run_facts.h"

#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/base/json.h"
#include "common/base/version.h"

namespace tessera::bench {
namespace {

// The model as /proc/cpuinfo names it, with its family, since some machines hide the rest of it.
std::string processor_model() {
  std::ifstream file("/proc/cpuinfo");
  std::string name, family;
  for (std::string line; std::getline(file, line) && (name.empty() || family.empty());) {
    const std::size_t colon = line.find(": ");
    if (colon == std::string::npos) continue;
    if (line.starts_with("model name")) name = line.substr(colon + 2);
    if (line.starts_with("cpu family")) family = line.substr(colon + 2);
  }
  if (name.empty()) return "unknown";
  return family.empty() ? name : name + " (family " + family + ")";
}

std::string compiler() {
#if defined(__clang__)
  return std::string("clang ") + __clang_version__;
#else
  return std::string("gcc ") + __VERSION__;
#endif
}

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::string command_line(int argc, const char* const* argv) {
  std::string line = std::filesystem::path(argc > 0 ? argv[0] : "tessera-bench").filename();
  // --json is left out: where the figures are written to says nothing about them.
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--json")
      ++i;
    else
      line += std::string(" ") + argv[i];
  }
  return line;
}

}  // namespace

std::string run_facts(int argc, const char* const* argv) {
  JsonObject facts;
  facts.add("commit", std::string(kBuildId));
  facts.add("processor", processor_model() + ", " +
                             std::to_string(std::thread::hardware_concurrency()) + " threads");
  facts.add("compiler", compiler()).add("date", utc_now()).add("command", command_line(argc, argv));
  return facts.text();
}

}  // namespace tessera::bench
