#include "common/net/tls.h"

#include <openssl/pem.h>
#include <openssl/x509_vfy.h>
#include <sys/stat.h>

#include <cstdio>
#include <memory>

#include "common/net/io_thread_asio.h"
#include "common/net/tls_impl.h"

namespace tessera::net {
namespace {

using X509Ptr = std::unique_ptr<X509, decltype(&X509_free)>;

std::string entry_of(X509* certificate, int nid) {
  char text[256] = {};
  X509_NAME* subject = X509_get_subject_name(certificate);
  const int length = X509_NAME_get_text_by_NID(subject, nid, text, sizeof(text));
  return length > 0 ? std::string(text, static_cast<std::size_t>(length)) : std::string();
}

X509Ptr read_certificate(const std::string& path) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "re"),
                                                       &std::fclose);
  return {file ? PEM_read_X509(file.get(), nullptr, nullptr, nullptr) : nullptr, &X509_free};
}

Status check_files(const std::string& folder, const std::string& role) {
  const std::string mend =
      "; make it with 'tessera-keys init cluster' and 'tessera-keys add cluster " + role + " NAME'";
  struct stat info {};
  if (stat(folder.c_str(), &info) != 0 || !S_ISDIR(info.st_mode)) {
    return Status::not_found("keys folder " + folder + " does not exist" + mend);
  }
  for (const char* name : {"ca.crt", "node.crt", "node.key"}) {
    const std::string path = folder + "/" + name;
    if (stat(path.c_str(), &info) != 0)
      return Status::not_found("keys folder " + folder + " has no " + name + mend);
  }
  if ((info.st_mode & (S_IRWXG | S_IRWXO)) != 0) {  // node.key, the last one looked at
    return Status::permission_denied(folder + "/node.key can be read by others; run 'chmod 600 " +
                                     folder + "/node.key'");
  }
  return Status::ok();
}

Status check_certificate(const std::string& folder, const std::string& role, std::string& name) {
  const X509Ptr own = read_certificate(folder + "/node.crt");
  const X509Ptr ca = read_certificate(folder + "/ca.crt");
  if (!own || !ca)
    return Status::permission_denied("keys folder " + folder +
                                     ": node.crt or ca.crt is not a certificate");
  name = entry_of(own.get(), NID_commonName);
  const std::string own_role = entry_of(own.get(), NID_organizationalUnitName);
  if (own_role != role) {
    return Status::permission_denied(
        "the certificate in " + folder + " has role '" + own_role + "', but role '" + role +
        "' is needed; use a folder made by 'tessera-keys add cluster " + role + " NAME'");
  }
  if (X509_verify(own.get(), X509_get0_pubkey(ca.get())) != 1) {
    return Status::permission_denied("the certificate in " + folder +
                                     " is not signed by the ca.crt beside it");
  }
  if (X509_cmp_current_time(X509_get0_notAfter(own.get())) < 0) {
    return Status::permission_denied(
        "the certificate in " + folder +
        " has expired; make a new one with 'tessera-keys add cluster " + role + " NAME'");
  }
  if (X509_cmp_current_time(X509_get0_notBefore(own.get())) > 0) {
    return Status::permission_denied("the certificate in " + folder +
                                     " is not valid yet; is this machine's clock right?");
  }
  return Status::ok();
}

void configure(asio::ssl::context& context, const std::string& folder) {
  SSL_CTX* native = context.native_handle();
  SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION);
  SSL_CTX_set_num_tickets(native, 0);
  SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
  context.load_verify_file(folder + "/ca.crt");
  context.use_certificate_file(folder + "/node.crt", asio::ssl::context::pem);
  context.use_private_key_file(folder + "/node.key", asio::ssl::context::pem);
  context.set_verify_mode(asio::ssl::verify_peer | asio::ssl::verify_fail_if_no_peer_cert);
}

}  // namespace

Result<std::shared_ptr<TlsContext>> TlsContext::load(const std::string& folder,
                                                     const std::string& role) {
  TESSERA_RETURN_IF_ERROR(check_files(folder, role));
  auto impl = std::make_unique<Impl>();
  TESSERA_RETURN_IF_ERROR(check_certificate(folder, role, impl->name));
  try {
    configure(impl->server, folder);
    configure(impl->client, folder);
  } catch (const asio::system_error& error) {
    return Status::permission_denied("keys folder " + folder + ": " + error.what());
  }
  if (SSL_CTX_check_private_key(impl->client.native_handle()) != 1) {
    return Status::permission_denied("keys folder " + folder +
                                     ": node.key does not belong to node.crt");
  }
  return std::make_shared<TlsContext>(std::move(impl));
}

TlsContext::TlsContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TlsContext::~TlsContext() = default;
const std::string& TlsContext::name() const { return impl_->name; }

PeerIdentity identity_of(SSL* ssl) {
  PeerIdentity identity;
  const X509Ptr certificate(SSL_get1_peer_certificate(ssl), &X509_free);
  if (!certificate) return identity;
  identity.is_authenticated = true;
  identity.role = entry_of(certificate.get(), NID_organizationalUnitName);
  identity.name = entry_of(certificate.get(), NID_commonName);
  return identity;
}

std::string handshake_failure(SSL* ssl, const asio::error_code& error) {
  const long result = SSL_get_verify_result(ssl);
  if (result == X509_V_OK) return error.message();
  const X509Ptr certificate(SSL_get1_peer_certificate(ssl), &X509_free);
  std::string text = X509_verify_cert_error_string(result);
  if (certificate) {
    text = "certificate of " + entry_of(certificate.get(), NID_organizationalUnitName) + " '" +
           entry_of(certificate.get(), NID_commonName) + "': " + text;
  }
  return text;
}

}  // namespace tessera::net
