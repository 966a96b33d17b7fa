// SPDX-License-Identifier: Apache-2.0
// Renews the certificate of a node through its master: asks at two thirds of its life, once an
// hour at most, and puts what comes into the node's folder, where the watch of credentials finds
// it. The private key is made here and stays here. How the two messages travel is for slaves and
// applications to say.
//
// Threads. The event loop's thread only.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/net/key_request.h"
#include "common/net/tls.h"

namespace tessera::net {

// A node that is connected looks so often whether its certificate is due.
inline constexpr std::chrono::minutes kRenewalLook{1};

// What a node does about its certificate; empty where it has none.
struct RenewalAccess {
  std::function<std::optional<std::vector<std::byte>>()> request;  // nothing: none is due
  // `reason`: why there is no certificate; empty where there is one.
  std::function<void(std::span<const std::byte> certificate, const std::string& reason)> granted;
};

class KeyRenewal {
 public:
  static constexpr std::chrono::hours kPause{1};

  explicit KeyRenewal(std::shared_ptr<TlsContext> tls) : tls_(std::move(tls)) {}

  // Where the folder cannot be written nothing is asked for, and a line says so.
  std::optional<std::vector<std::byte>> request();
  void granted(std::span<const std::byte> certificate, const std::string& reason);

 private:
  const std::shared_ptr<TlsContext> tls_;
  std::optional<KeyRequest> asked_;
  TimePoint next_{};  // no earlier is it asked again
};

RenewalAccess renewal_access(std::shared_ptr<TlsContext> tls);

}  // namespace tessera::net
