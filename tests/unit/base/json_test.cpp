// SPDX-License-Identifier: Apache-2.0
#include "common/base/json.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace tessera {
namespace {

TEST(Json, EscapesWhatWouldBreakALine) {
  JsonObject json;
  json.add("a\"b", "line\nquote\" back\\ ")
      .add("n", std::uint64_t{18446744073709551615u})
      .add("t", true);
  EXPECT_EQ(
      json.text(),
      "{\"a\\\"b\":\"line\\u000aquote\\\" back\\\\ \",\"n\":18446744073709551615,\"t\":true}");
}

TEST(Json, TextsAreFitForATerminal) {
  JsonObject json;
  json.add("name",
           "a\x1b]0;b\xc2\x9b"
           "c\xff\xe2\x80\xae"
           "d\xc3\xa4\ne");
  EXPECT_EQ(json.text(), "{\"name\":\"a?]0;b?c??d\xc3\xa4\\u000ae\"}");
  const std::string is_long(10000, 'x');
  EXPECT_EQ(JsonObject().add("n", is_long).text().size(), is_long.size() + 8) << "nothing is cut";
}

TEST(Json, NumbersThatJsonLacksBecomeNull) {
  JsonObject json;
  json.add("nan", std::numeric_limits<double>::quiet_NaN()).add("x", 0.1);
  EXPECT_EQ(json.text(), "{\"nan\":null,\"x\":0.1}");
}

}  // namespace
}  // namespace tessera
