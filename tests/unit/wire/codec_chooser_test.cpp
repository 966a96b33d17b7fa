// SPDX-License-Identifier: Apache-2.0
// The coding that is chosen is the one of the least time per byte, worked out by hand.
#include "common/wire/codec_chooser.h"

#include <gtest/gtest.h>

namespace tessera::wire {
namespace {

constexpr double kMega = 1e6;

// A chooser that is fed piece by piece by a link and two codecs that behave as told.
struct Bench {
  double lz4_rate = 500 * kMega, lz4_share = 0.6;
  double zstd_rate = 200 * kMega, zstd_share = 0.45;
  CodecChooser chooser;

  ByteCoding send_one() {
    constexpr std::size_t kPiece = 100'000;
    const ByteCoding coding = chooser.next(kByteCodingsAll);
    const bool is_lz4 = coding == ByteCoding::kLz4;
    chooser.measured(coding, kPiece,
                     static_cast<std::size_t>((is_lz4 ? lz4_share : zstd_share) * kPiece),
                     kPiece / (is_lz4 ? lz4_rate : zstd_rate));
    return coding;
  }
  // Returns: the coding that is chosen after 300 pieces on a link of this rate.
  ByteCoding settle(double link) {
    chooser.set_link(link);
    for (int i = 0; i < 300; ++i) send_one();
    return chooser.chosen();
  }
};

TEST(CodecChooser, TakesWhatBringsAByteOverSoonest) {
  // Microseconds per byte, r in MB/s: plain 1/r, lz4 1/500 + 0.6/r, zstd 1/200 + 0.45/r.
  EXPECT_EQ(Bench().settle(10 * kMega), ByteCoding::kZstd);  // 0.1; 0.062; 0.05
  EXPECT_EQ(Bench().settle(100 * kMega), ByteCoding::kLz4);  // 0.01; 0.008; 0.0095
  EXPECT_EQ(Bench().settle(1000 * kMega), ByteCoding::kNone);
}

TEST(CodecChooser, AFastLinkOrOneNeverSeenWithAQueueCostsNoTrial) {
  Bench bench;
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(bench.send_one(), ByteCoding::kNone);
}

TEST(CodecChooser, OnlyWhatTheReceiverDecodes) {
  Bench bench;
  bench.chooser.set_link(1 * kMega);
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(bench.chooser.next(kByteCodingsNone), ByteCoding::kNone);
    const ByteCoding coding = bench.chooser.next(coding_bit(ByteCoding::kLz4));
    ASSERT_EQ(coding, ByteCoding::kLz4);
    bench.chooser.measured(coding, 100, 50, 1e-7);
  }
}

TEST(CodecChooser, ItDoesNotSwingAboutTheBreakEven) {
  // lz4 breaks even where 1/r = 1/500 + 0.6/r: r = 200 MB/s.
  Bench bench;
  bench.zstd_share = 1;
  int changes = 0;
  ByteCoding before = bench.settle(200 * kMega);
  for (int i = 0; i < 2000; ++i) {
    const ByteCoding now = bench.settle((i % 2 == 0 ? 190 : 210) * kMega);
    changes += now != before;
    before = now;
  }
  EXPECT_LE(changes, 1);
}

TEST(CodecChooser, FindsACodecThatBeginsToPayAndLeavesOneThatCeasesTo) {
  Bench bench;
  bench.lz4_share = bench.zstd_share = 1;  // noise: nothing shrinks
  EXPECT_EQ(bench.settle(10 * kMega), ByteCoding::kNone);
  bench.zstd_share = 0.1;
  for (int i = 0; i < 64 * 40; ++i) bench.send_one();
  EXPECT_EQ(bench.chooser.chosen(), ByteCoding::kZstd);
  bench.zstd_share = 1;
  EXPECT_EQ(bench.settle(10 * kMega), ByteCoding::kNone);
}

TEST(CodecChooser, TrialsAreRare) {
  Bench bench;
  bench.lz4_share = bench.zstd_share = 1;
  bench.settle(10 * kMega);
  int trials = 0;
  for (int i = 0; i < 6400; ++i) trials += bench.send_one() != ByteCoding::kNone;
  EXPECT_GE(trials, 150);
  EXPECT_LE(trials, 210);  // two codecs, each one of 64
}

TEST(CodecChooser, ALinkThatBecomesFastEndsTheCoding) {
  Bench bench;
  EXPECT_EQ(bench.settle(10 * kMega), ByteCoding::kZstd);
  bench.chooser.set_link(std::nullopt);
  EXPECT_EQ(bench.chooser.next(kByteCodingsAll), ByteCoding::kNone);
}

}  // namespace
}  // namespace tessera::wire
