// SPDX-License-Identifier: Apache-2.0
// How much memory can be had now: what the machine has left, and what the control groups allow.
// Threads. Any; each call reads small files of the kernel and keeps nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera {

// `root`: where /proc and /sys are looked for ("" outside of tests).
// Returns: bytes; nothing where the kernel does not say.
std::optional<std::uint64_t> free_memory_bytes(const std::string& root = "");

}  // namespace tessera
