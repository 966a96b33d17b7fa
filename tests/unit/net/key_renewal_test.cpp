// SPDX-License-Identifier: Apache-2.0
// When a node asks for a new certificate, and what becomes of the answer.
#include "common/net/key_renewal.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/base/log.h"
#include "common/net/key_store.h"
#include "tests/support/temp_folder.h"

namespace tessera::net {
namespace {

class Renewal : public ::testing::Test {
 protected:
  Renewal() : keys_(folder_ / "keys") {}
  void SetUp() override { ASSERT_TRUE(init_key_store(keys_).is_ok()); }
  // Credentials of an application whose certificate is so many days old.
  std::shared_ptr<TlsContext> app(const std::string& name, int age_days) {
    EXPECT_TRUE(add_key(keys_, "app", name, kNodeDays, -age_days).is_ok());
    auto tls = TlsContext::load(keys_ + "/" + name, "app");
    EXPECT_TRUE(tls.is_ok()) << tls.status().message();
    return *tls;
  }
  std::string key_of(const std::string& name) const {
    std::ifstream in(keys_ + "/" + name + "/node.key");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  const test::TempFolder folder_;
  const std::string keys_;
};

TEST_F(Renewal, IsAskedForInTheLastThirdOnceAnHour) {
  EXPECT_FALSE(KeyRenewal(app("young", 0)).request());
  KeyRenewal old(app("old", 300));
  EXPECT_TRUE(old.request());
  EXPECT_FALSE(old.request());
}

TEST_F(Renewal, PutsTheCertificateIntoTheFolder) {
  KeyRenewal renewal(app("old", 300));
  const std::string key = key_of("old");
  const auto request = renewal.request();
  ASSERT_TRUE(request);
  const auto certificate = certify_key(keys_, "app", "old", *request, kNodeDays);
  ASSERT_TRUE(certificate.is_ok()) << certificate.status().message();
  renewal.granted(*certificate, "");
  EXPECT_NE(key_of("old"), key);
  const auto tls = TlsContext::load(keys_ + "/old", "app");
  ASSERT_TRUE(tls.is_ok()) << tls.status().message();
  EXPECT_FALSE(KeyRenewal(*tls).request()) << "it is new";
}

TEST_F(Renewal, KeepsWhatIsThereWhenTheAnswerIsNone) {
  KeyRenewal renewal(app("old", 300));
  const std::string key = key_of("old");
  renewal.granted(std::vector<std::byte>(9), "");
  ASSERT_TRUE(renewal.request());
  renewal.granted({}, "not now");
  EXPECT_EQ(key_of("old"), key);
}

TEST_F(Renewal, IsNotAskedForWhereItsFolderCannotBeWritten) {
  KeyRenewal renewal(app("gone", 300));
  std::filesystem::remove_all(keys_ + "/gone");
  EXPECT_FALSE(renewal.request()) << "the certificate would be made in vain";
  const LogMemory log = log_memory();
  ASSERT_FALSE(log.events.empty());
  EXPECT_NE(log.events.back().line.find("cannot be written"), std::string::npos);
}

}  // namespace
}  // namespace tessera::net
