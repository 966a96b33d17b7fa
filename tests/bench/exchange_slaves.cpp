// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/exchange_slaves.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/net/cluster_authority.h"
#include "common/net/crc32c.h"
#include "common/net/record_head.h"
#include "common/scene/scene_summary.h"
#include "common/wire/codec.h"
#include "tests/bench/exchange_socket.h"

namespace tessera::bench {
namespace {

// CRC-32C of a header that changes followed by a payload that does not, for the price of the
// header: the checksum after n more bytes is linear in the one before them.
class ChecksumBeforePayload {
 public:
  explicit ChecksumBeforePayload(std::span<const std::byte> payload)
      : of_zero_(net::crc32c(0, payload)) {
    for (std::uint32_t byte = 0; byte < 4; ++byte) {
      for (std::uint32_t value = 0; value < 256; ++value)
        table_[byte][value] = net::crc32c(value << 8 * byte, payload) ^ of_zero_;
    }
  }
  std::uint32_t after(std::uint32_t crc) const {
    return of_zero_ ^ table_[0][crc & 255] ^ table_[1][crc >> 8 & 255] ^
           table_[2][crc >> 16 & 255] ^ table_[3][crc >> 24];
  }

 private:
  const std::uint32_t of_zero_;
  std::uint32_t table_[4][256];
};

struct Link {
  BenchSocket socket;
  std::vector<std::byte> in;
  std::map<FrameId, SceneVersion> versions;  // of the frames begun

  explicit Link(BenchSocket s) : socket(std::move(s)) {}
};

class Peers {
 public:
  Peers(const ExchangePeers& options, std::uint16_t port)
      : options_(options), port_(port), pixels_(kResultBytes, std::byte{0x3c}), checksum_(pixels_) {
    if (!options_.keys_folder.empty()) {
      auto opened = net::ClusterAuthority::open(options_.keys_folder);
      TESSERA_CHECK(opened.is_ok());
      authority_.emplace(std::move(*opened));
    }
  }

  void run() {
    for (int i = 0; i < options_.connections; ++i) {
      options_.is_bare ? add_bare() : add_slave(i);
      loop_.run_once(0);  // slaves that are connected keep their links alive
    }
    while (true) loop_.run_once(1000);
  }

 private:
  BenchSocket dial(int index) {
    BenchSocket socket = BenchSocket::connect(port_);
    if (authority_) {
      const auto pair = authority_->issue({"slave", "slave-" + std::to_string(index)}, {1, 0});
      socket.start_tls(pair, authority_->certificate());
    }
    return socket;
  }

  void add_bare() {
    Link& link = links_.emplace_back(BenchSocket::connect(port_));
    loop_.add(link.socket, [this, &link] { answer_requests(link); });
  }

  void add_slave(int index) {
    wire::Hello hello;
    hello.name = "slave-" + std::to_string(index);
    hello.threads = static_cast<std::uint32_t>(options_.threads);
    hello.isas = isa_bit(Isa::kScalar);
    hello.build_id = "bench";
    Link& tile = links_.emplace_back(dial(index));
    say(tile, hello);
    tile.socket.flush();
    const auto welcome = hear<wire::Welcome>(tile);
    Link& scene = links_.emplace_back(dial(index));
    say(scene, wire::Join{welcome.version, welcome.session, welcome.token});
    scene.socket.flush();
    hear<wire::Joined>(scene);
    for (Link* link : {&tile, &scene}) {
      loop_.add(link->socket, [this, link] { answer_records(*link); });
      answer_records(*link);  // records that came with Joined
    }
  }

  template <typename M>
  M hear(Link& link) {
    while (true) {
      if (auto record = take_record(link)) {
        auto message = wire::decode(std::move(*record));
        TESSERA_CHECK(message.is_ok());
        if (auto* wanted = std::get_if<M>(&*message)) return std::move(*wanted);
        continue;
      }
      TESSERA_CHECK(link.socket.read_into(link.in));
    }
  }

  void say(Link& link, wire::Message message) {
    const net::Record record = wire::encode(std::move(message));
    put(link, record, record.payload.bytes,
        net::crc32c(net::crc32c(0, std::as_bytes(std::span(record.header))), record.payload.bytes));
  }

  void put(Link& link, const net::Record& record, std::span<const std::byte> payload,
           std::uint32_t checksum) {
    net::RecordHead head;
    head.type = record.type;
    head.header_bytes = static_cast<std::uint32_t>(record.header.size());
    head.payload_bytes = static_cast<std::uint32_t>(payload.size());
    if (!authority_) head.checksum = checksum;
    link.socket.put(net::encode_head(head));
    link.socket.put(std::as_bytes(std::span(record.header)));
    link.socket.put(payload);
  }

  static std::optional<net::ReceivedRecord> take_record(Link& link) {
    std::size_t used = 0;
    auto record = record_at(link, used);
    link.in.erase(link.in.begin(), link.in.begin() + static_cast<std::ptrdiff_t>(used));
    return record;
  }

  // Takes the record at `used` of the input and moves `used` behind it. None: it has not arrived
  // whole.
  static std::optional<net::ReceivedRecord> record_at(Link& link, std::size_t& used) {
    const std::span<const std::byte> rest = std::span(link.in).subspan(used);
    if (rest.size() < net::kRecordHeadBytes) return std::nullopt;
    net::RecordRefusal refusal{};
    const auto head =
        net::decode_head(rest.first<net::kRecordHeadBytes>(), wire::session_limits(), refusal);
    TESSERA_CHECK(head.has_value());
    const std::size_t bytes = net::kRecordHeadBytes + head->header_bytes + head->payload_bytes;
    if (rest.size() < bytes) return std::nullopt;
    net::ReceivedRecord record;
    record.type = head->type;
    const auto header = rest.subspan(net::kRecordHeadBytes, head->header_bytes);
    record.header.assign(reinterpret_cast<const char*>(header.data()), header.size());
    const auto payload =
        rest.subspan(net::kRecordHeadBytes + head->header_bytes, head->payload_bytes);
    record.payload.assign(payload.begin(), payload.end());
    used += bytes;
    return record;
  }

  void answer_records(Link& link) {
    if (!link.socket.read_into(link.in)) std::exit(0);  // the master has ended
    std::size_t used = 0;
    while (auto record = record_at(link, used)) {
      auto message = wire::decode(std::move(*record));
      TESSERA_CHECK(message.is_ok());
      answer(link, *message);
    }
    link.in.erase(link.in.begin(), link.in.begin() + static_cast<std::ptrdiff_t>(used));
    link.socket.flush();
  }

  void answer(Link& link, const wire::Message& message) {
    if (const auto* lease = std::get_if<wire::TileLease>(&message)) return send_tile(link, *lease);
    if (const auto* ping = std::get_if<wire::Ping>(&message))
      return say(link, wire::Pong{ping->sent_ns});
    if (const auto* begin = std::get_if<wire::FrameBegin>(&message)) {
      link.versions[begin->frame] = begin->version;
    } else if (const auto* end = std::get_if<wire::FrameEnd>(&message)) {
      link.versions.erase(end->frame);
    } else if (const auto* scene = std::get_if<wire::SceneAnnounce>(&message)) {
      say(link, wire::SceneNeed{scene->version, {}});
      say(link, wire::SceneBuilt{scene->version, 0.001, 1, scene_digest(scene->digests)});
    }
  }

  void send_tile(Link& link, const wire::TileLease& lease) {
    wire::TileResult result;
    result.frame = lease.frame;
    result.version = link.versions[lease.frame];
    result.tile = lease.tile;
    result.attempt = lease.attempt;
    result.seconds = 1e-3;
    result.rays.primary = 1024;
    const net::Record record = wire::encode(std::move(result));
    put(link, record, pixels_,
        checksum_.after(net::crc32c(0, std::as_bytes(std::span(record.header)))));
  }

  void answer_requests(Link& link) {
    if (!link.socket.read_into(link.in)) std::exit(0);
    const std::size_t requests = link.in.size() / kRequestBytes;
    for (std::size_t i = 0; i < requests; ++i) link.socket.put(pixels_);
    link.in.erase(link.in.begin(),
                  link.in.begin() + static_cast<std::ptrdiff_t>(requests * kRequestBytes));
    link.socket.flush();
  }

  const ExchangePeers options_;
  const std::uint16_t port_;
  const std::vector<std::byte> pixels_;
  const ChecksumBeforePayload checksum_;
  std::optional<net::ClusterAuthority> authority_;
  std::deque<Link> links_;  // addresses stay
  BenchLoop loop_;
};

[[noreturn]] void run_child(const ExchangePeers& options, int port_pipe) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  signal(SIGPIPE, SIG_IGN);
  std::uint16_t port = 0;
  if (::read(port_pipe, &port, sizeof(port)) != sizeof(port)) _exit(0);
  Peers(options, port).run();
  _exit(0);
}

}  // namespace

ExchangeProcess::ExchangeProcess(const ExchangePeers& peers) {
  int ends[2];
  TESSERA_CHECK_EQ(::pipe2(ends, O_CLOEXEC), 0);
  std::fflush(nullptr);
  child_ = ::fork();
  TESSERA_CHECK_GE(child_, 0);
  if (child_ == 0) {
    ::close(ends[1]);
    run_child(peers, ends[0]);
  }
  ::close(ends[0]);
  port_pipe_ = ends[1];
}

ExchangeProcess::~ExchangeProcess() {
  ::close(port_pipe_);
  ::kill(child_, SIGKILL);
  ::waitpid(child_, nullptr, 0);
}

void ExchangeProcess::connect_to(std::uint16_t port) {
  TESSERA_CHECK_EQ(::write(port_pipe_, &port, sizeof(port)), ssize_t{sizeof(port)});
}

double ExchangeProcess::cpu_seconds() const {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(child_, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace tessera::bench
