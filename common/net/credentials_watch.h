// SPDX-License-Identifier: Apache-2.0
// Keeps the credentials in use equal to those in their folder, which is read again on SIGHUP, and
// when its files have changed and then stayed as they are for one look. Each reload gives one log
// line, and so does each reason why one failed. A certificate that ends within a day is told of in
// the log, at once and then every hour, whoever is to renew it.
//
// Threads. The io thread of the credentials, construction and destruction included.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "common/net/io_thread.h"
#include "common/net/tls.h"

namespace tessera::net {

// Time between two looks at the folder. A revocation counts within two of them without a signal,
// far below the 60 s promised.
inline constexpr std::chrono::milliseconds kCredentialsLook{1000};

class CredentialsWatch {
 public:
  CredentialsWatch(IoThread& io, std::shared_ptr<TlsContext> tls,
                   std::chrono::milliseconds look = kCredentialsLook);

 private:
  void look();
  void reload(bool is_asked_for);
  void tell_of_expiry();

  const std::shared_ptr<TlsContext> tls_;
  std::uint64_t hangups_;
  std::string read_stamp_, last_stamp_;  // of what was read last; of the last look
  std::string last_failure_;             // logged once
  ExpiryNotice expiry_;
  Timer timer_;
};

}  // namespace tessera::net
