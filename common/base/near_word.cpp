// SPDX-License-Identifier: Apache-2.0
#include "common/base/near_word.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera {
namespace {

constexpr std::size_t kLongestWord = 64;  // no option is longer; what is typed may be anything
constexpr std::size_t kSuggestionsMax = 3;
constexpr double kLetters = 27;        // of the alphabet of options: a to z and the dash
constexpr double kAccidentsMax = 0.1;  // of words typed at random
constexpr std::size_t kLettersPerError = 3;
constexpr std::size_t kBeginningMin = 2;  // letters

std::string plain(std::string_view word) {
  word.remove_prefix(std::min(word.find_first_not_of('-'), word.size()));
  std::string result(word);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 'a' - 'A');
    if (c == '_') c = '-';
  }
  return result;
}

// Number of errors between two words, where each letter takes part in at most one error ("optimal
// string alignment"). Of the table of all pairs of prefixes three rows are kept.
std::size_t errors_between(const std::string& a, const std::string& b) {
  std::vector<std::size_t> two_before, before(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) before[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t wrong = a[i - 1] != b[j - 1] ? 1 : 0;
      row[j] = std::min({before[j] + 1, row[j - 1] + 1, before[j - 1] + wrong});
      const bool is_swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (is_swapped) row[j] = std::min(row[j], two_before[j - 2] + 1);
    }
    two_before = before;
    std::swap(before, row);
  }
  return before[b.size()];
}

double power_by_factorial(double base, int exponent) {
  return std::pow(base, exponent) / std::tgamma(exponent + 1.0);
}

// Upper bound of the number of words of `letters` letters that lie within `errors` errors of a word
// of `m` letters. With k letters in the alphabet, an extra letter can stand in m + 1 places and be
// any of k, m letters can be missing, each of m can be one of k - 1 others, and m - 1 pairs can be
// swapped. For e errors of one kind, in any order, that number is raised to the power e and divided
// by e!.
double words_near(std::size_t m, std::size_t letters, std::size_t errors) {
  const auto n = static_cast<double>(m);
  const auto more = static_cast<int>(letters) - static_cast<int>(m);
  const auto most = static_cast<int>(errors);
  double sum = 0;
  for (int many = std::max(more, 0); many <= most; ++many) {
    const int missing = many - more;
    for (int wrong = 0; many + missing + wrong <= most; ++wrong) {
      for (int swapped = 0; many + missing + wrong + swapped <= most; ++swapped) {
        sum += power_by_factorial((n + 1) * kLetters, many) * power_by_factorial(n, missing) *
               power_by_factorial(n * (kLetters - 1), wrong) * power_by_factorial(n - 1, swapped);
      }
    }
  }
  return sum;
}

// Greatest number of errors with which a word of `letters` letters is near by no accident.
std::size_t errors_allowed(std::size_t letters, const std::vector<std::string>& words) {
  const double all = std::pow(kLetters, static_cast<double>(letters));
  for (std::size_t errors = letters / kLettersPerError + 1; errors > 0; --errors) {
    double near = 0;
    for (const std::string& word : words) near += words_near(word.size(), letters, errors);
    if (near <= kAccidentsMax * all) return errors;
  }
  return 0;
}

}  // namespace

std::vector<std::string> near_words(std::string_view typed, const std::vector<std::string>& words) {
  const std::string meant = plain(typed.substr(0, kLongestWord));
  const auto add = [](std::vector<std::string>& found, const std::string& word) {
    if (std::find(found.begin(), found.end(), word) == found.end()) found.push_back(word);
  };
  std::vector<std::string> plain_words, nearest, begun;
  for (const std::string& word : words) plain_words.push_back(plain(word));
  std::size_t least = errors_allowed(meant.size(), plain_words);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string &word = words[i], &candidate = plain_words[i];
    const std::size_t errors = errors_between(meant, candidate);
    const std::size_t letters = std::max(meant.size(), candidate.size());
    if (errors <= letters / kLettersPerError && errors <= least) {
      if (errors < least) nearest.clear();
      least = errors;
      add(nearest, word);
    }
    if (meant.size() >= kBeginningMin && candidate.starts_with(meant)) add(begun, word);
  }
  std::vector<std::string>& result = nearest.empty() ? begun : nearest;
  if (result.size() > kSuggestionsMax) result.resize(kSuggestionsMax);
  return result;
}

std::string did_you_mean(std::string_view typed, const std::vector<std::string>& words) {
  const std::vector<std::string> near = near_words(typed, words);
  std::string text;
  for (std::size_t i = 0; i < near.size(); ++i) {
    text += i == 0 ? "; did you mean " : i + 1 < near.size() ? ", " : " or ";
    text += "'" + near[i] + "'";
  }
  return near.empty() ? text : text + "?";
}

}  // namespace tessera
