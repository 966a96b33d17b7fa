// SPDX-License-Identifier: Apache-2.0
// Which of the words that exist somebody may have meant by one that does not: "did you mean". For
// options, keys of config files, commands, names of scenes and of values.
//
// The distance of two words is the number of letters that are missing, too many, wrong, or swapped
// with their neighbour: of every 100 misspelt words some 80 have one such error (Frederick J.
// Damerau, "A technique for computer detection and correction of spelling errors", Communications
// of the ACM, 1964). Dashes in front do not count, '_' is '-', and case does not matter.
//
// A word is near when (1) at most a third of the letters of the longer one are wrong, so that two of
// three still say what was meant, and (2) it is no accident: of words that are typed at random, of as
// many letters, not more than one in ten is as near to any of those that exist. For the 60 options of
// a command that leaves one error in three to five letters, two in six to eight, three in nine. Or
// what was typed, of two letters and more, begins it.
//
// Threads. Pure functions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tessera {

// The nearest ones, all at one distance, in their order, at most three; none when none is near. What
// only begins a word counts when nothing is near by errors.
std::vector<std::string> near_words(std::string_view typed, const std::vector<std::string>& words);

// "; did you mean '--size'?", "; did you mean 'a' or 'b'?", or nothing. To be put behind what was
// wrong.
std::string did_you_mean(std::string_view typed, const std::vector<std::string>& words);

}  // namespace tessera
