// SPDX-License-Identifier: Apache-2.0
#include "common/net/x509.h"

#include <algorithm>
#include <ctime>

#include "common/base/check.h"

namespace tessera::net {
namespace {

Bio open_for_reading(const std::string& path) { return Bio(BIO_new_file(path.c_str(), "r")); }

std::string text_of(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return std::string(data, static_cast<std::size_t>(size));
}

// What is no time is the beginning of time, by which a certificate has ended.
std::int64_t unix_time(const ASN1_TIME* time) {
  std::tm utc{};
  return ASN1_TIME_to_tm(time, &utc) == 1 ? timegm(&utc) : 0;
}

// `decode` is d2i_X509 or its like, which moves the pointer behind what it took.
template <typename Object, typename Decode>
std::unique_ptr<Object, OpenSslFree> object_of(std::span<const std::byte> der, Decode decode) {
  const auto* at = reinterpret_cast<const unsigned char*>(der.data());
  const unsigned char* const end = at + der.size();
  std::unique_ptr<Object, OpenSslFree> object(decode(nullptr, &at, static_cast<long>(der.size())));
  if (at != end) object.reset();
  return object;
}

template <typename Object, typename Encode>
std::vector<std::byte> encoded(Object* object, Encode encode) {
  const int size = encode(object, nullptr);
  TESSERA_CHECK(size > 0);
  std::vector<std::byte> der(static_cast<std::size_t>(size));
  auto* at = reinterpret_cast<unsigned char*>(der.data());
  TESSERA_CHECK_EQ(encode(object, &at), size);
  return der;
}

}  // namespace

Certificate certificate_of(std::span<const std::byte> der) {
  return object_of<X509>(der, &d2i_X509);
}
CertificateRequest request_of(std::span<const std::byte> der) {
  return object_of<X509_REQ>(der, &d2i_X509_REQ);
}
std::vector<std::byte> der_of(X509* certificate) { return encoded(certificate, &i2d_X509); }
std::vector<std::byte> der_of(X509_REQ* request) { return encoded(request, &i2d_X509_REQ); }

Certificate read_certificate(const std::string& path) {
  const Bio bio = open_for_reading(path);
  return Certificate(bio ? PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr) : nullptr);
}

PrivateKey read_private_key(const std::string& path) {
  const Bio bio = open_for_reading(path);
  return PrivateKey(bio ? PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, nullptr) : nullptr);
}

RevocationList read_revocation_list(const std::string& path) {
  const Bio bio = open_for_reading(path);
  return RevocationList(bio ? PEM_read_bio_X509_CRL(bio.get(), nullptr, nullptr, nullptr)
                            : nullptr);
}

std::string pem_of(EVP_PKEY* key) {
  const Bio bio(BIO_new(BIO_s_mem()));
  TESSERA_CHECK_EQ(PEM_write_bio_PrivateKey(bio.get(), key, nullptr, nullptr, 0, nullptr, nullptr),
                   1);
  return text_of(bio.get());
}

std::string pem_of(X509* certificate) {
  const Bio bio(BIO_new(BIO_s_mem()));
  TESSERA_CHECK_EQ(PEM_write_bio_X509(bio.get(), certificate), 1);
  return text_of(bio.get());
}

std::string pem_of(X509_CRL* list) {
  const Bio bio(BIO_new(BIO_s_mem()));
  TESSERA_CHECK_EQ(PEM_write_bio_X509_CRL(bio.get(), list), 1);
  return text_of(bio.get());
}

std::string entry_of(X509* certificate, int nid) {
  char text[256] = {};
  X509_NAME* subject = X509_get_subject_name(certificate);
  const int length = X509_NAME_get_text_by_NID(subject, nid, text, sizeof(text));
  if (length <= 0) return {};
  std::string entry(text, static_cast<std::size_t>(length));
  for (char& c : entry) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return entry;
}

std::string subject_text(X509* certificate) {
  const std::string role = entry_of(certificate, NID_organizationalUnitName);
  const std::string name = entry_of(certificate, NID_commonName);
  if (name.empty()) return "without a name";
  return (role.empty() ? "" : role + " ") + "'" + name + "'";
}

CertificateLife life_of(X509* certificate, X509* issuer) {
  return {
      unix_time(X509_get0_notBefore(certificate)),
      std::min(unix_time(X509_get0_notAfter(certificate)), unix_time(X509_get0_notAfter(issuer)))};
}

std::string last_day_text(X509* certificate) {
  std::tm time{};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &time) != 1) return "unknown";
  char text[sizeof("2027-11-22")] = {};
  std::strftime(text, sizeof(text), "%Y-%m-%d", &time);
  return text;
}

std::string serial_text(const ASN1_INTEGER* serial) {
  BIGNUM* number = ASN1_INTEGER_to_BN(serial, nullptr);
  char* digits = BN_bn2hex(number);
  std::string text = digits;
  OPENSSL_free(digits);
  BN_free(number);
  return text;
}

std::string serial_text(X509* certificate) {
  return serial_text(X509_get0_serialNumber(certificate));
}

bool is_revoked(X509_CRL* list, const std::string& serial) {
  if (list == nullptr) return false;
  const STACK_OF(X509_REVOKED)* const entries = X509_CRL_get_REVOKED(list);
  for (int i = 0; i < sk_X509_REVOKED_num(entries); ++i) {
    const X509_REVOKED* const entry = sk_X509_REVOKED_value(entries, i);
    if (serial_text(X509_REVOKED_get0_serialNumber(entry)) == serial) return true;
  }
  return false;
}

std::int64_t number_of(X509_CRL* list) {
  if (list == nullptr) return 0;
  auto* const number =
      static_cast<ASN1_INTEGER*>(X509_CRL_get_ext_d2i(list, NID_crl_number, nullptr, nullptr));
  std::int64_t value = 0;
  if (number != nullptr) ASN1_INTEGER_get_int64(&value, number);
  ASN1_INTEGER_free(number);
  return value;
}

}  // namespace tessera::net
