// SPDX-License-Identifier: Apache-2.0
#include "master/commands/run_command.h"

#include <cstdio>
#include <exception>

#include "common/base/clean_text.h"
#include "master/commands/commands.h"

namespace tessera::master {
namespace {
constexpr std::size_t kListBytesMax = std::size_t{1} << 20;  // a line for each frame that failed
}  // namespace

int report_failure(const Status& status) {
  std::fprintf(stderr, "tessera-master: %s\n", clean_text(status.message()).c_str());
  return 1;
}

int report_failed_frames(const std::string& lines) {
  std::fprintf(stderr, "tessera-master: %s\n",
               clean_text(lines, kListBytesMax, /*is_block=*/true).c_str());
  return 3;
}

int report_usage(const Status& status) {
  report_failure(status);
  return status.code() == StatusCode::kInvalidArgument ? 2 : 1;
}

int run_command(int argc, const char* const* argv) {
  struct LastWords {
    ~LastWords() { log_summaries(/*is_last=*/true); }
  } last_words;
  const ParsedCommandLine parsed = parse_command_line(argc, argv);
  if (parsed.exit_code) return *parsed.exit_code;
  const MasterOptions& options = parsed.options;
  const bool is_daemon = options.command == Command::kServe;
  // An application's terminal shows progress; the log keeps to warnings, unless more than what is
  // usual was asked for.
  const bool is_usual = options.log_level == LogLevel::kInfo;
  init_log(is_usual && !is_daemon ? LogLevel::kWarn : options.log_level, options.log_format);
  const SignalWatch signals(
      /*watches_hangup=*/!options.session.listen.empty() && !options.session.keys_folder.empty());
  try {
    switch (options.command) {
      case Command::kServe:
        return run_serve(options, signals);
      case Command::kView:
        return run_view(options, signals);
      case Command::kRender:
        return run_render(options, signals);
      case Command::kStatus:
        return run_status(options);
    }
  } catch (const std::bad_alloc&) {
    return report_failure(
        Status::resource_exhausted("out of memory; try a smaller scene or --size"));
  } catch (const std::exception& error) {
    return report_failure(Status::internal(std::string("unexpected: ") + error.what()));
  }
  return 1;
}

}  // namespace tessera::master
