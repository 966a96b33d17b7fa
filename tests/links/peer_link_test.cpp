// SPDX-License-Identifier: Apache-2.0
// A link that its owner has let go of, or destroyed, says nothing more: neither what came with the
// current message nor the link's end. It holds nothing of the owner.
#include "master/cluster/peer_link.h"
#include "common/net/local_pair.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>

#include "common/net/io_thread.h"
#include "common/wire/codec.h"

namespace tessera::master {
namespace {

enum class Way { kDestroy, kClose, kRefuse, kGoodbye, kIllegalMessage };
constexpr std::array kWays = {Way::kDestroy, Way::kClose, Way::kRefuse, Way::kGoodbye,
                              Way::kIllegalMessage};
constexpr std::array<const char*, kWays.size()> kWayNames = {"Destroy", "Close", "Refuse",
                                                             "Goodbye", "IllegalMessage"};

// Starts the other end, which ignores what comes.
void start_deaf(net::Connection& peer) {
  peer.start({[](const net::ReceivedRecord&) {}, [](const Status&) {}, nullptr},
             wire::session_limits());
}

class PeerLinkTest : public testing::TestWithParam<Way> {
 protected:
  ~PeerLinkTest() override {
    ours_.run_and_wait([this] { link_.reset(); });
    theirs_.run_and_wait([this] { peer_.reset(); });
  }

  void open(PeerLink::Callbacks callbacks) {
    auto [our_end, their_end] = net::make_local_pair(ours_, theirs_);
    peer_ = std::move(their_end);
    theirs_.run_and_wait([this] { start_deaf(*peer_); });
    ours_.run_and_wait([&] {
      link_ = std::make_unique<PeerLink>(ours_, std::move(our_end), wire::session_limits(),
                                         std::move(callbacks));
    });
  }
  net::Record next_record() const {
    if (GetParam() != Way::kIllegalMessage) return wire::encode(wire::Goodbye{"enough"});
    return {wire::encode(wire::TileLease{}).type, "no header", {}};
  }
  // The link gets all of them in one read, since our thread waits meanwhile.
  void receive_at_once(int count, bool ends_then) {
    ours_.run_and_wait([&] {
      theirs_.run_and_wait([&] {
        for (int i = 0; i < count; ++i) peer_->send(next_record());
        if (ends_then) peer_.reset();
      });
    });
    // Runs the tasks that are ready now, those that they post, and the end of the link.
    for (int i = 0; i < 4; ++i) ours_.run_and_wait([] {});
  }
  void let_go(Way way) {
    switch (way) {
      case Way::kDestroy:
        return link_.reset();
      case Way::kClose:
        return link_->close();
      case Way::kRefuse:
        return link_->refuse(wire::RefuseCode::kBusy, "busy");
      case Way::kGoodbye:
        return link_->say_goodbye("that was all");
      case Way::kIllegalMessage:
        return;
    }
  }

  net::IoThread ours_{"ours"}, theirs_{"theirs"};
  std::unique_ptr<PeerLink> link_;  // ours_
  net::ConnectionPtr peer_;         // theirs_
};

TEST_P(PeerLinkTest, SaysNothingMoreOnceItIsOver) {
  int messages = 0, ends = 0;
  open({[&](const wire::Message&) {
          ++messages;
          let_go(GetParam());
        },
        [&](const Status&) { ++ends; }, nullptr});
  receive_at_once(3, true);
  const bool is_their_fault = GetParam() == Way::kIllegalMessage;
  EXPECT_EQ(messages, is_their_fault ? 0 : 1);
  EXPECT_EQ(ends, is_their_fault ? 1 : 0)
      << "whoever lets go of a link is not told that it is gone";
}

// What callbacks hold may be as large as a scene, or be the owner itself.
TEST_P(PeerLinkTest, HoldsNothingOfItsOwnerOnceItIsOver) {
  std::weak_ptr<int> seen;
  {
    const auto held = std::make_shared<int>(1);
    seen = held;
    open({[this, held](const wire::Message&) { let_go(GetParam()); }, [held](const Status&) {},
          [held] {}});
  }
  ASSERT_FALSE(seen.expired());
  receive_at_once(1, false);
  EXPECT_TRUE(seen.expired());
}

// The owner is held by nobody but the callbacks of its own link.
TEST_P(PeerLinkTest, MayBeAllThatKeepsItsOwnerAlive) {
  struct Owner {
    std::unique_ptr<PeerLink> link;
    int messages = 0;
  };
  auto owner = std::make_shared<Owner>();
  const std::weak_ptr<Owner> seen = owner;
  open({});
  ours_.run_and_wait([&] {
    owner->link = std::move(link_);
    PeerLink* const link = owner->link.get();
    link->set_callbacks({[link, way = GetParam(), owner](const wire::Message&) {
                           ++owner->messages;
                           if (way == Way::kDestroy) return owner->link.reset();
                           link->close();
                         },
                         [owner](const Status&) {}, nullptr});
    owner.reset();
  });
  receive_at_once(2, true);
  EXPECT_TRUE(seen.expired());
}

INSTANTIATE_TEST_SUITE_P(Ways, PeerLinkTest, testing::ValuesIn(kWays), [](const auto& way) {
  return std::string(kWayNames[static_cast<std::size_t>(way.param)]);
});

TEST(PeerLinkEnd, IsToldOnce) {
  net::IoThread io("both");
  std::unique_ptr<PeerLink> link;
  net::ConnectionPtr peer;
  int ends = 0;
  bool is_told = false;
  io.run_and_wait([&] {
    auto [ours, theirs] = net::make_local_pair(io, io);
    peer = std::move(theirs);
    start_deaf(*peer);
    link = std::make_unique<PeerLink>(io, std::move(ours), wire::session_limits(),
                                      PeerLink::Callbacks{nullptr,
                                                          [&](const Status&) {
                                                            ++ends;
                                                            is_told = true;
                                                          },
                                                          nullptr});
    peer->close();
  });
  for (bool is_done = false; !is_done;) io.run_and_wait([&] { is_done = is_told; });
  io.run_and_wait([&] {
    link->close();
    link->refuse(wire::RefuseCode::kBusy, "busy");
    link.reset();
  });
  EXPECT_EQ(ends, 1);
}

}  // namespace
}  // namespace tessera::master
