// SPDX-License-Identifier: Apache-2.0
// Mutual TLS between a listener and a connecting peer, with good and wrong credentials.
#include "common/net/tls.h"
#include "common/net/connector.h"
#include "common/net/listener.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <future>
#include <thread>

#include "common/net/connection.h"
#include "common/net/credentials_watch.h"
#include "common/net/key_store.h"
#include "tests/support/net_peer.h"
#include "tests/support/temp_folder.h"

namespace tessera::net {
namespace {

class Tls : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* cluster : {"one", "two"}) {
      ASSERT_TRUE(init_key_store(folder_ / cluster).is_ok());
      for (const char* role : {"master", "slave", "app"}) {
        ASSERT_TRUE(add_key(folder_ / cluster, role, role, kNodeDays).is_ok());
      }
    }
  }
  void TearDown() override {
    io_.run_and_wait([this] {
      attempt_.reset();
      listener_.reset();
    });
  }

  std::shared_ptr<TlsContext> context(const std::string& cluster, const std::string& role) {
    auto loaded = TlsContext::load(folder_ / (cluster + "/" + role), role);
    EXPECT_TRUE(loaded.is_ok()) << loaded.status().message();
    return loaded.is_ok() ? *loaded : nullptr;
  }

  // The credentials of a node that has not heard of any revocation, its own included.
  std::shared_ptr<TlsContext> unaware(const std::string& cluster, const std::string& role) {
    const std::string copy = folder_ / ("copy-" + std::to_string(++copies_));
    std::filesystem::copy(folder_ / (cluster + "/" + role), copy);
    std::filesystem::remove(copy + "/crl.pem");
    auto loaded = TlsContext::load(copy, role);
    EXPECT_TRUE(loaded.is_ok()) << loaded.status().message();
    return loaded.is_ok() ? *loaded : nullptr;
  }

  void serve(std::shared_ptr<TlsContext> tls) {
    io_.run_and_wait([&] {
      auto listener = listen(io_, {"127.0.0.1", 0}, std::move(tls), [this](ConnectionPtr accepted) {
        accepted_.set_value(std::move(accepted));
      });
      ASSERT_TRUE(listener.is_ok());
      listener_ = std::move(*listener);
    });
  }

  Result<ConnectionPtr> dial(std::shared_ptr<TlsContext> tls) {
    auto promise = std::make_shared<std::promise<Result<ConnectionPtr>>>();
    io_.run_and_wait([&] {
      attempt_ = connect(
          io_, {"127.0.0.1", listener_->port()}, std::move(tls), "master", test::kPatience,
          [promise](Result<ConnectionPtr> result) { promise->set_value(std::move(result)); });
    });
    return promise->get_future().get();
  }

  // Whether the dialled link is refused: at once, or (TLS 1.3) on its first read.
  bool is_refused(Result<ConnectionPtr> dialled) {
    if (!dialled.is_ok()) return true;
    test::NetPeer peer(io_);
    peer.adopt(std::move(*dialled));
    return !peer.wait_for_end().is_ok();
  }

  const test::TempFolder folder_;
  IoThread io_{"test-net"};
  std::unique_ptr<Listener> listener_;
  std::unique_ptr<ConnectAttempt> attempt_;
  std::promise<ConnectionPtr> accepted_;
  int copies_ = 0;
};

TEST_F(Tls, BothEndsKnowWhoTheOtherIs) {
  serve(context("one", "master"));
  auto dialled = dial(context("one", "slave"));
  ASSERT_TRUE(dialled.is_ok()) << dialled.status().message();
  test::NetPeer here(io_), there(io_);
  here.adopt(std::move(*dialled));
  there.adopt(accepted_.get_future().get());
  io_.run_and_wait([&] {
    EXPECT_TRUE(here.connection().peer().is_authenticated);
    EXPECT_EQ(here.connection().peer().role, "master");
    EXPECT_EQ(there.connection().peer().role, "slave");
    EXPECT_EQ(there.connection().peer().name, "slave");
  });
  here.send(9, "secret", std::vector<std::byte>(3 << 20));
  const auto record = there.next_record();
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->payload.size(), std::size_t{3} << 20);
}

TEST_F(Tls, ACertificateOfAnotherClusterIsRefusedByBoth) {
  serve(context("one", "master"));
  EXPECT_TRUE(is_refused(dial(context("two", "slave"))));
}

TEST_F(Tls, AMasterMustBeAMaster) {
  auto folder = folder_ / "one/app";
  auto impostor = TlsContext::load(folder, "app");
  ASSERT_TRUE(impostor.is_ok());
  serve(*impostor);
  auto dialled = dial(context("one", "slave"));
  ASSERT_FALSE(dialled.is_ok());
  EXPECT_EQ(dialled.status().code(), StatusCode::kPermissionDenied);
  EXPECT_NE(dialled.status().message().find("role"), std::string::npos)
      << dialled.status().message();
}

TEST_F(Tls, PlainToTlsAndTlsToPlainFail) {
  serve(context("one", "master"));
  auto plain = dial(nullptr);
  if (plain.is_ok()) {
    test::NetPeer peer(io_);
    peer.adopt(std::move(*plain));
    peer.send(1, "hello", {});
    EXPECT_FALSE(peer.wait_for_end().is_ok());
  }
  io_.run_and_wait([this] { listener_.reset(); });
  serve(nullptr);
  EXPECT_TRUE(is_refused(dial(context("one", "slave"))));
}

TEST_F(Tls, WhoIsRefusedIsNamedWithTheReason) {
  ASSERT_TRUE(revoke_key(folder_ / "one", "master").is_ok());
  serve(unaware("one", "master"));
  auto dialled = dial(context("one", "slave"));
  ASSERT_FALSE(dialled.is_ok());
  EXPECT_EQ(dialled.status().code(), StatusCode::kPermissionDenied);
  EXPECT_NE(dialled.status().message().find("certificate of master 'master' has been revoked"),
            std::string::npos)
      << dialled.status().message();
  dialled = dial(context("two", "slave"));
  ASSERT_FALSE(dialled.is_ok());
  EXPECT_NE(dialled.status().message().find("'master' is of another cluster"), std::string::npos)
      << dialled.status().message();
}

// TLS 1.3 lets the calling end finish its handshake before it hears of the verdict.
TEST_F(Tls, WhoIsRefusedIsToldTheReasonAndNobodyIsHandedOn) {
  ASSERT_TRUE(revoke_key(folder_ / "one", "app").is_ok());
  const auto master = context("one", "master");
  master->set_refusal([](const std::string& reason) { return Record{5, reason, {}}; });
  serve(master);
  auto accepted = accepted_.get_future();
  auto dialled = dial(unaware("one", "app"));
  ASSERT_TRUE(dialled.is_ok()) << dialled.status().message();
  test::NetPeer peer(io_);
  peer.adopt(std::move(*dialled));
  peer.send(1, "hello", {});
  const auto told = peer.next_record();
  ASSERT_TRUE(told.has_value());
  EXPECT_EQ(told->header, "the certificate of app 'app' has been revoked");
  EXPECT_FALSE(peer.wait_for_end().is_ok());
  EXPECT_EQ(accepted.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
}

TEST_F(Tls, WithoutAWordToSayARefusedPeerIsClosed) {
  ASSERT_TRUE(revoke_key(folder_ / "one", "slave").is_ok());
  serve(context("one", "master"));
  auto accepted = accepted_.get_future();
  EXPECT_TRUE(is_refused(dial(unaware("one", "slave"))));
  EXPECT_EQ(accepted.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
}

TEST_F(Tls, ARevokedPeerIsThrownOutOfAnOpenSessionAndOthersStay) {
  const std::string keys = folder_ / "one";
  ASSERT_TRUE(add_key(keys, "slave", "other", kNodeDays).is_ok());
  auto master = context("one", "master");
  serve(master);
  test::NetPeer thief(io_), other(io_), at_master(io_), other_at_master(io_);
  auto dialled = dial(context("one", "slave"));
  ASSERT_TRUE(dialled.is_ok());
  thief.adopt(std::move(*dialled));
  at_master.adopt(accepted_.get_future().get());
  accepted_ = {};
  dialled = dial(*TlsContext::load(keys + "/other", "slave"));
  ASSERT_TRUE(dialled.is_ok());
  other.adopt(std::move(*dialled));
  other_at_master.adopt(accepted_.get_future().get());
  ASSERT_TRUE(revoke_key(keys, "slave").is_ok());
  io_.run_and_wait([&] {
    const auto is_new = master->reload();
    ASSERT_TRUE(is_new.is_ok()) << is_new.status().message();
    EXPECT_TRUE(*is_new);
  });
  const Status end = at_master.wait_for_end();
  EXPECT_EQ(end.code(), StatusCode::kPermissionDenied);
  EXPECT_NE(end.message().find("slave 'slave'"), std::string::npos) << end.message();
  EXPECT_FALSE(thief.wait_for_end().is_ok());
  other.send(3, "still here", {});
  EXPECT_TRUE(other_at_master.next_record().has_value());
  accepted_ = {};
  EXPECT_TRUE(is_refused(dial(unaware("one", "slave")))) << "it cannot come back";
}

TEST_F(Tls, ARenewedCertificateIsForNewConnectionsAndOldOnesLiveOn) {
  const std::string keys = folder_ / "one";
  auto master = context("one", "master");
  serve(master);
  test::NetPeer here(io_), there(io_), here_again(io_);
  auto dialled = dial(context("one", "slave"));
  ASSERT_TRUE(dialled.is_ok());
  here.adopt(std::move(*dialled));
  there.adopt(accepted_.get_future().get());
  ASSERT_TRUE(renew_key(keys, "master", kNodeDays).is_ok());
  io_.run_and_wait([&] {
    const auto is_new = master->reload();
    EXPECT_TRUE(is_new.is_ok() && *is_new);
    const auto again = master->reload();
    EXPECT_TRUE(again.is_ok() && !*again) << "nothing changed since";
  });
  here.send(3, "on the old one", {});
  EXPECT_TRUE(there.next_record().has_value());
  accepted_ = {};
  dialled = dial(context("one", "slave"));
  ASSERT_TRUE(dialled.is_ok());
  here_again.adopt(std::move(*dialled));
  io_.run_and_wait(
      [&] { EXPECT_NE(here.connection().peer().serial, here_again.connection().peer().serial); });
}

TEST_F(Tls, AReloadThatFailsKeepsTheOldCredentialsAndAGoodListCountsAllTheSame) {
  const std::string keys = folder_ / "one";
  auto master = context("one", "master");
  serve(master);
  ASSERT_TRUE(renew_key(keys, "app", kNodeDays).is_ok());
  std::filesystem::copy_file(keys + "/app/node.key", keys + "/master/node.key",
                             std::filesystem::copy_options::overwrite_existing);
  const auto reload = [&] {
    Status status;
    io_.run_and_wait([&] { status = master->reload().status(); });
    return status;
  };
  EXPECT_EQ(reload().code(), StatusCode::kUnavailable) << "key and certificate do not fit";
  auto dialled = dial(context("one", "slave"));
  ASSERT_TRUE(dialled.is_ok()) << dialled.status().message();
  test::NetPeer there(io_);
  there.adopt(accepted_.get_future().get());
  ASSERT_TRUE(revoke_key(keys, "slave").is_ok());
  EXPECT_FALSE(reload().is_ok());
  EXPECT_EQ(there.wait_for_end().code(), StatusCode::kPermissionDenied);
  ASSERT_TRUE(renew_key(keys, "master", kNodeDays).is_ok());
  EXPECT_TRUE(reload().is_ok());
  std::filesystem::remove(keys + "/master/crl.pem");
  EXPECT_NE(reload().message().find("older"), std::string::npos) << "nothing is taken back";
}

TEST_F(Tls, AFolderThatChangesIsReadByItself) {
  const std::string keys = folder_ / "one";
  auto master = context("one", "master");
  std::unique_ptr<CredentialsWatch> watch;
  io_.run_and_wait([&] {
    watch = std::make_unique<CredentialsWatch>(io_, master, std::chrono::milliseconds(5));
  });
  const auto text = [&] {
    std::string now;
    io_.run_and_wait([&] { now = master->certificate_text(); });
    return now;
  };
  const std::string before = text();
  ASSERT_TRUE(renew_key(keys, "master", kNodeDays).is_ok());
  const TimePoint deadline = Clock::now() + test::kPatience;
  while (text() == before && Clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_NE(text(), before);
  io_.run_and_wait([&] { watch.reset(); });
}

}  // namespace
}  // namespace tessera::net
