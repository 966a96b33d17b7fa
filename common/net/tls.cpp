// SPDX-License-Identifier: Apache-2.0
#include "common/net/tls.h"

#include <openssl/err.h>
#include <openssl/x509_vfy.h>

#include <chrono>
#include <ctime>
#include <memory>
#include <thread>
#include <utility>

#include "common/net/io_thread_asio.h"
#include "common/net/tls_impl.h"

namespace tessera::net {
namespace {

// A renewal is two renames: a folder found in between is whole a moment later.
constexpr int kTriesMax = 5;
constexpr std::chrono::milliseconds kTryPause{50};

bool is_halfway(const Status& status) { return status.code() == StatusCode::kUnavailable; }

// The clock that certificates are judged by, which is the first suspect when they are refused.
std::string clock_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[sizeof("2027-11-22 10:00 UTC")] = {};
  std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M UTC", &utc);
  return text;
}

std::string reason_of(long verdict) {
  switch (verdict) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return "has expired by the clock of the one that refuses it (" + clock_text() + ")";
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return "is not valid yet by the clock of the one that refuses it (" + clock_text() +
             "); do the clocks of both machines agree?";
    case X509_V_ERR_CERT_REVOKED:
      return "has been revoked";
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
      return "is signed by itself and not by this cluster's CA";
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:  // the other cluster's CA came with it
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
      return "is of another cluster: not signed by this one's CA";
    default:
      return std::string("is refused: ") + X509_verify_cert_error_string(verdict);
  }
}

// Index under which a TLS session keeps why it refuses the peer's certificate: OpenSSL itself
// forgets a certificate that does not verify.
int refusal_index() {
  static const int index = SSL_get_ex_new_index(
      0, nullptr, nullptr, nullptr, [](void*, void* refusal, CRYPTO_EX_DATA*, int, long, void*) {
        delete static_cast<HandshakeFailure*>(refusal);
      });
  return index;
}

// Keeps the first thing that is wrong. Returns: whether that is kept.
bool keep_refusal(X509_STORE_CTX* store) {
  auto* const ssl =
      static_cast<SSL*>(X509_STORE_CTX_get_ex_data(store, SSL_get_ex_data_X509_STORE_CTX_idx()));
  X509* const certificate = X509_STORE_CTX_get0_cert(store);  // the peer's, not an issuer's
  if (ssl == nullptr || certificate == nullptr) return false;
  if (SSL_get_ex_data(ssl, refusal_index()) != nullptr) return true;
  auto refusal = std::make_unique<HandshakeFailure>(
      HandshakeFailure{subject_text(certificate), reason_of(X509_STORE_CTX_get_error(store))});
  if (SSL_set_ex_data(ssl, refusal_index(), refusal.get()) != 1) return false;
  (void)refusal.release();  // the session's now
  return true;
}

int judge_as_client(int is_good, X509_STORE_CTX* store) {
  if (is_good != 1) (void)keep_refusal(store);
  return is_good;
}

// Lets the handshake end, for the last word of refusal_of(), if that will know of the refusal.
int judge_as_server(int is_good, X509_STORE_CTX* store) {
  return is_good == 1 || keep_refusal(store) ? 1 : 0;
}

// OpenSSL has a last word on keys and certificates that were read whole: a key that is too short,
// say.
Status not_taken(const KeyFolder& keys, const char* file) {
  const unsigned long code = ERR_peek_last_error();
  const char* const reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  ERR_clear_error();
  return Status::permission_denied(std::string("OpenSSL does not take ") + file + " of '" +
                                   keys.name + "': " + (reason == nullptr ? "unknown" : reason) +
                                   "; make a new one with 'tessera-keys renew cluster " +
                                   keys.name + "'");
}

Status configure(asio::ssl::context& context, const KeyFolder& keys, SSL_verify_cb judge) {
  SSL_CTX* const native = context.native_handle();
  SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION);
  SSL_CTX_set_num_tickets(native, 0);
  SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
  X509_STORE* const store = SSL_CTX_get_cert_store(native);
  ERR_clear_error();
  if (X509_STORE_add_cert(store, keys.ca.get()) != 1) return not_taken(keys, "ca.crt");
  if (keys.revoked) {
    if (X509_STORE_add_crl(store, keys.revoked.get()) != 1) return not_taken(keys, "crl.pem");
    X509_STORE_set_flags(store, X509_V_FLAG_CRL_CHECK);
  }
  if (SSL_CTX_use_certificate(native, keys.own.get()) != 1) return not_taken(keys, "node.crt");
  if (SSL_CTX_use_PrivateKey(native, keys.key.get()) != 1) return not_taken(keys, "node.key");
  SSL_CTX_set_verify(native, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, judge);
  return Status::ok();
}

Result<std::unique_ptr<TlsEnds>> make_ends(const KeyFolder& keys) {
  auto ends = std::make_unique<TlsEnds>();
  TESSERA_RETURN_IF_ERROR(configure(ends->server, keys, &judge_as_server));
  TESSERA_RETURN_IF_ERROR(configure(ends->client, keys, &judge_as_client));
  return ends;
}

Status take_ends(Result<std::unique_ptr<TlsEnds>> made, std::unique_ptr<TlsEnds>& ends) {
  if (!made.is_ok()) return made.status();
  ends = std::move(*made);
  return Status::ok();
}

bool is_same(X509* a, X509* b) { return X509_cmp(a, b) == 0; }

// Whether `fresh` may follow `used`: the same CA never takes back what it revoked.
Status check_not_older(X509_CRL* used, X509_CRL* fresh, const std::string& folder) {
  if (number_of(fresh) >= number_of(used)) return Status::ok();
  return Status::permission_denied(
      folder + "/crl.pem is older than the list in use, or missing; copy the newest one again");
}

}  // namespace

Result<std::shared_ptr<TlsContext>> TlsContext::load(const std::string& folder,
                                                     const std::string& role) {
  auto keys = read_key_folder(folder, role);
  for (int tries = 1; tries < kTriesMax && is_halfway(keys.status()); ++tries) {
    std::this_thread::sleep_for(kTryPause);
    keys = read_key_folder(folder, role);
  }
  if (!keys.is_ok()) return keys.status();
  auto impl = std::make_unique<Impl>();
  impl->folder = folder;
  impl->role = role;
  impl->keys = std::move(*keys);
  auto ends = make_ends(impl->keys);
  if (!ends.is_ok()) return ends.status();
  impl->ends = std::move(*ends);
  return std::make_shared<TlsContext>(std::move(impl));
}

Result<bool> TlsContext::reload() {
  KeyFolder& used = impl_->keys;
  auto read = read_key_folder(impl_->folder, impl_->role);
  Status status = read.status();
  const bool is_same_ca = !read.is_ok() || is_same(read->ca.get(), used.ca.get());
  if (status.is_ok() && read->name != used.name) {
    status = Status::permission_denied("the certificate in " + impl_->folder + " is now that of '" +
                                       read->name + "', and this process runs as '" + used.name +
                                       "'; start it again to change its name");
  }
  if (status.is_ok() && is_same_ca)
    status = check_not_older(used.revoked.get(), read->revoked.get(), impl_->folder);
  const std::int64_t list_before = number_of(used.revoked.get());
  bool is_new = false;
  std::unique_ptr<TlsEnds> fresh;
  if (status.is_ok()) {
    is_new = !is_same_ca || !is_same(read->own.get(), used.own.get()) ||
             number_of(read->revoked.get()) != list_before;
    if (is_new) status = take_ends(make_ends(*read), fresh);
  }
  if (status.is_ok()) {
    used = std::move(*read);
  } else if (auto list = read_revocations(impl_->folder, used.ca.get());
             list.is_ok() && number_of(list->get()) > list_before) {
    used.revoked = std::move(*list);  // revoking must not wait for a renewal
    is_new = true;
    if (const Status taken = take_ends(make_ends(used), fresh); !taken.is_ok()) status = taken;
  }
  if (fresh) impl_->ends = std::move(fresh);
  if (is_new) {
    for (const auto& connection : impl_->open) impl_->end_if_revoked(connection.lock());
  }
  if (!status.is_ok()) return status;
  return is_new;
}

void TlsContext::Impl::watch(const ConnectionPtr& connection) {
  std::erase_if(open, [](const auto& other) { return other.expired(); });
  open.push_back(connection);
  end_if_revoked(connection);
}

void TlsContext::Impl::end_if_revoked(const ConnectionPtr& connection) const {
  if (!connection || !is_revoked(keys.revoked.get(), connection->peer().serial)) return;
  const PeerIdentity& peer = connection->peer();
  connection->end_soon(Status::permission_denied("the certificate of " + peer.role + " '" +
                                                 peer.name + "' has been revoked"));
}

TlsContext::TlsContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TlsContext::~TlsContext() = default;
void TlsContext::set_refusal(std::function<Record(const std::string& reason)> refusal) {
  impl_->refusal = std::move(refusal);
}
const std::string& TlsContext::folder() const { return impl_->folder; }
const std::string& TlsContext::name() const { return impl_->keys.name; }

std::string TlsContext::subject() const { return subject_text(impl_->keys.own.get()); }
CertificateLife TlsContext::life() const {
  return life_of(impl_->keys.own.get(), impl_->keys.ca.get());
}

std::string TlsContext::certificate_text() const {
  X509* const own = impl_->keys.own.get();
  return serial_text(own) + ", valid until " + last_day_text(own);
}

PeerIdentity identity_of(SSL* ssl) {
  PeerIdentity identity;
  const Certificate certificate(SSL_get1_peer_certificate(ssl));
  if (!certificate) return identity;
  identity.is_authenticated = true;
  identity.role = entry_of(certificate.get(), NID_organizationalUnitName);
  identity.name = entry_of(certificate.get(), NID_commonName);
  identity.serial = serial_text(certificate.get());
  identity.life = life_of(certificate.get(), certificate.get());
  return identity;
}

HandshakeFailure handshake_failure(SSL* ssl, const asio::error_code& error) {
  const std::string alert = certificate_alert_text(error);
  if (!alert.empty()) return {"", "it refused our certificate, which " + alert};
  return refusal_of(ssl).value_or(HandshakeFailure{"", error.message()});
}

std::optional<HandshakeFailure> refusal_of(SSL* ssl) {
  const auto* const kept =
      static_cast<const HandshakeFailure*>(SSL_get_ex_data(ssl, refusal_index()));
  if (kept != nullptr) return *kept;
  const long verdict = SSL_get_verify_result(ssl);  // by OpenSSL itself, should it not have asked
  if (verdict != X509_V_OK) return HandshakeFailure{"a peer", reason_of(verdict)};
  return std::nullopt;
}

std::string certificate_alert_text(const asio::error_code& error) {
  if (error.category() != asio::error::get_ssl_category()) return {};
  switch (ERR_GET_REASON(static_cast<unsigned long>(error.value()))) {
    case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
      return "is not valid yet by its clock, or damaged; do the clocks of both machines agree?";
    case SSL_R_SSLV3_ALERT_CERTIFICATE_EXPIRED:
      return "has expired by its clock";
    case SSL_R_SSLV3_ALERT_CERTIFICATE_REVOKED:
      return "has been revoked";
    case SSL_R_TLSV1_ALERT_UNKNOWN_CA:
      return "is of another cluster: not signed by the CA there";
    case SSL_R_TLSV13_ALERT_CERTIFICATE_REQUIRED:
      return "it did not get";
    case SSL_R_SSLV3_ALERT_UNSUPPORTED_CERTIFICATE:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_UNKNOWN:
      return "it cannot make use of (" + error.message() + ")";
    default:
      return {};
  }
}

}  // namespace tessera::net
