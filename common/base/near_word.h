// SPDX-License-Identifier: Apache-2.0
// Finds the known words that somebody may have meant by an unknown one: "did you mean". It serves
// options, keys of config files, commands, names of scenes and of values.
//
// The distance of two words is the number of letters that are missing, too many, wrong, or swapped
// with their neighbour: of every 100 misspelt words some 80 have one such error (Frederick J.
// Damerau, "A technique for computer detection and correction of spelling errors", Communications
// of the ACM, 1964). Dashes in front do not count, '_' is '-', and case does not matter.
//
// A word is near when (1) at most a third of the letters of the longer one are wrong, so that two
// of three still say what was meant, and (2) the likeness is no accident: of words of as many
// letters that are typed at random, not more than one in ten is as near to any known word. For the
// 60 options of a command that leaves one error in three to five letters, two in six to eight,
// three in nine. A word is also near when what was typed, two letters or more, is its beginning.
//
// Threads. Pure functions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tessera {

// Returns: the nearest words, all at one distance, in the order of `words`, at most three; none
// when none is near. Words that begin with what was typed count only when no word is near by
// errors.
std::vector<std::string> near_words(std::string_view typed, const std::vector<std::string>& words);

// Text to append to an error message: "; did you mean '--size'?", "; did you mean 'a' or 'b'?", or
// nothing.
std::string did_you_mean(std::string_view typed, const std::vector<std::string>& words);

}  // namespace tessera
