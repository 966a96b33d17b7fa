// SPDX-License-Identifier: Apache-2.0
// How results of tiles are judged, written, or refused.
#include <cstring>
#include <utility>

#include "common/base/log.h"
#include "common/frame/faulty_pixels.h"
#include "common/wire/pixel_coding.h"
#include "master/frame_loop/frame_loop_impl.h"
#include "master/frame_loop/possible_figures.h"

namespace tessera::master {
namespace {

// Digest of a tile's pixels, for comparing two results of the tile.
std::uint64_t short_digest(std::span<const std::byte> pixels) {
  const Digest digest = sha256(pixels);
  std::uint64_t value = 0;
  std::memcpy(&value, digest.bytes.data(), sizeof(value));
  return value;
}

}  // namespace

bool FrameLoop::Impl::is_forgiven(SessionId session, ResultVerdict verdict) {
  if (verdict == ResultVerdict::kRepeated) return cluster.forgive_repeat(session);
  return answers_lease(verdict) || verdict == ResultVerdict::kFrameEnded;
}

void FrameLoop::Impl::on_result(SessionId session, wire::TileResult result) {
  const auto found = frames.find(result.frame);
  if (found != frames.end()) {
    FrameAssembly& assembly = found->second.assembly;
    if (result.tile >= assembly.grid().tile_count() ||
        !wire::make_plain(assembly.layout(), assembly.tile_bytes(result.tile), result).is_ok()) {
      return cluster.expel(session, "a tile result of the wrong size");
    }
  }
  const TimePoint now = Clock::now();
  cut_to_possible(
      seconds(observer.since_lease(session, result.frame, {result.tile, result.attempt}, now)),
      seconds(now - started), cluster.threads_of(session), result);
  Actions actions = std::exchange(spare_actions, {});
  actions.clear();
  TileReport report{
      result.frame,        result.version,         result.tile, result.attempt, result.seconds,
      result.held_seconds, result.starved_seconds, 0,           false};
  report.is_faulty =
      found != frames.end() &&
      count_faulty_pixels(found->second.assembly.colour_of(result.tile, result.pixels),
                          found->second.assembly.layout().format()) > 0;
  if (scheduler.is_under_audit(result.frame, result.tile))
    report.pixels = short_digest(result.pixels);
  const ResultVerdict verdict = scheduler.result(session, report, now, actions);
  observer.answered(session, result, verdict, actions, now);
  if (!is_forgiven(session, verdict))
    return cluster.expel(session, std::string("a tile result ") + verdict_text(verdict));
  cluster.add_busy_time(session, result.seconds);
  if (report.is_faulty) on_faulty_tile(session, verdict, found->second, result);
  if (verdict == ResultVerdict::kAccepted) {
    const bool is_settled = !scheduler.is_under_audit(result.frame, result.tile);
    found->second.add(session, result, cluster.ordinal_of(session), is_settled);
    cluster.count_tile(session);
  } else if (verdict == ResultVerdict::kConfirmed) {
    found->second.assembly.settle_tile(result.tile);
  } else if (found != frames.end()) {
    ++found->second.assembly.stats().tiles_rejected;
  }
  perform(actions);
  spare_actions = std::move(actions);
  if (report.is_faulty && verdict == ResultVerdict::kAccepted && options.is_faulty_frame_failed) {
    perform(scheduler.fail_frame(result.frame,
                                 "tile " + std::to_string(result.tile) +
                                     " holds NaN, infinite or negative pixels on every slave that "
                                     "rendered it; mend the scene, or allow them with "
                                     "--faulty-pixels colour",
                                 Clock::now()));
  }
}

// Counts a tile with faulty pixels, logs the first one of a frame, and paints the pixels over when
// the tile is accepted.
void FrameLoop::Impl::on_faulty_tile(SessionId session, ResultVerdict verdict, FrameWork& work,
                                     wire::TileResult& result) {
  FrameStats& stats = work.assembly.stats();
  const bool is_accepted = verdict == ResultVerdict::kAccepted;
  if (verdict != ResultVerdict::kFaulty && !is_accepted) return;
  const PixelFormat format = work.assembly.layout().format();
  const std::span<std::byte> colour = work.assembly.colour_of(result.tile, result.pixels);
  const std::uint64_t pixels =
      is_accepted ? paint_faulty_pixels(colour, format) : count_faulty_pixels(colour, format);
  if (is_accepted) stats.pixels_faulty += pixels;
  if (stats.tiles_faulty++ > 0) return;
  log_warn("faulty-pixels",
           is_accepted ? "NaN, infinite or negative pixels are painted in the error colour"
                       : "NaN, infinite or negative pixels: another slave renders the tile again",
           {{"frame", std::to_string(result.frame)},
            {"tile", std::to_string(result.tile)},
            {"slave", cluster.name_of(session)},
            {"pixels", std::to_string(pixels)}});
}

}  // namespace tessera::master
