// SPDX-License-Identifier: Apache-2.0
#include "common/net/key_folder.h"

#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>

#include <filesystem>
#include <utility>

namespace tessera::net {
namespace {

// Whether the group is the user's own and nobody else's, which is how Debian makes users: there
// folders may be writable by the group, as umask 002 leaves them.
bool is_private_group(uid_t user, gid_t group) {
  char user_text[4096], group_text[4096];
  passwd person{};
  passwd* found_person = nullptr;
  ::group members{};
  ::group* found_group = nullptr;
  if (getpwuid_r(user, &person, user_text, sizeof(user_text), &found_person) != 0 ||
      getgrgid_r(group, &members, group_text, sizeof(group_text), &found_group) != 0 ||
      found_person == nullptr || found_group == nullptr)
    return false;
  return person.pw_gid == group && members.gr_mem[0] == nullptr;
}

bool is_open_to_others(const std::string& folder, bool is_innermost) {
  struct stat info {};
  if (stat(folder.c_str(), &info) != 0) return false;
  const bool is_open =
      (info.st_mode & S_IWOTH) != 0 ||
      ((info.st_mode & S_IWGRP) != 0 && !is_private_group(info.st_uid, info.st_gid));
  return is_open && (is_innermost || (info.st_mode & S_ISVTX) == 0);
}

Status check_files(const std::string& folder, const std::string& role) {
  const std::string mend =
      "; make it with 'tessera-keys init cluster' and 'tessera-keys add cluster " + role + " NAME'";
  struct stat info {};
  if (stat(folder.c_str(), &info) != 0 || !S_ISDIR(info.st_mode)) {
    return Status::not_found("keys folder " + folder + " does not exist" + mend);
  }
  TESSERA_RETURN_IF_ERROR(check_not_open_to_others(folder));
  for (const char* name : {"ca.crt", "node.crt", "node.key"}) {
    const std::string path = folder + "/" + name;
    if (stat(path.c_str(), &info) != 0)
      return Status::not_found("keys folder " + folder + " has no " + name + mend);
  }
  if ((info.st_mode & (S_IRWXG | S_IRWXO)) != 0) {  // of node.key, the last one looked at
    return Status::permission_denied(folder + "/node.key can be read by others; run 'chmod 600 " +
                                     folder + "/node.key'");
  }
  return Status::ok();
}

Status check_own(const std::string& folder, const std::string& role, const KeyFolder& found) {
  const auto denied = [&](const std::string& what) {
    return Status::permission_denied("the certificate in " + folder + " " + what);
  };
  const std::string renew = "; make a new one with 'tessera-keys renew cluster " + found.name + "'";
  const std::string own_role = entry_of(found.own.get(), NID_organizationalUnitName);
  if (own_role != role) {
    return denied("has role '" + own_role + "', but role '" + role +
                  "' is needed; use a folder made by 'tessera-keys add cluster " + role + " NAME'");
  }
  if (X509_verify(found.own.get(), X509_get0_pubkey(found.ca.get())) != 1)
    return denied("is not signed by the ca.crt beside it");
  const int end = X509_cmp_current_time(X509_get0_notAfter(found.own.get()));
  if (end == 0) return denied("does not say when it ends" + renew);
  if (end < 0) return denied("has expired" + renew);
  if (X509_cmp_current_time(X509_get0_notBefore(found.own.get())) > 0)
    return denied("is not valid yet; is this machine's clock right?");
  if (is_revoked(found.revoked.get(), serial_text(found.own.get())))
    return denied("has been revoked" + renew);
  return Status::ok();
}

}  // namespace

Result<KeyFolder> read_key_folder(const std::string& folder, const std::string& role) {
  TESSERA_RETURN_IF_ERROR(check_files(folder, role));
  KeyFolder found;
  found.key = read_private_key(folder + "/node.key");
  found.own = read_certificate(folder + "/node.crt");
  found.ca = read_certificate(folder + "/ca.crt");
  if (!found.own || !found.ca)
    return Status::permission_denied("keys folder " + folder +
                                     ": node.crt or ca.crt is not a certificate");
  if (!found.key)
    return Status::permission_denied("keys folder " + folder + ": node.key is not a private key");
  auto revoked = read_revocations(folder, found.ca.get());
  if (!revoked.is_ok()) return revoked.status();
  found.revoked = std::move(*revoked);
  found.name = entry_of(found.own.get(), NID_commonName);
  TESSERA_RETURN_IF_ERROR(check_own(folder, role, found));
  if (X509_check_private_key(found.own.get(), found.key.get()) != 1) {
    return Status::unavailable("keys folder " + folder +
                               ": node.key does not belong to node.crt; copy both again");
  }
  return found;
}

Status check_not_open_to_others(const std::string& folder) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::canonical(folder, error);
  if (error) return Status::ok();
  for (std::filesystem::path at = whole; !at.empty(); at = at.parent_path()) {
    if (is_open_to_others(at, at == whole)) {
      return Status::permission_denied("others may write the folder " + at.string() +
                                       ", and so change the keys in " + folder +
                                       "; run 'chmod go-w " + at.string() + "'");
    }
    if (at == at.root_path()) break;
  }
  return Status::ok();
}

Result<RevocationList> read_revocations(const std::string& folder, X509* ca) {
  const std::string path = folder + "/crl.pem";
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return RevocationList();
  RevocationList list = read_revocation_list(path);
  if (!list || X509_CRL_verify(list.get(), X509_get0_pubkey(ca)) != 1) {
    return Status::permission_denied(path +
                                     " is not a revocation list signed by the ca.crt beside it; "
                                     "copy crl.pem again from the folder that 'tessera-keys "
                                     "revoke' was given");
  }
  return list;
}

std::string stamp_of(const std::string& folder) {
  std::string stamp;
  for (const char* name : {"/ca.crt", "/crl.pem", "/node.crt", "/node.key"}) {
    struct stat info {};
    if (stat((folder + name).c_str(), &info) == 0) {
      for (const long long part :
           {static_cast<long long>(info.st_ino), static_cast<long long>(info.st_size),
            static_cast<long long>(info.st_mtim.tv_sec),
            static_cast<long long>(info.st_mtim.tv_nsec),
            static_cast<long long>(info.st_ctim.tv_sec),
            static_cast<long long>(info.st_ctim.tv_nsec)}) {
        stamp += std::to_string(part) + ' ';
      }
    }
    stamp += ';';
  }
  return stamp;
}

}  // namespace tessera::net
