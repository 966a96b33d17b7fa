// SPDX-License-Identifier: Apache-2.0
#include "common/wire/scene_receiver.h"

#include <algorithm>
#include <limits>
#include <new>
#include <string>
#include <utility>

#include "common/base/byte_text.h"

namespace tessera::wire {
namespace {

std::string wrong_size_text(std::size_t block) {
  return "block " + std::to_string(block) + " does not have its announced size";
}

std::string no_memory_text(std::uint64_t block_bytes) {
  return "no memory for a scene block of " + std::to_string(block_bytes) + " bytes";
}

// The tables of a scene have run out of memory, not its blocks.
constexpr const char* kNoMemoryForTables = "no memory for the list of the scene's blocks";

}  // namespace

Status SceneReceiver::announce(SceneAnnounce announce, Actions& actions) {
  if (announce.version <= newest_announced_) {
    return Status::data_loss("SceneAnnounce.version " + std::to_string(announce.version) +
                             " does not follow " + std::to_string(newest_announced_));
  }
  if (waiting_.size() >= kAnnouncedMax) {
    return Status::resource_exhausted("more than " + std::to_string(kAnnouncedMax) +
                                      " scenes announced and not complete");
  }
  try {
    TESSERA_RETURN_IF_ERROR(newest_blocks_.take(announce));
    newest_announced_ = announce.version;
    announce.digests = {};
    announce.sizes = {};
    waiting_.push_back({std::move(announce), newest_blocks_.names(), newest_blocks_.total_bytes()});
  } catch (const std::bad_alloc&) {
    newest_announced_ = announce.version;
    newest_blocks_.forget();  // the next announcement is to name all blocks
    actions.failed.push_back({announce.version, kNoMemoryForTables});
  }
  if (!head_) serve_next(actions);
  return Status::ok();
}

void SceneReceiver::serve_next(Actions& actions) {
  while (!head_ && !waiting_.empty()) {
    Announced announced = std::move(waiting_.front());
    waiting_.pop_front();
    const SceneVersion version = announced.announce.version;
    try {
      serve(std::move(announced), actions);
    } catch (const std::bad_alloc&) {
      head_.reset();
      actions.failed.push_back({version, kNoMemoryForTables});
    }
  }
}

void SceneReceiver::serve(Announced announced, Actions& actions) {
  SceneNeed need = begin_head(std::move(announced));
  if (refuse_head(need, actions)) return;
  need.codings = kByteCodingsAll;
  // Slaves may have asked for kept chunks before the announcement was here.
  actions.begun.push_back(head_->version);
  actions.need.reserve(actions.need.size() + 1);
  if (head_->lacking.empty()) finish_head(actions);
  actions.need.push_back(std::move(need));
}

SceneNeed SceneReceiver::begin_head(Announced announced) {
  head_ = std::make_unique<Head>();
  head_->version = announced.announce.version;
  head_->index_bytes = announced.announce.index_bytes;
  head_->time_seconds = announced.announce.time_seconds;
  head_->names = std::move(announced.names);
  head_->total_bytes = head_->had_bytes = announced.total_bytes;
  SceneNeed need;
  need.version = head_->version;
  const SceneShelf::Newest newest = shelf_.newest();
  head_->blocks = BlockTable::Editor(newest.blocks);
  head_->blocks.resize(head_->names.size());
  head_->names.for_each_apart(newest.names, [&](std::size_t block) {
    begin_block(static_cast<std::uint32_t>(block), newest, need);
  });
  return need;
}

void SceneReceiver::begin_block(std::uint32_t block, const SceneShelf::Newest& newest,
                                SceneNeed& need) {
  const BlockName& name = head_->names[block];
  if (block < newest.names.size() && newest.names[block] == name) return;  // it is there
  head_->changed.push_back(block);
  if (const SceneBlock* kept = shelf_.block(name.digest, block); kept != nullptr) {
    head_->blocks.edit(block) = *kept;
    return;
  }
  head_->blocks.edit(block) = {};
  head_->had_bytes -= name.size_bytes;
  std::vector<std::uint32_t>& indices = head_->lacking[name.digest];
  if (indices.empty()) {
    need.blocks.push_back(block);
    head_->assemblies.try_emplace(block, name.digest, name.size_bytes);
  }
  indices.push_back(block);
}

// For a slave the estimate counts lacking blocks twice, as bytes, for deltas and relays, and
// decoded; and then the index, of which a peer may say any number.
std::uint64_t SceneReceiver::bytes_to_take(const SceneNeed& need) const {
  const bool is_built = use_ == Use::kBuilt;
  std::uint64_t bytes = 0;
  for (const std::uint32_t block : need.blocks)
    bytes += (is_built ? 2 : 1) * head_->names[block].size_bytes;
  const std::uint64_t index_bytes = is_built ? head_->index_bytes : 0;
  return bytes + std::min(index_bytes, std::numeric_limits<std::uint64_t>::max() - bytes);
}

bool SceneReceiver::refuse_head(const SceneNeed& need, Actions& actions) {
  for (const std::uint32_t i : head_->changed) {
    const BlockBytes& kept = head_->blocks[i].bytes;
    if (!kept || kept->size() == head_->names[i].size_bytes) continue;
    actions.failed.push_back({head_->version, wrong_size_text(i)});
    head_.reset();
    return true;
  }
  const std::uint64_t bytes = bytes_to_take(need);
  const std::optional<std::uint64_t> room = room_ ? room_(bytes) : std::nullopt;
  if (!room || bytes <= *room) return false;
  actions.failed.push_back({head_->version,
                            "the scene needs " + mib_text(bytes) + " of memory " +
                                (use_ == Use::kBuilt ? "here, " : "in the master, ") +
                                mib_text(*room) + " are free",
                            bytes, *room});
  head_.reset();
  return true;
}

bool SceneReceiver::is_past(SceneVersion version) const {
  // Pieces of a version that failed or was retired may still be under way.
  return version < (head_ ? head_->version : newest_announced_ + 1);
}

Status SceneReceiver::list(SceneChunkList list, Actions& actions) {
  if (is_past(list.version)) return Status::ok();
  const auto place = [&] { return "SceneChunkList of block " + std::to_string(list.block); };
  if (!head_ || list.version != head_->version) {
    return Status::data_loss(place() + ": its version was not asked for");
  }
  const auto found = head_->assemblies.find(list.block);
  if (found == head_->assemblies.end() || found->second.has_list()) {
    return Status::data_loss(place() + ": it was not asked for");
  }
  const SceneVersion version = list.version;
  const std::uint64_t block_bytes = found->second.size_bytes();
  try {
    take_list(std::move(list), found->second, actions);
  } catch (const std::bad_alloc&) {
    fail(version, block_bytes, actions);
  }
  return Status::ok();
}

// Throws: std::bad_alloc, and has not finished the block then.
void SceneReceiver::take_list(SceneChunkList list, BlockAssembly& assembly, Actions& actions) {
  if (std::optional<BlockAssembly> part = shelf_.take_part(assembly.digest())) {
    assembly = std::move(*part);
  } else if (!assembly.set_list(std::move(list.chunks))) {
    return fail_head(
        "the list of block " + std::to_string(list.block) + " does not have its digest", actions);
  }
  fill_from_shelf(assembly);
  for (std::uint32_t i = 0; i < assembly.count(); ++i) {
    if (assembly.has(i)) actions.arrived.push_back({list.version, list.block, i});
  }
  if (assembly.is_whole()) {
    finish_block(list.block, actions);
  } else {
    actions.chunk_need.push_back({list.version, list.block, assembly.lacking()});
  }
}

void SceneReceiver::fill_from_shelf(BlockAssembly& assembly) {
  for (std::uint32_t i = 0; i < assembly.count(); ++i) {
    if (assembly.has(i)) continue;
    const auto known = shelf_.chunk(assembly.list()[i]);
    if (known && known->size() == chunk_bytes(assembly.size_bytes(), i))
      assembly.put_checked(i, *known);
  }
}

Status SceneReceiver::chunk(const SceneChunk& chunk, Actions& actions) {
  const auto place = [&] { return "SceneChunk of block " + std::to_string(chunk.block); };
  try {
    switch (take(chunk, actions)) {
      case Verdict::kStored:
      case Verdict::kLate:
        break;
      case Verdict::kNotAskedFor:
        return Status::data_loss(place() + ": it was not asked for");
      case Verdict::kMalformed:
        return Status::data_loss(place() + ": it is not one chunk of the block");
      case Verdict::kWrongDigest:
        fail_head("block " + std::to_string(chunk.block) + " does not have its digest", actions);
        break;
      case Verdict::kNoMemory:
        fail(chunk.version, bytes_of(chunk.block), actions);
        break;
    }
  } catch (const std::bad_alloc&) {
    fail(chunk.version, bytes_of(chunk.block), actions);
  }
  return Status::ok();
}

SceneReceiver::Verdict SceneReceiver::take(const SceneChunk& chunk, Actions& actions) try {
  if (is_past(chunk.version)) return Verdict::kLate;
  if (!head_ || chunk.version != head_->version) return Verdict::kNotAskedFor;
  if (chunk.block >= head_->blocks.size()) return Verdict::kNotAskedFor;
  if (head_->blocks[chunk.block].bytes) return Verdict::kLate;
  const auto found = head_->assemblies.find(chunk.block);
  if (found == head_->assemblies.end() || !found->second.has_list()) return Verdict::kNotAskedFor;
  BlockAssembly& assembly = found->second;
  if (chunk.offset % kSceneChunkBytes != 0 || chunk.offset >= assembly.size_bytes()) {
    return Verdict::kMalformed;
  }
  const auto index = static_cast<std::uint32_t>(chunk.offset / kSceneChunkBytes);
  std::span<const std::byte> bytes = chunk.bytes.bytes;
  std::vector<std::byte> plain;
  if (chunk.coding != ByteCoding::kNone) {
    plain.resize(chunk_bytes(assembly.size_bytes(), index));
    if (!decode_bytes(chunk.coding, bytes, plain).is_ok()) return Verdict::kMalformed;
    bytes = plain;
  }
  if (bytes.size() != chunk_bytes(assembly.size_bytes(), index)) return Verdict::kMalformed;
  actions.arrived.reserve(actions.arrived.size() + 1);  // what is put is told
  switch (assembly.put(index, bytes)) {
    case BlockAssembly::Put::kKnown:
      return Verdict::kLate;
    case BlockAssembly::Put::kWrong:
      return Verdict::kWrongDigest;
    case BlockAssembly::Put::kStored:
      break;
  }
  actions.arrived.push_back({chunk.version, chunk.block, index});
  if (assembly.is_whole()) finish_block(chunk.block, actions);
  return Verdict::kStored;
} catch (const std::bad_alloc&) {
  return Verdict::kNoMemory;  // it may come again
}

void SceneReceiver::finish_block(std::uint32_t block, Actions& actions) {
  try {
    join_block(block);
    if (!head_->lacking.empty()) return;
    finish_head(actions);
  } catch (const std::bad_alloc&) {
    return fail_head(no_memory_text(head_->names[block].size_bytes), actions);
  }
  serve_next(actions);
}

void SceneReceiver::join_block(std::uint32_t block) {
  const auto found = head_->assemblies.find(block);
  const auto lacking = head_->lacking.find(found->second.digest());
  const SceneBlock whole = found->second.finish();
  for (const std::uint32_t index : lacking->second) {
    head_->blocks.edit(index) = whole;
    head_->had_bytes += whole.bytes->size();
  }
  head_->assemblies.erase(found);
  head_->lacking.erase(lacking);
}

// Throws: std::bad_alloc; the head is still there then.
void SceneReceiver::finish_head(Actions& actions) {
  for (const std::uint32_t i : head_->changed) {
    if (head_->blocks[i].bytes->size() == head_->names[i].size_bytes) continue;
    actions.failed.push_back({head_->version, wrong_size_text(i)});
    head_.reset();
    return;
  }
  Complete complete;
  complete.version = head_->version;
  complete.total_bytes = head_->total_bytes;
  complete.scene.time_seconds = head_->time_seconds;
  complete.scene.blocks = head_->blocks.finish();
  actions.complete.reserve(actions.complete.size() + 1);
  shelf_.keep(complete.version, complete.scene, head_->names);
  shelf_.drop_parts();
  actions.complete.push_back(std::move(complete));
  head_.reset();
}

// The chunks and blocks that have come are kept: they may be part of the next version, or of the
// same one in the next session.
void SceneReceiver::break_off_head() {
  try {
    std::vector<BlockAssembly> parts;
    for (auto& [block, assembly] : head_->assemblies) {
      if (assembly.have_count() > 0) parts.push_back(std::move(assembly));
    }
    std::vector<SceneBlock> whole;
    for (const SceneBlock& block : head_->blocks.finish()) {
      if (block.bytes) whole.push_back(block);
    }
    if (!parts.empty() || !whole.empty()) shelf_.put_aside(std::move(whole), std::move(parts));
  } catch (const std::bad_alloc&) {
    shelf_.drop_parts();  // they will travel again
  }
  head_.reset();
}

// The version in work may have ended already, where memory ran out again for the one behind it.
void SceneReceiver::fail(SceneVersion version, std::uint64_t block_bytes, Actions& actions) {
  if (head_ && head_->version == version) fail_head(no_memory_text(block_bytes), actions);
}

std::uint64_t SceneReceiver::bytes_of(std::uint32_t block) const {
  return head_ && block < head_->names.size() ? head_->names[block].size_bytes : 0;
}

void SceneReceiver::fail_head(std::string reason, Actions& actions) {
  actions.failed.push_back({head_->version, std::move(reason)});
  head_.reset();
  serve_next(actions);
}

void SceneReceiver::retire(SceneVersion first_kept, Actions& actions) {
  while (!waiting_.empty() && waiting_.front().announce.version < first_kept) waiting_.pop_front();
  if (head_ && head_->version < first_kept) {
    break_off_head();
    serve_next(actions);
  }
}

void SceneReceiver::reset() {
  waiting_.clear();
  if (head_) break_off_head();
  newest_announced_ = 0;
  newest_blocks_.forget();
  shelf_.forget_versions();
}

std::vector<SceneChunkNeed> SceneReceiver::lacking() const {
  std::vector<SceneChunkNeed> needs;
  if (!head_) return needs;
  for (const auto& [block, assembly] : head_->assemblies) {
    if (assembly.has_list()) {
      needs.push_back({head_->version, block, assembly.lacking()});
    }
  }
  return needs;
}

std::uint64_t SceneReceiver::head_bytes() const {
  std::uint64_t bytes = head_ ? head_->had_bytes : 0;
  if (head_) {
    for (const auto& [block, assembly] : head_->assemblies) bytes += assembly.have_bytes();
  }
  return bytes;
}

SceneReceiver::Holding SceneReceiver::find(SceneVersion version, std::uint32_t block,
                                           std::uint32_t chunk, net::SharedBytes& bytes) const {
  if (version > newest_announced_) return Holding::kNotYet;
  const SceneBlock* whole = nullptr;
  if (const EncodedScene* scene = shelf_.scene(version); scene != nullptr) {
    if (block >= scene->blocks.size()) return Holding::kNever;
    whole = &scene->blocks[block];
  } else if (head_ && head_->version == version) {
    if (block >= head_->blocks.size()) return Holding::kNever;
    if (head_->blocks[block].bytes) whole = &head_->blocks[block];
  } else {
    for (const Announced& announced : waiting_) {
      if (announced.announce.version == version) return Holding::kNotYet;
    }
    return Holding::kNever;
  }
  if (whole != nullptr) {
    if (chunk >= chunk_count(whole->bytes->size())) return Holding::kNever;
    bytes = {whole->bytes, std::span<const std::byte>(*whole->bytes)
                               .subspan(std::size_t{chunk} * kSceneChunkBytes,
                                        chunk_bytes(whole->bytes->size(), chunk))};
    return Holding::kHere;
  }
  const auto found = head_->assemblies.find(block);
  if (found == head_->assemblies.end() || chunk >= found->second.count()) return Holding::kNever;
  if (!found->second.has(chunk)) return Holding::kNotYet;
  bytes = found->second.chunk(chunk);
  return Holding::kHere;
}

}  // namespace tessera::wire
