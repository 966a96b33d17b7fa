#include "common/net/key_store.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include "common/base/check.h"
#include "common/base/limits.h"

namespace tessera::net {
namespace {

struct Free {
  void operator()(EVP_PKEY* p) const { EVP_PKEY_free(p); }
  void operator()(X509* p) const { X509_free(p); }
  void operator()(BIO* p) const { BIO_free(p); }
};
using Key = std::unique_ptr<EVP_PKEY, Free>;
using Certificate = std::unique_ptr<X509, Free>;
using Bio = std::unique_ptr<BIO, Free>;

constexpr long kSecondsPerDay = 86400;

Status write_new_file(const std::string& path, const std::string& text, mode_t mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (file < 0)
    return Status::permission_denied("cannot write " + path + ": " + std::strerror(errno));
  const bool is_written =
      ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  ::close(file);
  if (is_written) return Status::ok();
  ::unlink(path.c_str());
  return Status::resource_exhausted("cannot write " + path + ": " + std::strerror(error));
}

std::string text_of(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return std::string(data, static_cast<std::size_t>(size));
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

Certificate new_certificate(EVP_PKEY* key, int days) {
  Certificate certificate(X509_new());
  X509_set_version(certificate.get(), 2);
  unsigned char serial[16];
  TESSERA_CHECK_EQ(RAND_bytes(serial, sizeof(serial)), 1);
  serial[0] &= 0x7f;
  BIGNUM* number = BN_bin2bn(serial, sizeof(serial), nullptr);
  BN_to_ASN1_INTEGER(number, X509_get_serialNumber(certificate.get()));
  BN_free(number);
  // A minute back, for clocks that disagree a little.
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()),
                  days < 0 ? (days - 1L) * kSecondsPerDay : -60);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), days * kSecondsPerDay);
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

bool is_good_name(const std::string& name) {
  return !name.empty() && name.size() <= kNameBytesMax && name != "." && name != ".." &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '.' || c == '_' || c == '-';
         });
}

Bio open_bio(const std::string& path) { return Bio(BIO_new_file(path.c_str(), "r")); }

}  // namespace

Status init_key_store(const std::string& folder) {
  std::error_code error;
  if (std::filesystem::exists(folder + "/ca.key", error)) {
    return Status::invalid_argument(
        folder + " has a CA already; add nodes with 'tessera-keys add " + folder + " ROLE NAME'");
  }
  std::filesystem::create_directories(folder, error);
  if (error)
    return Status::permission_denied("cannot make folder " + folder + ": " + error.message());
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate = new_certificate(key.get(), kCaDays);
  X509_NAME* name = X509_get_subject_name(certificate.get());
  add_entry(name, "O", "Tessera cluster " + random_hex());
  add_entry(name, "CN", "Tessera CA");
  X509_set_issuer_name(certificate.get(), name);
  add_extension(certificate.get(), certificate.get(), NID_basic_constraints,
                "critical,CA:TRUE,pathlen:0");
  add_extension(certificate.get(), certificate.get(), NID_key_usage,
                "critical,keyCertSign,cRLSign");
  add_extension(certificate.get(), certificate.get(), NID_subject_key_identifier, "hash");
  X509_sign(certificate.get(), key.get(), EVP_sha256());
  TESSERA_RETURN_IF_ERROR(write_new_file(folder + "/ca.key", pem_of(key.get()), 0600));
  return write_new_file(folder + "/ca.crt", pem_of(certificate.get()), 0644);
}

Status add_key(const std::string& folder, const std::string& role, const std::string& name,
               int days) {
  if (role != "master" && role != "slave" && role != "app") {
    return Status::invalid_argument("role '" + role + "': give master, slave or app");
  }
  if (!is_good_name(name)) {
    return Status::invalid_argument("name '" + name +
                                    "': give 1 to 64 of the characters A-Z a-z 0-9 . _ -");
  }
  const Bio ca_bio = open_bio(folder + "/ca.crt");
  const Bio key_bio = open_bio(folder + "/ca.key");
  const Certificate ca(ca_bio ? PEM_read_bio_X509(ca_bio.get(), nullptr, nullptr, nullptr)
                              : nullptr);
  const Key ca_key(key_bio ? PEM_read_bio_PrivateKey(key_bio.get(), nullptr, nullptr, nullptr)
                           : nullptr);
  if (!ca || !ca_key)
    return Status::not_found(folder + " has no CA; make one with 'tessera-keys init " + folder +
                             "'");
  const std::string node = folder + "/" + name;
  if (::mkdir(node.c_str(), 0700) != 0) {
    if (errno == EEXIST)
      return Status::invalid_argument("name '" + name + "' is used already: " + node + " exists");
    return Status::permission_denied("cannot make folder " + node + ": " + std::strerror(errno));
  }
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate = new_certificate(key.get(), days);
  X509_NAME* subject = X509_get_subject_name(certificate.get());
  add_entry(subject, "OU", role);
  add_entry(subject, "CN", name);
  X509_set_issuer_name(certificate.get(), X509_get_subject_name(ca.get()));
  add_extension(certificate.get(), ca.get(), NID_basic_constraints, "critical,CA:FALSE");
  add_extension(certificate.get(), ca.get(), NID_key_usage, "critical,digitalSignature");
  add_extension(certificate.get(), ca.get(), NID_ext_key_usage, "serverAuth,clientAuth");
  add_extension(certificate.get(), ca.get(), NID_authority_key_identifier, "keyid");
  X509_sign(certificate.get(), ca_key.get(), EVP_sha256());
  TESSERA_RETURN_IF_ERROR(write_new_file(node + "/node.key", pem_of(key.get()), 0600));
  TESSERA_RETURN_IF_ERROR(write_new_file(node + "/node.crt", pem_of(certificate.get()), 0644));
  return write_new_file(node + "/ca.crt", pem_of(ca.get()), 0644);
}

}  // namespace tessera::net
