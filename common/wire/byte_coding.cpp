// SPDX-License-Identifier: Apache-2.0
#include "common/wire/byte_coding.h"

#include <lz4.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>

#include "common/base/check.h"

namespace tessera::wire {
namespace {

constexpr int kZstdLevel = 1;
// The window holds the largest piece; it also bounds the memory that a decoder takes for itself.
constexpr int kZstdWindowLogMax = 20;

struct FreeCoder {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

ZSTD_CCtx* zstd_coder() {
  thread_local const std::unique_ptr<ZSTD_CCtx, FreeCoder> context = [] {
    std::unique_ptr<ZSTD_CCtx, FreeCoder> made(ZSTD_createCCtx());
    ZSTD_CCtx_setParameter(made.get(), ZSTD_c_compressionLevel, kZstdLevel);
    ZSTD_CCtx_setParameter(made.get(), ZSTD_c_windowLog, kZstdWindowLogMax);
    return made;
  }();
  return context.get();
}

ZSTD_DCtx* zstd_decoder() {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeCoder> context = [] {
    std::unique_ptr<ZSTD_DCtx, FreeCoder> made(ZSTD_createDCtx());
    ZSTD_DCtx_setParameter(made.get(), ZSTD_d_windowLogMax, kZstdWindowLogMax);
    return made;
  }();
  return context.get();
}

}  // namespace

const char* coding_name(ByteCoding coding) {
  switch (coding) {
    case ByteCoding::kNone:
      return "none";
    case ByteCoding::kLz4:
      return "lz4";
    case ByteCoding::kZstd:
      return "zstd";
  }
  return "?";
}

bool code_bytes(ByteCoding coding, std::span<const std::byte> plain,
                std::vector<std::byte>& coded) {
  TESSERA_CHECK(plain.size() <= std::size_t{1} << 30);
  if (plain.size() < 2) return false;
  const std::size_t room = plain.size() - 1;  // anything longer is of no use
  coded.resize(room);
  if (coding == ByteCoding::kLz4) {
    const int size = LZ4_compress_default(reinterpret_cast<const char*>(plain.data()),
                                          reinterpret_cast<char*>(coded.data()),
                                          static_cast<int>(plain.size()), static_cast<int>(room));
    coded.resize(static_cast<std::size_t>(std::max(size, 0)));
    return size > 0;
  }
  TESSERA_CHECK(coding == ByteCoding::kZstd);
  const std::size_t size =
      ZSTD_compress2(zstd_coder(), coded.data(), room, plain.data(), plain.size());
  if (ZSTD_isError(size) != 0) return false;
  coded.resize(size);
  return true;
}

Status decode_bytes(ByteCoding coding, std::span<const std::byte> coded,
                    std::span<std::byte> plain) {
  bool is_good = false;
  switch (coding) {
    case ByteCoding::kNone:
      is_good = coded.size() == plain.size();
      if (is_good && !plain.empty()) std::memcpy(plain.data(), coded.data(), plain.size());
      break;
    case ByteCoding::kLz4:
      is_good =
          coded.size() < plain.size() &&
          LZ4_decompress_safe(reinterpret_cast<const char*>(coded.data()),
                              reinterpret_cast<char*>(plain.data()), static_cast<int>(coded.size()),
                              static_cast<int>(plain.size())) == static_cast<int>(plain.size());
      break;
    case ByteCoding::kZstd:
      is_good = coded.size() < plain.size() &&
                ZSTD_decompressDCtx(zstd_decoder(), plain.data(), plain.size(), coded.data(),
                                    coded.size()) == plain.size();
      break;
  }
  if (is_good) return Status::ok();
  return Status::data_loss(std::string("bytes coded with ") + coding_name(coding) +
                           " do not decode to the " + std::to_string(plain.size()) +
                           " bytes they stand for");
}

}  // namespace tessera::wire
