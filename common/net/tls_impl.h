// SPDX-License-Identifier: Apache-2.0
// The OpenSSL side of TlsContext, for common/net alone.
// Threads. As tls.h says. No header outside this folder includes it, so that OpenSSL stays here.
#pragma once

#include <asio/ssl.hpp>
#include <functional>
#include <optional>
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
  std::function<Record(const std::string& reason)> refusal;  // null: refused in silence

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

// Why the peer's certificate is refused; nothing where it is good. A server's handshake is
// completed with a bad one, too, so that the peer can be told in words: TLS itself has 8 bits, the
// same for a wrong clock as for damage. So every server must ask this after its handshake, and hand
// on no link that it has an answer for.
std::optional<HandshakeFailure> refusal_of(SSL* ssl);

// What the peer's alert over our certificate means, in words; empty for an error that is none.
std::string certificate_alert_text(const asio::error_code& error);

}  // namespace tessera::net
