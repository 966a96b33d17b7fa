// SPDX-License-Identifier: Apache-2.0
#include "common/net/key_renewal.h"

#include <unistd.h>

#include <ctime>
#include <utility>

#include "common/base/log.h"

namespace tessera::net {

std::optional<std::vector<std::byte>> KeyRenewal::request() {
  const TimePoint now = Clock::now();
  if (now < next_ || !is_renewal_due(tls_->life(), std::time(nullptr))) return std::nullopt;
  next_ = now + kPause;
  if (access(tls_->folder().c_str(), W_OK) != 0) {
    log_warn("certificate-kept", "the certificate is due for renewal, but " + tls_->folder() +
                                     " cannot be written; renew it there with 'tessera-keys "
                                     "renew DIR " +
                                     tls_->name() + "'");
    return std::nullopt;
  }
  asked_.emplace();
  return asked_->der();
}

void KeyRenewal::granted(std::span<const std::byte> certificate, const std::string& reason) {
  const auto asked = std::exchange(asked_, std::nullopt);
  if (!asked) return;  // of an hour before; the newer request is not answered yet, or was
  if (!reason.empty()) {
    return log_warn("certificate-kept", "the master gives no new certificate: " + reason,
                    {{"certificate", tls_->certificate_text()}});
  }
  const Status status = asked->take_over(tls_->folder(), certificate);
  if (!status.is_ok()) return log_warn("certificate-kept", status.message());
  log_info("certificate-renewed", "a new certificate is in " + tls_->folder());
}

RenewalAccess renewal_access(std::shared_ptr<TlsContext> tls) {
  if (!tls) return {};
  const auto renewal = std::make_shared<KeyRenewal>(std::move(tls));
  return {[renewal] { return renewal->request(); },
          [renewal](std::span<const std::byte> certificate, const std::string& reason) {
            renewal->granted(certificate, reason);
          }};
}

}  // namespace tessera::net
