// Mutual TLS between a listener and a connecting peer, with good and wrong credentials.
#include "common/net/tls.h"

#include <gtest/gtest.h>

#include <future>

#include "common/net/connection.h"
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
          io_, {"127.0.0.1", listener_->port()}, std::move(tls), "master", std::chrono::seconds(5),
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

}  // namespace
}  // namespace tessera::net
