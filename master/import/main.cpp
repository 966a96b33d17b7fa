// SPDX-License-Identifier: Apache-2.0
// tessera-import: reads one scene file and writes it as validated blocks to standard output; with
// --picture one picture, as pixels. The master runs it with the file that a user names; whatever
// the file does to it, it does to this process only.
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "common/base/clean_text.h"
#include "common/base/cli_usage.h"
#include "common/base/memory_room.h"
#include "common/base/version.h"
#include "common/scene/scene_stream.h"
#include "common/scene/validate.h"
#include "master/image/image_read.h"
#include "master/image/picture_stream.h"
#include "master/import/crash_line.h"
#include "master/import/equal_triangles.h"
#include "master/import/read_file.h"
#include "master/import/reader_needs.h"
#include "master/import/sandbox/sandbox.h"

namespace {

using tessera::Status;

constexpr std::size_t kWarningsMax = 50;  // a person reads no more

int report(const std::string& text, int exit_code) {
  std::fprintf(stderr, "tessera-import: %s\n", tessera::clean_text(text).c_str());
  return exit_code;
}

// What a reader may take: half of what is free, since the parent takes the scene then. A floor
// keeps libraries loadable where next to nothing is free.
std::uint64_t usual_memory_mb() {
  constexpr std::uint64_t kLeast = 512, kUnknown = 4096;
  const auto room = tessera::memory_room(/*cap_bytes=*/0);
  return room ? std::max(kLeast, room->free_bytes >> 21) : kUnknown;
}

// Nothing for a scene of an unknown suffix, which is refused by its name, unread.
tessera::import::ReaderNeeds needs_of(const std::string& path, bool is_picture) {
  if (is_picture) return tessera::import::needs_of_picture(path);
  const auto* const named = tessera::format_of_suffix(path);
  return named == nullptr ? tessera::import::ReaderNeeds{}
                          : tessera::import::needs_of_reader(named->format, path);
}

// Shuts this process in with what the reader of a file needs. Returns: a warning, or nothing.
std::string shut_in(const std::string& path, tessera::import::ReaderNeeds needs,
                    std::uint64_t memory_mb, std::uint64_t cpu_seconds) {
  tessera::import::SandboxOptions options;
  options.memory_bytes = memory_mb << 20;
  options.cpu_seconds = cpu_seconds;
  options.readable = std::move(needs.files);
  options.load = std::move(needs.load);
  options.readable_for_load = std::move(needs.files_for_load);
  const std::string missing = tessera::import::enter_sandbox(options);
  if (missing.empty()) return {};
  return path + ": was read without all of the sandbox (" + missing +
         "): a file that was made to do harm could do some";
}

int hand_over(const std::vector<std::byte>& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = ::write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (written <= 0 && errno != EINTR) return report("cannot hand over what was read", 1);
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  return 0;
}

int import_file(const std::string& path, const std::string& warning) {
  auto read = tessera::import::read_file(path);
  if (!read.is_ok()) return report(read.status().message(), 1);
  if (const Status status = tessera::validate_scene(read->scene); !status.is_ok()) {
    return report(path + ": " + status.message(), 1);
  }
  if (const auto count = tessera::import::leave_out_equal(read->scene); count > 0) {
    read->warnings.push_back(path + ": " + std::to_string(count) + " triangles lie where " +
                             std::to_string(tessera::import::kEqualTrianglesMax) +
                             " others do that are equal, and are left out");
  }
  if (auto& warnings = read->warnings; warnings.size() > kWarningsMax) {
    const std::size_t more = warnings.size() - kWarningsMax;
    warnings.resize(kWarningsMax);
    warnings.push_back(path + ": and " + std::to_string(more) + " more warnings");
  }
  if (!warning.empty()) read->warnings.insert(read->warnings.begin(), warning);
  tessera::SceneEncoder encoder;
  return hand_over(
      tessera::encode_scene_stream({encoder.encode(read->scene), std::move(read->warnings)}));
}

int import_picture(const std::string& path, const std::string& warning) {
  auto image = tessera::master::read_image(path);
  if (!image.is_ok()) return report(image.status().message(), 1);
  return hand_over(tessera::master::encode_picture_stream({std::move(*image), warning}));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Reads one scene file (" + tessera::suffix_list(false) + "), or a sky (" +
                   tessera::suffix_list(true) +
                   "), and writes it as scene blocks to standard output; or a picture.",
               "tessera-import");
  app.set_version_flag("--version", std::string("tessera-import ") + tessera::kBuildId);
  std::string path;
  std::uint64_t memory_mb = 0, cpu_seconds = 60;
  bool is_picture = false;
  app.add_option("FILE", path)->required();
  app.add_flag("--picture", is_picture, "FILE is a picture, whose pixels are written");
  app.add_option("--memory-mb", memory_mb, "most memory (default: half of what is free)")
      ->check(CLI::Range(64, 1 << 20));
  app.add_option("--cpu-seconds", cpu_seconds, "most processor time")
      ->check(CLI::Range(1, 86400))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::Error& error) {
    return report(tessera::usage_text(app, error) + " (see 'tessera-import --help')", 2);
  }
  struct stat out {};
  if (fstat(STDOUT_FILENO, &out) != 0 || !(S_ISFIFO(out.st_mode) || S_ISSOCK(out.st_mode))) {
    return report("standard output must be a pipe: tessera-master runs this program and reads it",
                  2);
  }
  const tessera::import::CrashLine crash_line(path, "the library that reads it");
  if (memory_mb == 0) memory_mb = usual_memory_mb();
  try {
    const std::string warning = shut_in(path, needs_of(path, is_picture), memory_mb, cpu_seconds);
    return is_picture ? import_picture(path, warning) : import_file(path, warning);
  } catch (const std::bad_alloc&) {
    return report(
        path + ": needs more memory than the limit of " + std::to_string(memory_mb) + " MiB", 1);
  } catch (const std::exception& error) {
    return report(path + ": " + error.what(), 1);
  }
}
