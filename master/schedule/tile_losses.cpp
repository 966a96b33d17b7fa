// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/tile_losses.h"

#include <algorithm>
#include <numeric>

#include "common/base/limits.h"
#include "master/schedule/departed_slaves.h"

namespace tessera::master {

void TileLosses::lost(TileIndex tile, const SlaveIdentity& slave, TimePoint now) {
  std::vector<Loss>& losses = tiles_[tile];
  auto loss = std::find_if(losses.begin(), losses.end(),
                           [&](const Loss& l) { return l.slave.id() == slave.id(); });
  if (loss == losses.end()) loss = losses.insert(losses.end(), Loss{});
  loss->slave = slave;
  ++loss->times;
  loss->is_certain = false;
  loss->at = now;
  loss->session = 0;
}

void TileLosses::discredit(const SlaveIdentity& slave, TimePoint now) {
  for (auto& [tile, losses] : tiles_) {
    for (Loss& loss : losses) {
      const bool is_with_it_again = loss.at == now && loss.times > 1;
      if (loss.slave.id() == slave.id() && !is_with_it_again) loss.is_witness = false;
    }
  }
}

void TileLosses::joined(SessionId session, const SlaveIdentity& slave) {
  for (auto tile = tiles_.begin(); tile != tiles_.end();) {
    std::vector<Loss>& losses = tile->second;
    std::erase_if(losses, [&](Loss& loss) {
      if (loss.slave.id() != slave.id()) return false;
      if (slave.is_same_process(loss.slave)) {
        --loss.times;
        loss.slave.instance = 0;  // the losses before this one are another process's
      }
      loss.is_certain = true;
      loss.session = session;
      return loss.times == 0;
    });
    tile = losses.empty() ? tiles_.erase(tile) : std::next(tile);
  }
}

void TileLosses::settle(TimePoint now) {
  for (auto& [tile, losses] : tiles_) {
    for (Loss& loss : losses) {
      if (now - loss.at >= DepartedSlaves::kReturn) loss.is_certain = true;
    }
  }
}

bool TileLosses::is_certain(TileIndex tile) const {
  const auto found = tiles_.find(tile);
  return found == tiles_.end() || std::all_of(found->second.begin(), found->second.end(),
                                              [](const Loss& loss) { return loss.is_certain; });
}

std::size_t TileLosses::slave_count(TileIndex tile) const {
  const auto found = tiles_.find(tile);
  return found == tiles_.end() ? 0 : found->second.size();
}

std::size_t TileLosses::witness_count(TileIndex tile) const {
  const auto found = tiles_.find(tile);
  if (found == tiles_.end()) return 0;
  return static_cast<std::size_t>(std::count_if(found->second.begin(), found->second.end(),
                                                [](const Loss& loss) { return loss.is_witness; }));
}

TimePoint TileLosses::last_at(TileIndex tile) const {
  const std::vector<Loss>& losses = tiles_.at(tile);
  return std::max_element(losses.begin(), losses.end(),
                          [](const Loss& a, const Loss& b) { return a.at < b.at; })
      ->at;
}

TileLosses::Case TileLosses::of(TileIndex tile) const {
  const auto found = tiles_.find(tile);
  if (found == tiles_.end()) return Case::kNone;
  const std::vector<Loss>& losses = found->second;
  if (witness_count(tile) >= std::size_t{kTileAttemptsMax})
    return is_certain(tile) ? Case::kHopeless : Case::kAwaited;
  const int times = std::accumulate(losses.begin(), losses.end(), 0,
                                    [](int sum, const Loss& loss) { return sum + loss.times; });
  return times >= kTileAttemptsMax ? Case::kOthers : Case::kOpen;
}

std::vector<SessionId> TileLosses::sessions(TileIndex tile) const {
  std::vector<SessionId> sessions;
  const auto found = tiles_.find(tile);
  if (found == tiles_.end()) return sessions;
  for (const Loss& loss : found->second) {
    if (loss.session != 0) sessions.push_back(loss.session);
  }
  return sessions;
}

std::vector<TileIndex> TileLosses::tiles() const {
  std::vector<TileIndex> tiles;
  for (const auto& [tile, losses] : tiles_) tiles.push_back(tile);
  return tiles;
}

std::string TileLosses::names(TileIndex tile) const {
  const auto found = tiles_.find(tile);
  if (found == tiles_.end()) return {};
  const std::vector<Loss>& losses = found->second;
  std::string text;
  for (std::size_t i = 0; i < losses.size(); ++i) {
    if (i > 0) text += i + 1 == losses.size() ? " and " : ", ";
    text += "'" + losses[i].slave.name + "'";
    if (losses[i].times > 1) text += " (" + std::to_string(losses[i].times) + " times)";
  }
  return text;
}

}  // namespace tessera::master
