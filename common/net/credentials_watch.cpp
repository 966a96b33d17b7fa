// SPDX-License-Identifier: Apache-2.0
#include "common/net/credentials_watch.h"

#include <ctime>
#include <utility>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/signal_watch.h"
#include "common/net/key_folder.h"

namespace tessera::net {

CredentialsWatch::CredentialsWatch(IoThread& io, std::shared_ptr<TlsContext> tls,
                                   std::chrono::milliseconds look_interval)
    : tls_(std::move(tls)), hangups_(hangup_count()), timer_(io) {
  // read_stamp_ stays empty, so that what changed since the folder was first read is read too.
  timer_.start_repeating(look_interval, [this] { look(); });
  tell_of_expiry();
}

void CredentialsWatch::tell_of_expiry() {
  const auto when = expiry_.look(tls_->life(), std::time(nullptr), Clock::now());
  if (!when) return;
  log_warn("certificate-expires",
           "the certificate of " + tls_->subject() + " " + *when +
               " and is refused then: run 'tessera-keys renew DIR " + tls_->name() +
               "' where the cluster's folder is, and copy node.key and node.crt to " +
               tls_->folder(),
           {{"certificate", tls_->certificate_text()}});
}

void CredentialsWatch::look() {
  tell_of_expiry();
  const std::uint64_t hangups = hangup_count();
  const bool is_asked_for = std::exchange(hangups_, hangups) != hangups;
  const std::string stamp = stamp_of(tls_->folder());
  const bool lies_still = std::exchange(last_stamp_, stamp) == stamp;
  if (!is_asked_for && (stamp == read_stamp_ || !lies_still)) return;
  read_stamp_ = stamp;
  reload(is_asked_for);
}

void CredentialsWatch::reload(bool is_asked_for) {
  const auto is_new = tls_->reload();
  if (!is_new.is_ok()) {
    if (!is_asked_for && is_new.status().message() == last_failure_) return;
    last_failure_ = is_new.status().message();
    return log_warn("credentials-kept", "the old credentials stay in use: " + last_failure_);
  }
  last_failure_.clear();
  if (!*is_new && !is_asked_for) return;
  log_info("credentials-reloaded",
           *is_new ? "new connections use what " + tls_->folder() + " holds now"
                   : tls_->folder() + " holds what is in use already",
           {{"certificate", tls_->certificate_text()}});
}

}  // namespace tessera::net
