// SPDX-License-Identifier: Apache-2.0
// Certificates, keys and revocation lists of OpenSSL: owning pointers, reading, and their contents.
// For common/net alone: no header outside this folder includes it, so that OpenSSL stays here.
//
// Threads. Any; nothing is shared.
#pragma once

#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/net/certificate_life.h"

namespace tessera::net {

struct OpenSslFree {
  void operator()(EVP_PKEY* p) const { EVP_PKEY_free(p); }
  void operator()(X509* p) const { X509_free(p); }
  void operator()(X509_REQ* p) const { X509_REQ_free(p); }
  void operator()(X509_CRL* p) const { X509_CRL_free(p); }
  void operator()(BIO* p) const { BIO_free(p); }
};
using PrivateKey = std::unique_ptr<EVP_PKEY, OpenSslFree>;
using Certificate = std::unique_ptr<X509, OpenSslFree>;
using CertificateRequest = std::unique_ptr<X509_REQ, OpenSslFree>;
using RevocationList = std::unique_ptr<X509_CRL, OpenSslFree>;
using Bio = std::unique_ptr<BIO, OpenSslFree>;

// Returns: null where the file is not there or is something else.
Certificate read_certificate(const std::string& path);
PrivateKey read_private_key(const std::string& path);
RevocationList read_revocation_list(const std::string& path);

// From bytes that a peer sent. Returns: null for what is none, or is followed by more.
Certificate certificate_of(std::span<const std::byte> der);
CertificateRequest request_of(std::span<const std::byte> der);
std::vector<std::byte> der_of(X509* certificate);
std::vector<std::byte> der_of(X509_REQ* request);

std::string pem_of(EVP_PKEY* key);
std::string pem_of(X509* certificate);
std::string pem_of(X509_CRL* list);

// One entry of the subject, such as NID_commonName: at most 255 bytes, what is not printable ASCII
// replaced by '?'. A peer may have written it.
std::string entry_of(X509* certificate, int nid);
// "slave 'a'", or "without a name".
std::string subject_text(X509* certificate);
// The last day of the certificate's life, in UTC: "2027-11-22"; "unknown" where what it says is no
// time.
std::string last_day_text(X509* certificate);
// The life of a certificate, which ends with its issuer's at the latest.
CertificateLife life_of(X509* certificate, X509* issuer);
// The serial number in hexadecimal digits, as in a certificate's dump.
std::string serial_text(const ASN1_INTEGER* serial);
std::string serial_text(X509* certificate);

// Whether the certificate with this serial number is revoked. `list` null: none is.
bool is_revoked(X509_CRL* list, const std::string& serial);
// Number of the list, which rises with every list that a CA makes; 0 for null.
std::int64_t number_of(X509_CRL* list);

}  // namespace tessera::net
