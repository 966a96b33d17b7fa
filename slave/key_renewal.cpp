// SPDX-License-Identifier: Apache-2.0
#include "slave/key_renewal.h"

#include <ctime>
#include <utility>

#include "common/base/log.h"

namespace tessera::slave {

std::optional<std::vector<std::byte>> KeyRenewal::request() {
  const TimePoint now = Clock::now();
  if (now < next_ || !net::is_renewal_due(tls_->life(), std::time(nullptr))) return std::nullopt;
  next_ = now + kPause;
  asked_.emplace();
  return asked_->der();
}

void KeyRenewal::granted(const wire::CertificateGrant& grant) {
  const auto asked = std::exchange(asked_, std::nullopt);
  if (!asked) return;  // of an hour before; the newer request is not answered yet, or was
  if (!grant.reason.empty()) {
    return log_warn("certificate-kept", "the master gives no new certificate: " + grant.reason,
                    {{"certificate", tls_->certificate_text()}});
  }
  const Status status = asked->take_over(tls_->folder(), grant.der);
  if (!status.is_ok()) return log_warn("certificate-kept", status.message());
  log_info("certificate-renewed", "a new certificate is in " + tls_->folder());
}

RenewalAccess renewal_access(std::shared_ptr<net::TlsContext> tls) {
  if (!tls) return {};
  const auto renewal = std::make_shared<KeyRenewal>(std::move(tls));
  return {[renewal] { return renewal->request(); },
          [renewal](const wire::CertificateGrant& grant) { renewal->granted(grant); }};
}

}  // namespace tessera::slave
