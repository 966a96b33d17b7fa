// SPDX-License-Identifier: Apache-2.0
// tessera-keys: makes the credentials of a cluster, renews and revokes them. One folder per node;
// copy it to that machine and to no other.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <set>
#include <string_view>

#include "common/base/clean_text.h"
#include "common/base/cli_usage.h"
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
  std::fprintf(stderr, "tessera-keys: %s\n", tessera::clean_text(line).c_str());
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

// How a node of this role is started with its credentials.
std::string start_command(const std::string& role, const std::string& name) {
  if (role == "master") return "tessera-master serve --listen HOST:PORT --keys " + name;
  if (role == "slave") return "tessera-slave --master HOST:PORT --keys " + name;
  return "tessera-master view SCENE --connect HOST:PORT --keys " + name;
}

// `path` quoted where a shell would not take it for one word.
std::string quoted(const std::string& path) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-./+:@%,=").find(c) != std::string_view::npos;
  };
  if (!path.empty() && std::all_of(path.begin(), path.end(), is_plain)) return path;
  std::string text = "'";
  for (const char c : path) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

void say(const std::string& line) { std::puts(tessera::clean_text(line).c_str()); }

// Says what was made, until when it counts, and what to do next.
void say_init(const std::string& folder, const tessera::net::KeyFacts& ca) {
  say("made the authority of a cluster in " + folder + ", good until " + ca.last_day +
      "; keep this folder on one safe machine");
  say("next: tessera-keys add " + quoted(folder) +
      " master NAME, then the same with slave for each slave, "
      "with app for who renders");
}

void say_add(const Words& words, const tessera::net::KeyFacts& node) {
  const std::string folder = words.folder + "/" + words.name;
  say("made " + folder + ", the credentials of " + node.role + " '" + node.name + "', " +
      (words.days < 0 ? "expired since " : "good until ") + node.last_day);
  say("next: copy the folder to its machine and to no other; there: " +
      start_command(node.role, words.name));
  if (words.days < 0) return;
  say("before " + node.last_day + ": tessera-keys renew " + quoted(words.folder) + " " +
      words.name);
}

void say_renew(const Words& words, const tessera::net::KeyFacts& node) {
  say("made a new key and certificate of " + node.role + " '" + node.name + "' in " + words.folder +
      "/" + words.name + ", " + (words.days < 0 ? "expired since " : "good until ") +
      node.last_day + "; the old one counts until it expires or is revoked");
  say("next: copy node.key and node.crt to its machine; it takes them over within seconds, or at "
      "once on SIGHUP");
}

void say_revoke(const Words& words) {
  say("revoked all certificates ever made for '" + words.name + "': wrote crl.pem, in " +
      words.folder + " and in the folder of each node there");
  say("next: copy crl.pem to the running nodes, the master first; they close the connections of '" +
      words.name + "' within seconds");
  say("for a new one of that name: tessera-keys renew " + quoted(words.folder) + " " + words.name);
}

const char* state_text(tessera::net::KeyState state) {
  switch (state) {
    case tessera::net::KeyState::kGood:
      return "";
    case tessera::net::KeyState::kRenewalDue:
      return "renew it";
    case tessera::net::KeyState::kEndsInADay:
      return "renew it now: it ends within a day";
    case tessera::net::KeyState::kEnded:
      return "has ended: renew it";
    case tessera::net::KeyState::kNotYet:
      return "does not count yet: look at the clock";
    case tessera::net::KeyState::kRevoked:
      return "revoked";
  }
  return "";
}

int say_list(const std::string& folder) {
  const auto all = tessera::net::list_key_facts(folder);
  if (!all.is_ok()) return report(all.status().message(), 1);
  std::size_t name_width = std::string_view("the authority").size();
  for (const tessera::net::KeyFacts& key : *all) name_width = std::max(name_width, key.name.size());
  const auto row = [name_width](const std::string& name, const std::string& role,
                                const std::string& day, const std::string& state) {
    std::string line = name + std::string(name_width + 2 - std::min(name.size(), name_width), ' ') +
                       role + std::string(role.size() < 8 ? 8 - role.size() : 1, ' ') + day;
    if (!state.empty()) line += "  " + state;
    say(line);
  };
  row("name", "role", "good until", "");
  for (const tessera::net::KeyFacts& key : *all) {
    row(key.name.empty() ? "the authority" : key.name, key.role, key.last_day,
        state_text(key.state));
  }
  return 0;
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
  CLI::App* const list = add_command(
      app, words, "list", "names, roles and last days of what was made, and what needs a renewal");
  for (CLI::App* command : {add, renew, revoke})
    command->add_option("NAME", words.name, "unique in the cluster")->required();
  add_days(add, words);
  add_days(renew, words);
  add->add_option("--test-starts-in-days", words.starts_in_days)
      ->check(CLI::Range(-3650, 3650))
      ->group("");  // for tests: not shown
  const std::string first = argc > 1 ? argv[1] : "";
  const std::set<std::string> commands{"init", "add", "renew", "revoke", "list"};
  if (!first.empty() && first[0] != '-' && !commands.contains(first))
    return report("unknown command '" + first + "': give init, add, list, renew or revoke" +
                      tessera::did_you_mean(first, {commands.begin(), commands.end()}),
                  2);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::Error& error) {
    return report(tessera::usage_text(app, error) + " (see 'tessera-keys --help')", 2);
  }
  if (*list) return say_list(words.folder);
  using namespace tessera::net;
  const tessera::Status status =
      *init     ? init_key_store(words.folder)
      : *renew  ? renew_key(words.folder, words.name, words.days)
      : *revoke ? revoke_key(words.folder, words.name)
                : add_key(words.folder, words.role, words.name, words.days, words.starts_in_days);
  if (!status.is_ok())
    return report(status.message(), status.code() == tessera::StatusCode::kInvalidArgument ? 2 : 1);
  if (*revoke) {
    say_revoke(words);
    return 0;
  }
  const auto facts = read_key_facts(words.folder, words.name);
  if (!facts.is_ok()) return report(facts.status().message(), 1);
  if (*init) say_init(words.folder, *facts);
  if (*add) say_add(words, *facts);
  if (*renew) say_renew(words, *facts);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return run(argc, argv); }
