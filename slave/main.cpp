// tessera-slave: one slave daemon. Exit code 0: stopped on request; 1: failed; 2: wrong usage.
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <string>

#include "common/base/limits.h"
#include "common/base/mutex.h"
#include "common/net/tls.h"
#include "slave/slave_cli.h"
#include "slave/slave_node.h"

namespace tessera::slave {
namespace {

// A second SIGTERM or SIGINT while we leave.
extern "C" void exit_at_once(int) { _exit(1); }

// Why the node gave up, from the io thread to main.
struct Fatal {
  Mutex mutex;
  Status status TESSERA_GUARDED_BY(mutex);
};

// SIGUSR1 is our own: the io thread wakes main with it.
sigset_t waited_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGUSR1);
  return signals;
}

void arm_second_signal(const sigset_t& signals) {
  signal(SIGTERM, exit_at_once);
  signal(SIGINT, exit_at_once);
  signal(SIGUSR1, SIG_IGN);
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

int run(const SlaveCommand& command) {
  // Before any thread starts, so that all inherit it and only main takes them.
  const sigset_t signals = waited_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);

  init_log(command.log_level, command.log_format);
  std::shared_ptr<net::TlsContext> tls;
  if (!command.keys_folder.empty()) {
    Result<std::shared_ptr<net::TlsContext>> loaded =
        net::TlsContext::load(command.keys_folder, "slave");
    if (!loaded.is_ok()) {
      std::fprintf(stderr, "tessera-slave: %s\n", loaded.status().message().c_str());
      return 1;
    }
    tls = std::move(*loaded);
  }
  log_info("slave-started", "looking for the master",
           {{"master", command.master.text()},
            {"name", command.options.name},
            {"threads", std::to_string(command.options.threads)}});

  Fatal fatal;
  net::IoThread io("net");
  SlaveNode node(io, command.options,
                 [&io, &command, tls](std::function<void(Result<net::ConnectionPtr>)> on_connected) {
                   return net::connect(io, command.master, tls, "master",
                                       std::chrono::milliseconds(kHandshakeMs),
                                       std::move(on_connected));
                 });
  const pthread_t main_thread = pthread_self();
  node.start([&fatal, main_thread](Status status) {
    {
      MutexLock lock(fatal.mutex);
      fatal.status = std::move(status);
    }
    pthread_kill(main_thread, SIGUSR1);
  });
  int signal_number = 0;
  sigwait(&signals, &signal_number);
  arm_second_signal(signals);
  node.stop();
  io.stop();
  MutexLock lock(fatal.mutex);
  if (fatal.status.is_ok()) {
    log_info("slave-stopped", "stopped on request");
    return 0;
  }
  std::fprintf(stderr, "tessera-slave: %s\n", fatal.status.message().c_str());
  return 1;
}

}  // namespace
}  // namespace tessera::slave

int main(int argc, char** argv) {
  try {
    const tessera::slave::ParsedCommand parsed = tessera::slave::parse_command_line(argc, argv);
    return parsed.exit_code ? *parsed.exit_code : tessera::slave::run(parsed.command);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "tessera-slave: %s\n", e.what());
    return 1;
  }
}
