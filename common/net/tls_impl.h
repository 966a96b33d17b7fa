// SPDX-License-Identifier: Apache-2.0
// The OpenSSL side of TlsContext, for common/net alone.
// Threads. As tls.h says. No header outside this folder includes it, so that OpenSSL stays here.
#pragma once

#include <asio/ssl.hpp>
#include <string>
#include <vector>

#include "common/net/connection.h"
#include "common/net/key_folder.h"
#include "common/net/tls.h"

namespace tessera::net {

// The two contexts of one state of the credentials. A TLS stream keeps what it needs of them.
struct TlsEnds {
  asio::ssl::context server{asio::ssl::context::tls_server};
  asio::ssl::context client{asio::ssl::context::tls_client};
};

struct TlsContext::Impl {
  std::string folder, role;
  KeyFolder keys;
  std::unique_ptr<TlsEnds> ends;
  std::vector<std::weak_ptr<Connection>> open;

  // Watches a fresh connection, to end it when its peer is revoked: at once, if that happened
  // during the handshake.
  void watch(const ConnectionPtr& connection);
  void end_if_revoked(const ConnectionPtr& connection) const;  // null: it is gone already
};

// Role, name and serial number out of the peer's certificate. Requires: the handshake is done.
PeerIdentity identity_of(SSL* ssl);

// Why a handshake failed, for a person.
struct HandshakeFailure {
  std::string subject;  // of the peer's certificate, where that is what we refused; else empty
  std::string reason;
  std::string text() const {
    return subject.empty() ? reason : "certificate of " + subject + " " + reason;
  }
};
HandshakeFailure handshake_failure(SSL* ssl, const asio::error_code& error);

// Whether the peer ended the link over our certificate, and not over damaged bytes.
bool is_certificate_alert(const asio::error_code& error);

}  // namespace tessera::net
