// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/common_cause.h"

#include <algorithm>

namespace tessera::master {

bool CommonCause::lost(LossKind kind, std::size_t left, TimePoint now) {
  losses_.push_back({kind, now});
  while (losses_.size() > kLossesMax || now - losses_.front().at > together_) losses_.pop_front();
  const bool is_of_one_kind = std::all_of(losses_.begin(), losses_.end(),
                                          [kind](const Loss& loss) { return loss.kind == kind; });
  text_.clear();
  if (left > 0 || kind == LossKind::kOther || !is_of_one_kind) return false;
  const std::size_t count = losses_.size();
  const std::string who =
      count == 1 ? "the only slave" : "all " + std::to_string(count) + " slaves";
  const char* const where =
      "; look at this master's own network link, and at what stands before its port";
  text_ = who + (count == 1 ? " fell silent" : " fell silent at once") +
          (kind == LossKind::kSilent
               ? ": nothing reaches this master"
               : ", and their packets come: nothing that this master sends arrives") +
          where;
  return true;
}

void CommonCause::joined() {
  losses_.clear();
  text_.clear();
}

}  // namespace tessera::master
