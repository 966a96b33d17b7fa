// SPDX-License-Identifier: Apache-2.0
#include "common/base/clean_text.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(CleanText, OrdinaryTextOfAnyLanguageStays) {
  for (const char* text : {"", "plain ~", "Größe", "日本語", "😀", "a\xc2\xa0z"})
    EXPECT_EQ(clean_text(text), text);
}

TEST(CleanText, EscapesAndControlsAreDefused) {
  EXPECT_EQ(clean_text("\x1b]0;title\x07"), "?]0;title?");
  EXPECT_EQ(clean_text("\x1b[2Jgone"), "?[2Jgone");
  EXPECT_EQ(clean_text("a\r\nb\tc\x7f"), "a??b?c?");
  EXPECT_EQ(clean_text("a\xc2\x9b"
                       "31mred"),
            "a?31mred")
      << "the C1 form of an escape, in UTF-8";
  EXPECT_EQ(clean_text("a\x9b"
                       "31mred"),
            "a?31mred")
      << "the same as a single byte";
  EXPECT_EQ(clean_text(std::string_view("a\0b", 3)), "a?b");
  EXPECT_EQ(clean_text("\xe2\x80\xae"
                       "gnp.exe"),
            "?gnp.exe")
      << "written from right to left";
  EXPECT_EQ(clean_text("\xe2\x80\xa8x\xe2\x81\xa6y"), "?x?y");
}

TEST(CleanText, WhatIsNoUtf8IsReplacedByteByByte) {
  EXPECT_EQ(clean_text("\xff\xfe"), "??");
  EXPECT_EQ(clean_text("a\xc3"), "a?") << "cut";
  EXPECT_EQ(clean_text("\xc0\x9b"), "??") << "longer than need be";
  EXPECT_EQ(clean_text("\xed\xa0\x80"), "???") << "a surrogate";
  EXPECT_EQ(clean_text("\xf4\x90\x80\x80"), "????") << "beyond the last";
}

TEST(CleanText, LengthIsBoundAndNoCharacterIsCut) {
  EXPECT_EQ(clean_text("12345", 5), "12345");
  EXPECT_EQ(clean_text("123456", 5), "12...");
  EXPECT_EQ(clean_text("ä"
                       "ä"
                       "ä",
                       5),
            "ä...");
  EXPECT_EQ(clean_text(std::string(1 << 20, 'x')).size(), kCleanBytesMax);
}

TEST(CleanText, BlocksKeepTheirLines) { EXPECT_EQ(clean_text("a\nb\x1b", 100, true), "a\nb?"); }

}  // namespace
}  // namespace tessera
