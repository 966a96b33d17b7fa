// SPDX-License-Identifier: Apache-2.0
// "Did you mean" names words that are near enough to be meant and not near by accident.
#include "common/base/near_word.h"
#include "tests/support/seed.h"

#include <gtest/gtest.h>

#include <random>

namespace tessera {
namespace {

using Words = std::vector<std::string>;

const Words kOptions = {"--aa",
                        "--audit",
                        "--bounces",
                        "--camera",
                        "--clamp",
                        "--config",
                        "--connect",
                        "--filter",
                        "--fps",
                        "--frames",
                        "--isa",
                        "--keys",
                        "--listen",
                        "--local",
                        "--metrics",
                        "--output",
                        "--environment",
                        "--passes",
                        "--pixels",
                        "--plain",
                        "--prefetch",
                        "--quiet",
                        "--relay",
                        "--renderer",
                        "--seed",
                        "--size",
                        "--slaves",
                        "--stats",
                        "--threads",
                        "--tile",
                        "--trace",
                        "--vpls",
                        "--wait",
                        "--schedule",
                        "--light-samples",
                        "--slave",
                        "--frames-in-flight"};

TEST(NearWord, OneErrorOfEachKindIsForgiven) {
  for (const char* typed : {"--siz", "--sizee", "--sise", "--isze", "-size", "size", "--SIZE"}) {
    EXPECT_EQ(near_words(typed, kOptions), Words{"--size"}) << typed;
  }
  EXPECT_EQ(near_words("--fsp", kOptions), Words{"--fps"});
  EXPECT_EQ(near_words("--enviroment", kOptions), Words{"--environment"});
  EXPECT_EQ(near_words("--light_sample", kOptions), Words{"--light-samples"});
  EXPECT_EQ(near_words("--framesinflight", kOptions), Words{"--frames-in-flight"});
  EXPECT_EQ(near_words("--rendrer", kOptions), Words{"--renderer"});
}

TEST(NearWord, TheNearestWinAndAllOfThemAreNamed) {
  EXPECT_EQ(near_words("--slaves", kOptions), Words{"--slaves"});
  EXPECT_EQ(near_words("--slavex", kOptions), (Words{"--slaves", "--slave"}));
  EXPECT_EQ(near_words("--frame", kOptions), Words{"--frames"});
  EXPECT_EQ(near_words("siez", {"size", "size"}), Words{"size"}) << "of two commands";
}

TEST(NearWord, WhatBeginsAWordStandsForIt) {
  EXPECT_EQ(near_words("--env", kOptions), Words{"--environment"});
  EXPECT_EQ(near_words("--re", kOptions), (Words{"--relay", "--renderer"}));
  EXPECT_EQ(near_words("--e", kOptions), Words{});
}

TEST(NearWord, WhatMayBeAnythingIsNothing) {
  for (const char* typed : {"", "-", "--", "--x", "--bogus", "--nonsense", "--zz", "--volume"}) {
    EXPECT_EQ(near_words(typed, kOptions), Words{}) << typed;
  }
  EXPECT_EQ(near_words(std::string(100'000, 'a'), kOptions), Words{});
  EXPECT_EQ(near_words("--size", {}), Words{});
}

// near_words() promises this for words of any length. A fixed number of forgiven errors would break
// the promise, since more errors may be forgiven among few words than among many.
TEST(NearWord, OfWordsTypedAtRandomOneInTenIsNearAtMost) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(test::seed(kSeed));
  const auto letters = [&](std::size_t count) {
    std::string word;
    while (word.size() < count) word += "abcdefghijklmnopqrstuvwxyz-"[random() % 27];
    return word[0] == '-' ? "q" + word.substr(1) : word;
  };
  for (const std::size_t known : {4u, 40u, 200u}) {
    Words words;
    while (words.size() < known) words.push_back(letters(2 + random() % 10));
    for (std::size_t length = 1; length <= 9; ++length) {
      constexpr int kTries = 500;
      int near = 0;
      for (int i = 0; i < kTries; ++i) {
        const std::string typed = letters(length);
        // Letters that merely begin a word find it without any error to be forgiven.
        const Words found = near_words(typed, words);
        near += !found.empty() && !found[0].starts_with(typed) ? 1 : 0;
      }
      // 20: three standard deviations of a share of one in ten.
      EXPECT_LE(near, kTries / 10 + 20) << length << " letters, " << known << " words";
    }
  }
}

TEST(NearWord, TheQuestionIsPutBehindWhatWasWrong) {
  EXPECT_EQ(did_you_mean("--siez", kOptions), "; did you mean '--size'?");
  EXPECT_EQ(did_you_mean("--re", kOptions), "; did you mean '--relay' or '--renderer'?");
  EXPECT_EQ(did_you_mean("pa", {"path", "park", "pale", "pact"}),
            "; did you mean 'path', 'park' or 'pale'?");
  EXPECT_EQ(did_you_mean("--bogus", kOptions), "");
}

}  // namespace
}  // namespace tessera
