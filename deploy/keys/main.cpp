// tessera-keys: makes the credentials of a cluster, renews and revokes them. One folder per node;
// copy it to that machine and to no other.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <set>

#include "common/base/version.h"
#include "common/net/key_store.h"

namespace {

struct Words {
  std::string folder, role, name;
  int days = tessera::net::kNodeDays;
  int starts_in_days = 0;
};

int report(const std::string& text, int exit_code) {
  std::string line = text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fprintf(stderr, "tessera-keys: %s\n", line.c_str());
  return exit_code;
}

CLI::App* add_command(CLI::App& app, Words& words, const char* name, const char* about) {
  CLI::App* const command = app.add_subcommand(name, about);
  command->add_option("DIR", words.folder, "the cluster's folder")->required();
  return command;
}

void add_days(CLI::App* command, Words& words) {
  command->add_option("--days", words.days, "until the certificate expires")
      ->check(CLI::Range(-3650, 3650))
      ->capture_default_str();
}

int run(int argc, char** argv) {
  CLI::App app("Makes the keys and certificates of a Tessera cluster.", "tessera-keys");
  app.set_version_flag("--version", std::string("tessera-keys ") + tessera::kBuildId);
  app.require_subcommand(1);
  Words words;
  CLI::App* const init =
      add_command(app, words, "init", "make the cluster's CA in DIR; keep DIR on one safe machine");
  CLI::App* const add =
      add_command(app, words, "add", "make DIR/NAME with the credentials of one node");
  add->add_option("ROLE", words.role, "master, slave or app")->required();
  CLI::App* const renew = add_command(
      app, words, "renew",
      "a new key and certificate in DIR/NAME; copy both to the node, which takes them over by "
      "itself within seconds, or at once on SIGHUP");
  CLI::App* const revoke = add_command(
      app, words, "revoke",
      "all certificates made for NAME count no more: writes crl.pem into DIR and every folder in "
      "it; copy it to the running nodes, which close NAME's connections within seconds");
  for (CLI::App* command : {add, renew, revoke})
    command->add_option("NAME", words.name, "unique in the cluster")->required();
  add_days(add, words);
  add_days(renew, words);
  add->add_option("--test-starts-in-days", words.starts_in_days)
      ->check(CLI::Range(0, 3650))
      ->group("");  // for tests: not shown
  const std::string first = argc > 1 ? argv[1] : "";
  const std::set<std::string> commands{"init", "add", "renew", "revoke"};
  if (!first.empty() && first[0] != '-' && !commands.contains(first))
    return report("unknown command '" + first + "': give init, add, renew or revoke", 2);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::Error& error) {
    return report(std::string(error.what()) + " (see 'tessera-keys --help')", 2);
  }
  using namespace tessera::net;
  const tessera::Status status =
      *init     ? init_key_store(words.folder)
      : *renew  ? renew_key(words.folder, words.name, words.days)
      : *revoke ? revoke_key(words.folder, words.name)
                : add_key(words.folder, words.role, words.name, words.days, words.starts_in_days);
  if (!status.is_ok())
    return report(status.message(), status.code() == tessera::StatusCode::kInvalidArgument ? 2 : 1);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return run(argc, argv); }
