// Finds values in JSON text that somebody else has parsed and found good: for the few members that
// Assimp passes over. Text that is no JSON after all ends in "not there", never beyond its end.
//
// Threads. Pure functions. Views point into the text that was given.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace tessera::import {

// The value of a member, as text; empty when `object` is none or has no such member. Keys with
// escapes are not found.
std::string_view json_member(std::string_view object, std::string_view key);

// The elements of an array, as texts; none when it is none.
std::vector<std::string_view> json_elements(std::string_view array);

std::optional<float> json_number(std::string_view value);

}  // namespace tessera::import
