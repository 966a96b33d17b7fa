// SPDX-License-Identifier: Apache-2.0
#include "common/net/key_request.h"

#include "common/base/check.h"
#include "common/net/file_write.h"
#include "common/net/x509.h"

namespace tessera::net {
namespace {

constexpr mode_t kPrivate = 0600, kPublic = 0644;

bool is_of_the_same_node(X509* a, X509* b) {
  return entry_of(a, NID_commonName) == entry_of(b, NID_commonName) &&
         entry_of(a, NID_organizationalUnitName) == entry_of(b, NID_organizationalUnitName);
}

}  // namespace

struct KeyRequest::Key {
  PrivateKey key;
};

KeyRequest::KeyRequest() : key_(std::make_unique<Key>()) { key_->key.reset(EVP_EC_gen("P-256")); }
KeyRequest::~KeyRequest() = default;
KeyRequest::KeyRequest(KeyRequest&&) noexcept = default;
KeyRequest& KeyRequest::operator=(KeyRequest&&) noexcept = default;

std::vector<std::byte> KeyRequest::der() const {
  const CertificateRequest request(X509_REQ_new());
  EVP_PKEY* const key = key_->key.get();
  TESSERA_CHECK_EQ(X509_REQ_set_pubkey(request.get(), key), 1);
  TESSERA_CHECK(X509_REQ_sign(request.get(), key, EVP_sha256()) > 0);
  return der_of(request.get());
}

Status KeyRequest::take_over(const std::string& folder, std::span<const std::byte> der) const {
  const Certificate fresh = certificate_of(der);
  const Certificate ca = read_certificate(folder + "/ca.crt");
  const Certificate used = read_certificate(folder + "/node.crt");
  const auto denied = [&](const std::string& why) {
    return Status::permission_denied("the certificate that came for " + folder + " " + why);
  };
  if (!fresh) return denied("is none");
  if (!ca || X509_verify(fresh.get(), X509_get0_pubkey(ca.get())) != 1)
    return denied("is not signed by the ca.crt there");
  if (X509_check_private_key(fresh.get(), key_->key.get()) != 1)
    return denied("is of another key than was asked for");
  if (!used || !is_of_the_same_node(fresh.get(), used.get()))
    return denied("is of another name or role: " + subject_text(fresh.get()));
  // Nothing but two renames lies between the old pair and the new one, as in renew_key().
  auto key = Replacement::write(folder + "/node.key", pem_of(key_->key.get()), kPrivate);
  if (!key.is_ok()) return key.status();
  auto certificate = Replacement::write(folder + "/node.crt", pem_of(fresh.get()), kPublic);
  if (!certificate.is_ok()) return certificate.status();
  TESSERA_RETURN_IF_ERROR(key->commit());
  return certificate->commit();
}

}  // namespace tessera::net
