// SPDX-License-Identifier: Apache-2.0
// Codes the bytes of a scene chunk where that pays, and tells the chooser how it went.
// Threads. The chooser's owner.
#pragma once

#include "common/wire/codec_chooser.h"
#include "common/wire/messages.h"

namespace tessera::wire {

// Requires: the chunk is plain.
void code_chunk(CodecChooser& chooser, ByteCodingMask allowed, SceneChunk& chunk);

}  // namespace tessera::wire
