// SPDX-License-Identifier: Apache-2.0
// Codec of what a master's log holds, at the end of StatusReply's payload.
#include <bit>

#include "common/wire/codec_internal.h"

namespace tessera::wire {
namespace {

constexpr std::uint8_t kLevelMost = 5;  // of LogLevel
static_assert(EventMemory::kLineBytesMax <= kEventLineBytesMax);

void put_text(std::vector<std::byte>& out, const std::string& text) {
  put_le(out, static_cast<std::uint16_t>(text.size()));
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

// Returns: the bytes used; 0 when they do not hold a text.
std::size_t get_text(std::span<const std::byte> in, std::string& text) {
  if (in.size() < sizeof(std::uint16_t)) return 0;
  const std::size_t bytes = get_le<std::uint16_t>(in, 0);
  if (in.size() < sizeof(std::uint16_t) + bytes) return 0;
  text.assign(reinterpret_cast<const char*>(in.data()) + sizeof(std::uint16_t), bytes);
  return sizeof(std::uint16_t) + bytes;
}

}  // namespace

void put_event(std::vector<std::byte>& out, const PastEvent& event) {
  put_text(out, clean_line(event.line).substr(0, kEventLineBytesMax));
  put_le(out, std::bit_cast<std::uint64_t>(event.seconds_ago));
  put_le(out, event.level);
}

std::size_t get_event(std::span<const std::byte> in, FieldCheck& check, PastEvent& event) {
  const std::size_t at = get_text(in, event.line);
  if (at == 0 || in.size() < at + sizeof(std::uint64_t) + 1) return 0;
  event.seconds_ago = std::bit_cast<double>(get_le<std::uint64_t>(in, at));
  event.level = get_le<std::uint8_t>(in, at + sizeof(std::uint64_t));
  check.name("events.line", event.line, 0, kEventLineBytesMax);
  check.not_negative("events.seconds_ago", event.seconds_ago);
  check.range("events.level", event.level, 0, kLevelMost);
  return check.is_ok() ? at + sizeof(std::uint64_t) + 1 : 0;
}

void put_suppressed(std::vector<std::byte>& out, const SuppressedLines& lines) {
  put_text(out, clean_line(lines.event).substr(0, kNameBytesMax));
  put_le(out, lines.lines);
}

std::size_t get_suppressed(std::span<const std::byte> in, FieldCheck& check,
                           SuppressedLines& lines) {
  const std::size_t at = get_text(in, lines.event);
  if (at == 0 || in.size() < at + sizeof(std::uint64_t)) return 0;
  lines.lines = get_le<std::uint64_t>(in, at);
  check.name("suppressed.event", lines.event, 1, kNameBytesMax);
  return check.is_ok() ? at + sizeof(std::uint64_t) : 0;
}

}  // namespace tessera::wire
