// The OpenSSL side of TlsContext, for common/net alone.
// Threads. Immutable once made. No header outside this folder includes it, so that OpenSSL stays
// here.
#pragma once

#include <asio/ssl.hpp>
#include <string>

#include "common/net/connection.h"
#include "common/net/tls.h"

namespace tessera::net {

struct TlsContext::Impl {
  asio::ssl::context server{asio::ssl::context::tls_server};
  asio::ssl::context client{asio::ssl::context::tls_client};
  std::string name;
};

// Role and name out of the peer's certificate. Requires: the handshake is done.
PeerIdentity identity_of(SSL* ssl);

// Why the handshake failed, for a person: names the peer's certificate and the reason where there
// is one.
std::string handshake_failure(SSL* ssl, const asio::error_code& error);

}  // namespace tessera::net
