#include "common/net/key_store.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "common/net/tls.h"
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

}  // namespace
}  // namespace tessera::net
