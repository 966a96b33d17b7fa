// tessera-keys: makes the credentials of a cluster. One folder per node; copy it to that machine
// and to no other.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "common/base/version.h"
#include "common/net/key_store.h"

namespace {

int report(const std::string& text, int exit_code) {
  std::string line = text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fprintf(stderr, "tessera-keys: %s\n", line.c_str());
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes the keys and certificates of a Tessera cluster.", "tessera-keys");
  app.set_version_flag("--version", std::string("tessera-keys ") + tessera::kBuildId);
  app.require_subcommand(1);
  std::string folder, role, name;
  int days = tessera::net::kNodeDays;
  CLI::App* init =
      app.add_subcommand("init", "make the cluster's CA in DIR; keep DIR on one safe machine");
  init->add_option("DIR", folder)->required();
  CLI::App* add = app.add_subcommand("add", "make DIR/NAME with the credentials of one node");
  add->add_option("DIR", folder)->required();
  add->add_option("ROLE", role, "master, slave or app")->required();
  add->add_option("NAME", name, "unique in the cluster")->required();
  add->add_option("--days", days, "until the certificate expires")
      ->check(CLI::Range(-3650, 3650))
      ->capture_default_str();
  const std::string first = argc > 1 ? argv[1] : "";
  if (!first.empty() && first[0] != '-' && first != "init" && first != "add") {
    return report("unknown command '" + first + "': give init or add", 2);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::Error& error) {
    return report(std::string(error.what()) + " (see 'tessera-keys --help')", 2);
  }
  const tessera::Status status = *init ? tessera::net::init_key_store(folder)
                                       : tessera::net::add_key(folder, role, name, days);
  if (!status.is_ok())
    return report(status.message(), status.code() == tessera::StatusCode::kInvalidArgument ? 2 : 1);
  return 0;
}
