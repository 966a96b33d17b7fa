// SPDX-License-Identifier: Apache-2.0
#include "common/base/json.h"

#include <gtest/gtest.h>

#include <limits>

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

TEST(Json, NumbersThatJsonLacksBecomeNull) {
  JsonObject json;
  json.add("nan", std::numeric_limits<double>::quiet_NaN()).add("x", 0.1);
  EXPECT_EQ(json.text(), "{\"nan\":null,\"x\":0.1}");
}

}  // namespace
}  // namespace tessera
