// SPDX-License-Identifier: Apache-2.0
#include "common/net/key_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>
#include <vector>

#include "common/base/limits.h"
#include "common/base/local_name.h"
#include "common/net/cluster_authority.h"
#include "common/net/file_write.h"
#include "common/net/key_folder.h"

namespace tessera::net {
namespace {

constexpr mode_t kPrivate = 0600, kPublic = 0644;
constexpr std::size_t kSerialDigitsMax = 40;  // 20 bytes: RFC 5280, section 4.1.2.2

// Holds DIR for one change at a time.
class FolderLock {
 public:
  explicit FolderLock(const std::string& folder)
      : directory_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (directory_ >= 0) ::flock(directory_, LOCK_EX);
  }
  ~FolderLock() {
    if (directory_ >= 0) ::close(directory_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  const int directory_;
};

bool is_good_name(const std::string& name) {
  return !name.empty() && name.size() <= kNameBytesMax && name != "." && name != ".." &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '.' || c == '_' || c == '-';
         });
}

Status check_name(const std::string& name) {
  if (is_good_name(name)) return Status::ok();
  return Status::invalid_argument("name '" + name +
                                  "': give 1 to 64 of the characters A-Z a-z 0-9 . _ -");
}

bool exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

Status write_to_ledger(const std::string& folder, const NodeIdentity& node, X509* certificate) {
  return append_line(folder + "/issued.txt",
                     serial_text(certificate) + " " + node.role + " " + node.name, kPublic);
}

bool is_serial(const std::string& text) {
  return !text.empty() && text.size() <= kSerialDigitsMax &&
         text.find_first_not_of("0123456789abcdefABCDEF") == text.npos;
}

// Serial numbers of all certificates ever made for this name. A certificate from before there was a
// ledger is found in the node's folder. A line that is damaged must not be taken for none: a
// certificate would stay good.
Result<std::vector<std::string>> serials_of(const std::string& folder, const std::string& name) {
  std::vector<std::string> serials;
  std::ifstream ledger(folder + "/issued.txt");
  for (NodeIdentity node; true;) {
    std::string serial;
    if (!(ledger >> serial >> node.role >> node.name)) break;
    if (node.name != name) continue;
    if (!is_serial(serial)) {
      return Status::permission_denied(folder + "/issued.txt is damaged: a line of '" + name +
                                       "' begins with no serial number; take it from a backup");
    }
    serials.push_back(serial);
  }
  if (const Certificate last = read_certificate(folder + "/" + name + "/node.crt")) {
    const std::string serial = serial_text(last.get());
    if (std::find(serials.begin(), serials.end(), serial) == serials.end())
      serials.push_back(serial);
  }
  return serials;
}

bool is_p256(const EVP_PKEY* key) {
  char group[32] = {};
  return EVP_PKEY_is_a(key, "EC") == 1 &&
         EVP_PKEY_get_group_name(key, group, sizeof(group), nullptr) == 1 &&
         std::string(group) == "prime256v1";
}

// The newest certificate of a node that is known in DIR.
Certificate newest_certificate(const std::string& node) {
  Certificate made = read_certificate(node + "/node.crt");
  Certificate renewed = read_certificate(node + "/renewed.crt");
  if (!made || !renewed) return made;
  return ASN1_TIME_compare(X509_get0_notBefore(renewed.get()), X509_get0_notBefore(made.get())) > 0
             ? std::move(renewed)
             : std::move(made);
}

// A crl.pem that is damaged must not be taken for "nobody is revoked".
Result<RevocationList> read_list(const std::string& folder, const ClusterAuthority& authority) {
  const std::string path = folder + "/crl.pem";
  if (!exists(path)) return RevocationList();
  RevocationList list = read_revocation_list(path);
  if (list && X509_CRL_verify(list.get(), X509_get0_pubkey(authority.certificate())) == 1)
    return list;
  return Status::permission_denied(path +
                                   " is damaged; take it from a backup or from the folder of a "
                                   "node, whichever is the newest");
}

// Copies the cluster's list, where there is one, into a node's folder.
Status copy_list(const std::string& folder, const std::string& node, const RevocationList& list) {
  if (!list) return Status::ok();
  return replace_file(folder + "/" + node + "/crl.pem", pem_of(list.get()), kPublic);
}

KeyState state_of(X509* certificate, X509* ca, X509_CRL* revoked) {
  const CertificateLife life = life_of(certificate, ca);
  const std::int64_t now_s = std::time(nullptr);
  if (is_revoked(revoked, serial_text(certificate))) return KeyState::kRevoked;
  if (now_s >= life.end_s) return KeyState::kEnded;
  if (now_s < life.begin_s) return KeyState::kNotYet;
  if (life.end_s - now_s <= ExpiryNotice::kAheadSeconds) return KeyState::kEndsInADay;
  return is_renewal_due(life, now_s) ? KeyState::kRenewalDue : KeyState::kGood;
}

// `node` null: of the CA.
KeyFacts facts_of(X509* node, const std::string& name, X509* ca, X509_CRL* revoked) {
  const std::string last = last_day_text(ca);
  if (node == nullptr) return {"", "", last, state_of(ca, ca, revoked)};
  return {entry_of(node, NID_organizationalUnitName), name, std::min(last, last_day_text(node)),
          state_of(node, ca, revoked)};
}

}  // namespace

Status init_key_store(const std::string& folder) {
  if (exists(folder + "/ca.key")) {
    return Status::invalid_argument(
        folder + " has a CA already; add nodes with 'tessera-keys add " + folder + " ROLE NAME'");
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Status::permission_denied("cannot make folder " + folder + ": " + error.message());
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
  const KeyPair ca = ClusterAuthority::make();
  TESSERA_RETURN_IF_ERROR(write_new_file(folder + "/ca.key", pem_of(ca.key.get()), kPrivate));
  return write_new_file(folder + "/ca.crt", pem_of(ca.certificate.get()), kPublic);
}

Status add_key(const std::string& folder, const std::string& role, const std::string& name,
               int days, int starts_in_days) {
  if (role != "master" && role != "slave" && role != "app") {
    return Status::invalid_argument("role '" + role + "': give master, slave or app");
  }
  TESSERA_RETURN_IF_ERROR(check_name(name));
  if (name.starts_with(kLocalNamePrefix)) {
    return Status::invalid_argument("name '" + name +
                                    "': a master calls the slaves inside its process so");
  }
  const FolderLock lock(folder);
  const auto authority = ClusterAuthority::open(folder);
  if (!authority.is_ok()) return authority.status();
  const auto revoked = read_list(folder, *authority);
  if (!revoked.is_ok()) return revoked.status();
  const std::string node = folder + "/" + name;
  if (::mkdir(node.c_str(), 0700) != 0) {
    if (errno == EEXIST) {
      return Status::invalid_argument("name '" + name + "' is used already: " + node +
                                      " exists; a new certificate for it: 'tessera-keys renew " +
                                      folder + " " + name + "'");
    }
    return Status::permission_denied("cannot make folder " + node + ": " + std::strerror(errno));
  }
  const KeyPair pair = authority->issue({role, name}, {days, starts_in_days});
  TESSERA_RETURN_IF_ERROR(write_to_ledger(folder, {role, name}, pair.certificate.get()));
  TESSERA_RETURN_IF_ERROR(write_new_file(node + "/node.key", pem_of(pair.key.get()), kPrivate));
  TESSERA_RETURN_IF_ERROR(
      write_new_file(node + "/node.crt", pem_of(pair.certificate.get()), kPublic));
  TESSERA_RETURN_IF_ERROR(copy_list(folder, name, *revoked));
  return write_new_file(node + "/ca.crt", pem_of(authority->certificate()), kPublic);
}

Status renew_key(const std::string& folder, const std::string& name, int days) {
  TESSERA_RETURN_IF_ERROR(check_name(name));
  const FolderLock lock(folder);
  const auto authority = ClusterAuthority::open(folder);
  if (!authority.is_ok()) return authority.status();
  const auto revoked = read_list(folder, *authority);
  if (!revoked.is_ok()) return revoked.status();
  const std::string node = folder + "/" + name;
  const Certificate old = read_certificate(node + "/node.crt");
  if (!old) {
    return Status::not_found(node +
                             " has no node.crt to renew; make a node with 'tessera-keys add " +
                             folder + " ROLE " + name + "'");
  }
  const NodeIdentity identity{entry_of(old.get(), NID_organizationalUnitName), name};
  const KeyPair pair = authority->issue(identity, {days, 0});
  TESSERA_RETURN_IF_ERROR(write_to_ledger(folder, identity, pair.certificate.get()));
  TESSERA_RETURN_IF_ERROR(copy_list(folder, name, *revoked));
  // Nothing but two renames lies between the old pair and the new one. A reader in between finds
  // that key and certificate do not fit, and reads again.
  auto key = Replacement::write(node + "/node.key", pem_of(pair.key.get()), kPrivate);
  if (!key.is_ok()) return key.status();
  auto certificate =
      Replacement::write(node + "/node.crt", pem_of(pair.certificate.get()), kPublic);
  if (!certificate.is_ok()) return certificate.status();
  TESSERA_RETURN_IF_ERROR(key->commit());
  return certificate->commit();
}

Status check_issuing_folder(const std::string& folder, const std::string& node_folder) {
  const auto authority = ClusterAuthority::open(folder);
  if (!authority.is_ok()) return authority.status();
  const Certificate ca = read_certificate(node_folder + "/ca.crt");
  if (ca && X509_cmp(ca.get(), authority->certificate()) == 0) return Status::ok();
  return Status::permission_denied(folder + " is the authority of another cluster than that of " +
                                   node_folder);
}

Result<std::vector<std::byte>> certify_key(const std::string& folder, const std::string& role,
                                           const std::string& name,
                                           std::span<const std::byte> request, int days) {
  TESSERA_RETURN_IF_ERROR(check_name(name));
  const CertificateRequest asked = request_of(request);
  EVP_PKEY* const key = asked ? X509_REQ_get0_pubkey(asked.get()) : nullptr;
  if (key == nullptr || !is_p256(key) || X509_REQ_verify(asked.get(), key) != 1) {
    return Status::invalid_argument(
        "'" + name + "' asked for a certificate without showing a P-256 key of its own");
  }
  const FolderLock lock(folder);
  const auto authority = ClusterAuthority::open(folder);
  if (!authority.is_ok()) return authority.status();
  const Certificate made = authority->certify(key, {role, name}, {days, 0});
  TESSERA_RETURN_IF_ERROR(write_to_ledger(folder, {role, name}, made.get()));
  if (exists(folder + "/" + name)) {
    TESSERA_RETURN_IF_ERROR(
        replace_file(folder + "/" + name + "/renewed.crt", pem_of(made.get()), kPublic));
  }
  return der_of(made.get());
}

Status revoke_key(const std::string& folder, const std::string& name) {
  TESSERA_RETURN_IF_ERROR(check_name(name));
  const FolderLock lock(folder);
  const auto authority = ClusterAuthority::open(folder);
  if (!authority.is_ok()) return authority.status();
  auto list = read_list(folder, *authority);
  if (!list.is_ok()) return list.status();
  auto found = serials_of(folder, name);
  if (!found.is_ok()) return found.status();
  std::vector<std::string> serials = std::move(*found);
  if (serials.empty()) {
    return Status::not_found("no certificate was ever made for '" + name + "' in " + folder +
                             "; its names are in " + folder + "/issued.txt");
  }
  std::erase_if(serials, [&](const std::string& s) { return is_revoked(list->get(), s); });
  if (!serials.empty()) *list = authority->revoke(list->get(), serials);
  TESSERA_RETURN_IF_ERROR(replace_file(folder + "/crl.pem", pem_of(list->get()), kPublic));
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (!exists(entry.path().string() + "/node.crt")) continue;
    TESSERA_RETURN_IF_ERROR(copy_list(folder, entry.path().filename().string(), *list));
  }
  return Status::ok();
}

Result<KeyFacts> read_key_facts(const std::string& folder, const std::string& name) {
  const Certificate ca = read_certificate(folder + "/ca.crt");
  const Certificate node =
      name.empty() ? nullptr : read_certificate(folder + "/" + name + "/node.crt");
  if (!ca || (!name.empty() && !node))
    return Status::not_found(folder + " has no certificate" + (name.empty() ? "" : " of " + name));
  return facts_of(node.get(), name, ca.get(), nullptr);
}

Result<std::vector<KeyFacts>> list_key_facts(const std::string& folder) {
  const Certificate ca = read_certificate(folder + "/ca.crt");
  if (!ca) {
    return Status::not_found(folder + " has no CA; make one with 'tessera-keys init " + folder +
                             "'");
  }
  const auto revoked = read_revocations(folder, ca.get());
  if (!revoked.is_ok()) return revoked.status();
  std::set<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    names.insert(entry.path().filename().string());
  std::vector<KeyFacts> all{facts_of(nullptr, "", ca.get(), nullptr)};
  for (const std::string& name : names) {
    if (const Certificate node = newest_certificate(folder + "/" + name))
      all.push_back(facts_of(node.get(), name, ca.get(), revoked->get()));
  }
  return all;
}

}  // namespace tessera::net
