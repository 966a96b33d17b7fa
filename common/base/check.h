// SPDX-License-Identifier: Apache-2.0
// Checks of conditions that only a bug can break. A failed check prints both values and stops the
// process, in every build. What the world can break (peers, files, flags) is a Status instead.
#pragma once

#include <sstream>
#include <string>

namespace tessera::detail {

// Prints "CHECK failed" with place and text on stderr and aborts.
[[noreturn]] void check_failed(const char* file, int line, const char* expression,
                               const std::string& values);

template <typename A, typename B>
std::string both(const A& a, const B& b) {
  std::ostringstream out;
  out << a << " against " << b;
  return out.str();
}

}  // namespace tessera::detail

#define TESSERA_CHECK(condition)                                                           \
  do {                                                                                     \
    if (!(condition)) ::tessera::detail::check_failed(__FILE__, __LINE__, #condition, ""); \
  } while (false)

#define TESSERA_CHECK_OP_(a, op, b)                                          \
  do {                                                                       \
    if (!((a)op(b)))                                                         \
      ::tessera::detail::check_failed(__FILE__, __LINE__, #a " " #op " " #b, \
                                      ::tessera::detail::both((a), (b)));    \
  } while (false)

#define TESSERA_CHECK_EQ(a, b) TESSERA_CHECK_OP_(a, ==, b)
#define TESSERA_CHECK_NE(a, b) TESSERA_CHECK_OP_(a, !=, b)
#define TESSERA_CHECK_LT(a, b) TESSERA_CHECK_OP_(a, <, b)
#define TESSERA_CHECK_LE(a, b) TESSERA_CHECK_OP_(a, <=, b)
#define TESSERA_CHECK_GE(a, b) TESSERA_CHECK_OP_(a, >=, b)
