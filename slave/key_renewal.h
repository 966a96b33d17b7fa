// SPDX-License-Identifier: Apache-2.0
// Renews the certificate of a slave through its master: asks at two thirds of its life, once an
// hour at most, and puts what comes into the slave's folder, where the watch of credentials finds
// it. The private key is made here and stays here.
//
// Threads. The event loop's thread only.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/base/clock.h"
#include "common/net/key_request.h"
#include "common/net/tls.h"
#include "common/wire/messages.h"

namespace tessera::slave {

// What a slave node does about its certificate; empty where it has none.
struct RenewalAccess {
  std::function<std::optional<std::vector<std::byte>>()> request;  // nothing: none is due
  std::function<void(const wire::CertificateGrant&)> granted;
};

class KeyRenewal {
 public:
  static constexpr std::chrono::hours kPause{1};

  explicit KeyRenewal(std::shared_ptr<net::TlsContext> tls) : tls_(std::move(tls)) {}

  std::optional<std::vector<std::byte>> request();
  void granted(const wire::CertificateGrant& grant);

 private:
  const std::shared_ptr<net::TlsContext> tls_;
  std::optional<net::KeyRequest> asked_;
  TimePoint next_{};  // no earlier is it asked again
};

RenewalAccess renewal_access(std::shared_ptr<net::TlsContext> tls);

}  // namespace tessera::slave
