// SPDX-License-Identifier: Apache-2.0
#include "common/net/key_store.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>

#include "common/net/key_request.h"
#include "common/net/tls.h"
#include "common/net/x509.h"
#include "tests/support/temp_folder.h"

namespace tessera::net {
namespace {

class KeyStore : public ::testing::Test {
 protected:
  KeyStore() : keys_(folder_ / "keys") {}
  void SetUp() override { ASSERT_TRUE(init_key_store(keys_).is_ok()); }
  const test::TempFolder folder_;
  const std::string keys_;
};

TEST_F(KeyStore, PrivateKeysAreTheOwnersAlone) {
  ASSERT_TRUE(add_key(keys_, "slave", "a", kNodeDays).is_ok());
  for (const char* name : {"/ca.key", "/a/node.key"}) {
    struct stat info {};
    ASSERT_EQ(stat((keys_ + name).c_str(), &info), 0) << name;
    EXPECT_EQ(info.st_mode & 0777, 0600u) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(keys_ + "/a/ca.key")) << "nodes cannot make nodes";
}

TEST_F(KeyStore, NothingIsOverwritten) {
  EXPECT_FALSE(init_key_store(keys_).is_ok());
  ASSERT_TRUE(add_key(keys_, "slave", "a", kNodeDays).is_ok());
  EXPECT_FALSE(add_key(keys_, "slave", "a", kNodeDays).is_ok());
}

TEST_F(KeyStore, RolesAndNamesAreChecked) {
  EXPECT_FALSE(add_key(keys_, "king", "a", kNodeDays).is_ok());
  for (const char* name : {"", ".", "..", "a/b", "a b", "ä"}) {
    EXPECT_FALSE(add_key(keys_, "slave", name, kNodeDays).is_ok()) << name;
  }
  EXPECT_FALSE(add_key(keys_, "slave", std::string(65, 'a'), kNodeDays).is_ok());
  EXPECT_FALSE(add_key(folder_ / "none", "slave", "a", kNodeDays).is_ok());
}

TEST_F(KeyStore, LoadRefusesWhatIsNotFitToUse) {
  ASSERT_TRUE(add_key(keys_, "slave", "good", kNodeDays).is_ok());
  auto good = TlsContext::load(keys_ + "/good", "slave");
  ASSERT_TRUE(good.is_ok()) << good.status().message();
  EXPECT_EQ((*good)->name(), "good");
  const auto refused = [&](const std::string& folder, const std::string& role, const char* word) {
    auto context = TlsContext::load(folder, role);
    ASSERT_FALSE(context.is_ok()) << word;
    EXPECT_NE(context.status().message().find(word), std::string::npos)
        << context.status().message();
  };
  refused(keys_ + "/good", "master", "slave");
  refused(keys_ + "/gone", "slave", "tessera-keys");
  ASSERT_TRUE(add_key(keys_, "slave", "old", -1).is_ok());
  refused(keys_ + "/old", "slave", "expired");
  ASSERT_TRUE(add_key(keys_, "slave", "loose", kNodeDays).is_ok());
  std::filesystem::permissions(keys_ + "/loose/node.key", std::filesystem::perms::others_read,
                               std::filesystem::perm_options::add);
  refused(keys_ + "/loose", "slave", "chmod");
  const std::string other = folder_ / "other";
  ASSERT_TRUE(init_key_store(other).is_ok());
  ASSERT_TRUE(add_key(other, "slave", "x", kNodeDays).is_ok());
  std::filesystem::copy_file(other + "/ca.crt", keys_ + "/good/ca.crt",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_FALSE(TlsContext::load(keys_ + "/good", "slave").is_ok()) << "signed by another CA";
  std::filesystem::copy_file(keys_ + "/old/node.key", other + "/x/node.key",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_FALSE(TlsContext::load(other + "/x", "slave").is_ok()) << "the key of another certificate";
}

TEST_F(KeyStore, AFolderThatOthersMayWriteIsRefused) {
  namespace fs = std::filesystem;
  using fs::perms;
  ASSERT_TRUE(add_key(keys_, "slave", "a", kNodeDays).is_ok());
  const std::string outer = folder_ / "outer", node = outer + "/inner/a";
  fs::create_directories(outer + "/inner");
  fs::copy(keys_ + "/a", node);
  fs::permissions(node, perms::owner_all);
  const auto status_of = [&] { return TlsContext::load(node, "slave").status(); };
  ASSERT_TRUE(status_of().is_ok()) << status_of().message();
  for (const perms open : {perms::group_write, perms::others_write}) {
    constexpr gid_t kForeignGroup =
        1;  // only root can give a folder to a group that is not its own
    if (open == perms::group_write && geteuid() != 0) continue;
    for (const std::string& folder : {node, outer + "/inner", outer}) {
      if (open == perms::group_write) {
        ASSERT_EQ(chown(folder.c_str(), geteuid(), kForeignGroup), 0);
      }
      fs::permissions(folder, open, fs::perm_options::add);
      EXPECT_NE(status_of().message().find("chmod go-w " + folder), std::string::npos)
          << folder << ": " << status_of().message();
      fs::permissions(folder, open, fs::perm_options::remove);
    }
  }
  fs::permissions(outer, perms::all | perms::sticky_bit);
  EXPECT_TRUE(status_of().is_ok()) << "as /tmp is";
  fs::permissions(keys_, perms::all);
  EXPECT_EQ(add_key(keys_, "slave", "b", kNodeDays).code(), StatusCode::kPermissionDenied);
}

TEST_F(KeyStore, NamesOfSlavesInsideAMasterAreNoCertificates) {
  EXPECT_EQ(add_key(keys_, "slave", "local-1", kNodeDays).code(), StatusCode::kInvalidArgument);
}

// Puts a certificate with this key, signed by the CA, in the place of a node's own.
void replace_key(const std::string& keys, const std::string& node, EVP_PKEY* key) {
  const Certificate certificate = read_certificate(node + "/node.crt");
  const PrivateKey authority = read_private_key(keys + "/ca.key");
  ASSERT_EQ(X509_set_pubkey(certificate.get(), key), 1);
  ASSERT_GT(X509_sign(certificate.get(), authority.get(), EVP_sha256()), 0);
  std::ofstream(node + "/node.crt") << pem_of(certificate.get());
  std::ofstream(node + "/node.key") << pem_of(key);
}

TEST_F(KeyStore, AKeyThatOpenSslFindsTooShortIsRefusedWithALine) {
  ASSERT_TRUE(add_key(keys_, "slave", "a", kNodeDays).is_ok());
  const std::string node = keys_ + "/a";
  const auto running = TlsContext::load(node, "slave");
  ASSERT_TRUE(running.is_ok()) << running.status().message();
  const std::string before = (*running)->certificate_text();
  const PrivateKey shorter(EVP_RSA_gen(512));
  ASSERT_TRUE(shorter);
  replace_key(keys_, node, shorter.get());
  const auto context = TlsContext::load(node, "slave");
  ASSERT_FALSE(context.is_ok());
  EXPECT_NE(context.status().message().find("node.crt"), std::string::npos)
      << context.status().message();
  EXPECT_EQ((*running)->reload().status().message(), context.status().message());
  EXPECT_EQ((*running)->certificate_text(), before) << "what is in use stays in use";
}

TEST_F(KeyStore, ALifeThatIsNoTimeHasNoLastDay) {
  const Certificate certificate = read_certificate(keys_ + "/ca.crt");
  ASN1_TIME* const end = X509_getm_notAfter(certificate.get());
  ASSERT_EQ(ASN1_STRING_set(end, "no time", 7), 1);
  EXPECT_EQ(last_day_text(certificate.get()), "unknown");
  EXPECT_EQ(life_of(certificate.get(), certificate.get()).end_s, 0);
}

TEST_F(KeyStore, OneThatIsNotValidYetIsRefused) {
  ASSERT_TRUE(add_key(keys_, "slave", "early", kNodeDays, 2).is_ok());
  auto context = TlsContext::load(keys_ + "/early", "slave");
  ASSERT_FALSE(context.is_ok());
  EXPECT_NE(context.status().message().find("not valid yet"), std::string::npos);
}

TEST_F(KeyStore, RenewingChangesKeyAndCertificateAndNothingElse) {
  ASSERT_TRUE(add_key(keys_, "master", "m", -1).is_ok());
  ASSERT_FALSE(TlsContext::load(keys_ + "/m", "master").is_ok()) << "expired";
  const Status renewed = renew_key(keys_, "m", kNodeDays);
  ASSERT_TRUE(renewed.is_ok()) << renewed.message();
  auto context = TlsContext::load(keys_ + "/m", "master");
  ASSERT_TRUE(context.is_ok()) << context.status().message();
  EXPECT_EQ((*context)->name(), "m");
  struct stat info {};
  ASSERT_EQ(stat((keys_ + "/m/node.key").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  EXPECT_FALSE(std::filesystem::exists(keys_ + "/m/node.key.new"));
  EXPECT_EQ(renew_key(keys_, "nobody", kNodeDays).code(), StatusCode::kNotFound);
  EXPECT_EQ(renew_key(keys_, "../m", kNodeDays).code(), StatusCode::kInvalidArgument);
}

TEST_F(KeyStore, RevokingANameRevokesAllThatWasEverMadeForItAndNothingElse) {
  ASSERT_TRUE(add_key(keys_, "slave", "a", kNodeDays).is_ok());
  ASSERT_TRUE(add_key(keys_, "slave", "b", kNodeDays).is_ok());
  const std::string stolen = folder_ / "stolen";
  std::filesystem::copy(keys_ + "/a", stolen);
  ASSERT_TRUE(renew_key(keys_, "a", kNodeDays).is_ok());
  for (int i = 0; i < 2; ++i) {  // revoking again is no error
    const Status revoked = revoke_key(keys_, "a");
    ASSERT_TRUE(revoked.is_ok()) << revoked.message();
  }
  std::filesystem::copy(keys_ + "/crl.pem", stolen + "/crl.pem");
  for (const std::string& folder : {keys_ + "/a", stolen}) {
    auto context = TlsContext::load(folder, "slave");
    ASSERT_FALSE(context.is_ok()) << folder;
    EXPECT_NE(context.status().message().find("revoked"), std::string::npos);
  }
  EXPECT_TRUE(TlsContext::load(keys_ + "/b", "slave").is_ok());
  EXPECT_TRUE(std::filesystem::exists(keys_ + "/b/crl.pem")) << "every node is told";
  ASSERT_TRUE(renew_key(keys_, "a", kNodeDays).is_ok());
  EXPECT_TRUE(TlsContext::load(keys_ + "/a", "slave").is_ok()) << "a new one for the same name";
  ASSERT_TRUE(add_key(keys_, "slave", "c", kNodeDays).is_ok());
  EXPECT_TRUE(std::filesystem::exists(keys_ + "/c/crl.pem")) << "and who comes later, too";
  EXPECT_EQ(revoke_key(keys_, "nobody").code(), StatusCode::kNotFound);
}

TEST_F(KeyStore, ANodeRenewsItsCertificateWithoutSendingItsKey) {
  ASSERT_TRUE(add_key(keys_, "slave", "a", kNodeDays, -300).is_ok());
  const std::string node = folder_ / "node";  // the node's own copy
  std::filesystem::copy(keys_ + "/a", node);
  const auto context = TlsContext::load(node, "slave");
  ASSERT_TRUE(context.is_ok()) << context.status().message();
  EXPECT_TRUE(is_renewal_due((*context)->life(), std::time(nullptr)));
  const KeyRequest request;
  const auto made = certify_key(keys_, "slave", "a", request.der(), kNodeDays);
  ASSERT_TRUE(made.is_ok()) << made.status().message();
  const Status taken = request.take_over(node, *made);
  ASSERT_TRUE(taken.is_ok()) << taken.message();
  ASSERT_TRUE((*context)->reload().is_ok());
  EXPECT_FALSE(is_renewal_due((*context)->life(), std::time(nullptr)));
  struct stat info {};
  ASSERT_EQ(stat((node + "/node.key").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  const auto listed = list_key_facts(keys_);
  ASSERT_TRUE(listed.is_ok());
  EXPECT_EQ(listed->back().state, KeyState::kGood) << "the owner sees that it was renewed";
  ASSERT_TRUE(revoke_key(keys_, "a").is_ok());
  std::filesystem::copy(keys_ + "/crl.pem", node + "/crl.pem");
  EXPECT_FALSE(TlsContext::load(node, "slave").is_ok()) << "revoked with all that was ever made";
}

TEST_F(KeyStore, WhatDoesNotFitIsNeitherCertifiedNorTakenOver) {
  for (const char* name : {"a", "b"}) ASSERT_TRUE(add_key(keys_, "slave", name, kNodeDays).is_ok());
  const KeyRequest request, other;
  std::vector<std::byte> altered = request.der();
  altered.back() ^= std::byte{1};  // of the signature
  std::vector<std::byte> longer = request.der();
  longer.push_back(std::byte{0});
  for (const auto& bad : {altered, longer, std::vector<std::byte>(100)})
    EXPECT_FALSE(certify_key(keys_, "slave", "a", bad, kNodeDays).is_ok());
  const auto before = TlsContext::load(keys_ + "/a", "slave");
  const auto take = [&](const std::string& role, const std::string& name, const KeyRequest& of) {
    const auto made = certify_key(keys_, role, name, of.der(), kNodeDays);
    return made.is_ok() ? request.take_over(keys_ + "/a", *made) : made.status();
  };
  EXPECT_FALSE(take("slave", "a", other).is_ok()) << "of another key";
  EXPECT_FALSE(take("slave", "b", request).is_ok()) << "of another name";
  EXPECT_FALSE(take("master", "a", request).is_ok()) << "of another role";
  EXPECT_FALSE(request.take_over(keys_ + "/a", std::vector<std::byte>(100)).is_ok());
  EXPECT_FALSE(*(*before)->reload()) << "the folder is as it was";
  EXPECT_TRUE(take("slave", "a", request).is_ok());
  EXPECT_TRUE(*(*before)->reload());
}

TEST_F(KeyStore, ADamagedListIsNeverTakenForAnEmptyOne) {
  ASSERT_TRUE(add_key(keys_, "slave", "a", kNodeDays).is_ok());
  ASSERT_TRUE(add_key(keys_, "slave", "b", kNodeDays).is_ok());
  folder_.write("keys/crl.pem", "-----BEGIN X509 CRL-----\nAAAA\n-----END X509 CRL-----\n");
  EXPECT_FALSE(revoke_key(keys_, "b").is_ok());
  EXPECT_FALSE(add_key(keys_, "slave", "c", kNodeDays).is_ok());
  folder_.write("keys/a/crl.pem", "nothing");
  EXPECT_FALSE(TlsContext::load(keys_ + "/a", "slave").is_ok());
}

TEST_F(KeyStore, ADamagedLedgerIsNeverTakenForAShorterOne) {
  ASSERT_TRUE(add_key(keys_, "slave", "a", kNodeDays).is_ok());
  ASSERT_TRUE(add_key(keys_, "slave", "b", kNodeDays).is_ok());
  for (const std::string& serial :
       {std::string("no-number"), std::string("12xy"), std::string(41, 'A')}) {
    folder_.write("keys/issued.txt", serial + " slave a\n");
    const Status status = revoke_key(keys_, "a");
    EXPECT_EQ(status.code(), StatusCode::kPermissionDenied) << serial;
    EXPECT_NE(status.message().find("issued.txt"), std::string::npos) << status.message();
    EXPECT_TRUE(revoke_key(keys_, "b").is_ok()) << "the lines of others do not matter";
  }
}

}  // namespace
}  // namespace tessera::net
