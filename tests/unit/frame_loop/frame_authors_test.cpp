// SPDX-License-Identifier: Apache-2.0
// Which frames hold tiles of a slave, told when it is convicted.
#include "master/frame_loop/frame_authors.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

TEST(FrameAuthors, FramesInARowAreOneRange) {
  FrameAuthors authors;
  authors.slave_joined(1, "liar");
  EXPECT_EQ(authors.frames_of("liar"), "");
  for (const FrameId frame : {3, 4, 4, 5, 9}) authors.add(1, frame);
  EXPECT_EQ(authors.frames_of("liar"), "3-5, 9");
  EXPECT_EQ(authors.frames_of("nobody"), "");
}

TEST(FrameAuthors, EarlierSessionsOfTheSlaveCountAndThoseOfOthersDoNot) {
  FrameAuthors authors;
  authors.slave_joined(1, "liar");
  authors.slave_joined(2, "honest");
  authors.add(1, 1);
  authors.add(2, 1);
  authors.add(2, 2);
  authors.slave_joined(3, "liar");
  authors.add(3, 2);
  authors.add(3, 7);
  EXPECT_EQ(authors.frames_of("liar"), "1-2, 7");
  EXPECT_EQ(authors.frames_of("honest"), "1-2");
  EXPECT_TRUE(authors.is_of(1, "liar") && authors.is_of(3, "liar"));
  EXPECT_FALSE(authors.is_of(2, "liar") || authors.is_of(4, "liar"));
}

TEST(FrameAuthors, ManyFramesAreToldByTheNewest) {
  FrameAuthors authors;
  authors.slave_joined(1, "liar");
  for (FrameId frame = 0; frame < 2000; frame += 2) authors.add(1, frame);
  EXPECT_EQ(authors.frames_of("liar"),
            "earlier ones, 1984, 1986, 1988, 1990, 1992, 1994, 1996, 1998");
}

TEST(FrameAuthors, RememberSoManySessionsAndNoMore) {
  FrameAuthors authors;
  for (std::size_t slave = 1; slave <= FrameAuthors::kSessionsMax + 1; ++slave) {
    const SessionId session = 1'000'000 - slave;  // in no order that tells their age
    authors.slave_joined(session, "slave " + std::to_string(slave));
    authors.add(session, 5);
  }
  EXPECT_EQ(authors.frames_of("slave 1"), "") << "the oldest is forgotten";
  EXPECT_EQ(authors.frames_of("slave 2"), "5");
}

}  // namespace
}  // namespace tessera::master
