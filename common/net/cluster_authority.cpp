// SPDX-License-Identifier: Apache-2.0
#include "common/net/cluster_authority.h"

#include <openssl/rand.h>

#include <utility>

#include "common/base/check.h"
#include "common/net/key_folder.h"

namespace tessera::net {
namespace {

constexpr long kSecondsPerDay = 86400;
// A certificate holds from so long before it is made: the clocks of machines differ, by hours where
// one was set to another time zone.
constexpr long kClockDifferenceSeconds = kSecondsPerDay;

void add_entry(X509_NAME* name, const char* field, const std::string& value) {
  X509_NAME_add_entry_by_txt(name, field, MBSTRING_UTF8,
                             reinterpret_cast<const unsigned char*>(value.data()),
                             static_cast<int>(value.size()), -1, 0);
}

void add_extension(X509* certificate, X509* issuer, int nid, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, nid, value);
  TESSERA_CHECK(extension != nullptr);
  X509_add_ext(certificate, extension, -1);
  X509_EXTENSION_free(extension);
}

Certificate new_certificate(EVP_PKEY* key, const Validity& validity) {
  Certificate certificate(X509_new());
  X509_set_version(certificate.get(), 2);
  unsigned char serial[16];
  TESSERA_CHECK_EQ(RAND_bytes(serial, sizeof(serial)), 1);
  serial[0] &= 0x7f;
  BIGNUM* number = BN_bin2bn(serial, sizeof(serial), nullptr);
  BN_to_ASN1_INTEGER(number, X509_get_serialNumber(certificate.get()));
  BN_free(number);
  const long first = validity.days < 0 ? validity.days - 1L : validity.starts_in_days;
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()),
                  first * kSecondsPerDay - kClockDifferenceSeconds);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()),
                  (validity.starts_in_days + validity.days) * kSecondsPerDay);
  X509_set_pubkey(certificate.get(), key);
  return certificate;
}

std::string random_hex() {
  unsigned char bytes[8];
  TESSERA_CHECK_EQ(RAND_bytes(bytes, sizeof(bytes)), 1);
  std::string text;
  for (const unsigned char b : bytes) {
    static constexpr char kDigits[] = "0123456789abcdef";
    text.push_back(kDigits[b >> 4]);
    text.push_back(kDigits[b & 15]);
  }
  return text;
}

void add_revoked(X509_CRL* list, const std::string& serial) {
  BIGNUM* number = nullptr;
  TESSERA_CHECK(BN_hex2bn(&number, serial.c_str()) > 0);
  ASN1_INTEGER* const integer = BN_to_ASN1_INTEGER(number, nullptr);
  ASN1_TIME* const now = X509_gmtime_adj(nullptr, 0);
  X509_REVOKED* const entry = X509_REVOKED_new();
  X509_REVOKED_set_serialNumber(entry, integer);
  X509_REVOKED_set_revocationDate(entry, now);
  TESSERA_CHECK_EQ(X509_CRL_add0_revoked(list, entry), 1);  // the list owns the entry now
  ASN1_TIME_free(now);
  ASN1_INTEGER_free(integer);
  BN_free(number);
}

}  // namespace

KeyPair ClusterAuthority::make() {
  KeyPair ca;
  ca.key.reset(EVP_EC_gen("P-256"));
  ca.certificate = new_certificate(ca.key.get(), {kCaDays, 0});
  X509* const certificate = ca.certificate.get();
  X509_NAME* const name = X509_get_subject_name(certificate);
  add_entry(name, "O", "Tessera cluster " + random_hex());
  add_entry(name, "CN", "Tessera CA");
  X509_set_issuer_name(certificate, name);
  add_extension(certificate, certificate, NID_basic_constraints, "critical,CA:TRUE,pathlen:0");
  add_extension(certificate, certificate, NID_key_usage, "critical,keyCertSign,cRLSign");
  add_extension(certificate, certificate, NID_subject_key_identifier, "hash");
  X509_sign(certificate, ca.key.get(), EVP_sha256());
  return ca;
}

Result<ClusterAuthority> ClusterAuthority::open(const std::string& folder) {
  TESSERA_RETURN_IF_ERROR(check_not_open_to_others(folder));
  KeyPair ca{read_private_key(folder + "/ca.key"), read_certificate(folder + "/ca.crt")};
  if (!ca.certificate || !ca.key) {
    return Status::not_found(folder + " has no CA; make one with 'tessera-keys init " + folder +
                             "'");
  }
  return ClusterAuthority(std::move(ca));
}

KeyPair ClusterAuthority::issue(const NodeIdentity& node, const Validity& validity) const {
  KeyPair pair;
  pair.key.reset(EVP_EC_gen("P-256"));
  pair.certificate = certify(pair.key.get(), node, validity);
  return pair;
}

Certificate ClusterAuthority::certify(EVP_PKEY* key, const NodeIdentity& node,
                                      const Validity& validity) const {
  Certificate made = new_certificate(key, validity);
  X509* const certificate = made.get();
  X509_NAME* const subject = X509_get_subject_name(certificate);
  add_entry(subject, "OU", node.role);
  add_entry(subject, "CN", node.name);
  X509* const ca = ca_.certificate.get();
  X509_set_issuer_name(certificate, X509_get_subject_name(ca));
  add_extension(certificate, ca, NID_basic_constraints, "critical,CA:FALSE");
  add_extension(certificate, ca, NID_key_usage, "critical,digitalSignature");
  add_extension(certificate, ca, NID_ext_key_usage, "serverAuth,clientAuth");
  add_extension(certificate, ca, NID_authority_key_identifier, "keyid");
  X509_sign(certificate, ca_.key.get(), EVP_sha256());
  return made;
}

// The list holds from the CA's first day to its last: its number says which is the newest, and a
// machine whose clock is wrong does not lose its cluster over it.
RevocationList ClusterAuthority::revoke(X509_CRL* old,
                                        const std::vector<std::string>& serials) const {
  RevocationList list(old != nullptr ? X509_CRL_dup(old) : X509_CRL_new());
  X509* const ca = ca_.certificate.get();
  X509_CRL_set_version(list.get(), 1);
  X509_CRL_set_issuer_name(list.get(), X509_get_subject_name(ca));
  X509_CRL_set1_lastUpdate(list.get(), X509_get0_notBefore(ca));
  X509_CRL_set1_nextUpdate(list.get(), X509_get0_notAfter(ca));
  for (const std::string& serial : serials) add_revoked(list.get(), serial);
  ASN1_INTEGER* const number = ASN1_INTEGER_new();
  ASN1_INTEGER_set_int64(number, number_of(old) + 1);
  TESSERA_CHECK_EQ(X509_CRL_add1_ext_i2d(list.get(), NID_crl_number, number, 0, X509V3_ADD_REPLACE),
                   1);
  ASN1_INTEGER_free(number);
  X509_CRL_sort(list.get());
  X509_CRL_sign(list.get(), ca_.key.get(), EVP_sha256());
  return list;
}

}  // namespace tessera::net
