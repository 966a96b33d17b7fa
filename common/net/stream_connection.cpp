// SPDX-License-Identifier: Apache-2.0
#include "common/net/stream_connection.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "common/base/limits.h"
#include "common/net/crc32c.h"
#include "common/net/record_head.h"
#include "common/net/send_queue.h"

namespace tessera::net {
namespace {

constexpr std::size_t kInputBufferBytes = 64 * 1024;
// A record up to this size goes to its owner by way of the input buffer, so that one call reads
// many; the payload of a longer one is read straight into its own.
constexpr std::size_t kBufferedRecordBytesMax = 32 * 1024;
static_assert(kBufferedRecordBytesMax + kRecordHeadBytes <= kInputBufferBytes);
// As long as no more than this waits, it is written at once, without a round of the loop. More is
// left to the loop, so that a sender of bulk data gives way to the others.
constexpr std::uint64_t kWriteNowBytesMax = 64 * 1024;
// A started record must be complete within the time after which a silent peer is dead (this one, as
// long as nothing else was said), plus its size over the slowest supported link.
constexpr std::chrono::milliseconds kRecordGrace{kHeartbeatMs * (kHeartbeatsMissedMax + 1)};
constexpr std::uint64_t kSlowestBytesPerSecond = 8 * 1024;  // below 100 kbit/s

std::uint32_t checksum_of(const std::string& header, std::span<const std::byte> payload) {
  return crc32c(crc32c(0, std::as_bytes(std::span(header))), payload);
}

// The state behind a Connection; kept alive by pending stream operations.
class Core : public std::enable_shared_from_this<Core> {
 public:
  Core(IoThread& io, std::unique_ptr<ByteStream> stream, PeerIdentity peer)
      : io_(io),
        stream_(std::move(stream)),
        peer_(std::move(peer)),
        deadline_timer_(context_of(io)),
        grace_(context_of(io)) {}

  void start(ConnectionCallbacks callbacks, const RecordLimits& limits) {
    callbacks_ = std::move(callbacks);
    limits_ = limits;
    input_.resize(kInputBufferBytes);
    read_more();
  }
  void set_limits(const RecordLimits& limits) { limits_ = limits; }
  void set_record_grace(std::chrono::milliseconds grace) { record_grace_ = grace; }
  void send(Record record);
  void close(std::chrono::milliseconds grace);
  void end(Status status);

  IoThread& io() { return io_; }
  const PeerIdentity& peer() const { return peer_; }
  std::uint64_t queue_bytes() const { return queue_.bytes(); }
  std::uint64_t bytes_sent() const { return bytes_sent_; }
  LinkCounters link_counters() const;
  std::uint64_t bytes_received() const { return bytes_received_; }
  std::chrono::steady_clock::time_point last_received() const {
    return std::max(last_received_, stream_->last_heard());
  }
  std::chrono::steady_clock::time_point last_sent() const { return last_sent_; }

 private:
  bool is_open() const { return state_ == State::kOpen; }
  void read_more();
  void on_input(std::size_t bytes);
  bool take_record();
  void read_rest_of_payload(std::size_t have);
  void deliver();
  void arm_deadline(std::uint64_t bytes);
  void set_deadline_timer();
  void flush();
  void on_written(const asio::error_code& error, std::size_t bytes);
  void discard_until_end();
  void shut();
  Status status_of(const asio::error_code& error) const;

  enum class State { kOpen, kClosing, kClosed };

  IoThread& io_;
  std::unique_ptr<ByteStream> stream_;
  const PeerIdentity peer_;
  ConnectionCallbacks callbacks_;
  RecordLimits limits_{};
  std::chrono::milliseconds record_grace_ = kRecordGrace;
  State state_ = State::kOpen;

  std::vector<std::byte> input_;
  std::size_t input_begin_ = 0, input_end_ = 0;
  std::optional<RecordHead> head_;  // of the record in work
  ReceivedRecord incoming_;
  bool has_deadline_ = false;
  std::chrono::steady_clock::time_point deadline_;
  asio::steady_timer deadline_timer_;
  bool is_deadline_timer_set_ = false;

  SendQueue queue_;
  std::vector<asio::const_buffer> parts_;  // of the write in progress, or the next
  bool is_writing_ = false;                // a write is in the loop's hands
  bool is_corked_ = false;                 // records are being handed on; answers wait
  bool was_above_low_ = false;
  asio::steady_timer grace_;

  std::uint64_t bytes_sent_ = 0, bytes_received_ = 0;
  std::chrono::steady_clock::time_point last_received_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_sent_ = last_received_;
};

void Core::send(Record record) {
  if (!is_open()) return;
  RecordHead head;
  head.type = record.type;
  head.header_bytes = static_cast<std::uint32_t>(record.header.size());
  head.payload_bytes = static_cast<std::uint32_t>(record.payload.bytes.size());
  if (stream_->needs_checksum()) head.checksum = checksum_of(record.header, record.payload.bytes);
  const std::uint64_t bytes = kRecordHeadBytes + head.header_bytes + head.payload_bytes;
  if (queue_.bytes() + bytes > kSendQueueBytesMax) {
    io_.post([self = shared_from_this()] {
      self->end(
          Status::resource_exhausted("the peer takes data too slowly; its send queue is full"));
    });
    return;
  }
  queue_.push(encode_head(head), std::move(record));
  was_above_low_ = was_above_low_ || queue_.bytes() > kSendQueueLowBytes;
  if (!is_corked_) flush();
}

void Core::flush() {
  while (!is_writing_ && !queue_.is_empty()) {
    const std::size_t bytes = queue_.gather(parts_);
    last_sent_ = std::chrono::steady_clock::now();
    const std::size_t written =
        queue_.bytes() <= kWriteNowBytesMax ? stream_->write_now(parts_) : 0;
    bytes_sent_ += written;
    queue_.take(written);
    if (written == bytes) continue;
    if (written > 0) queue_.gather(parts_);
    is_writing_ = true;
    stream_->write_all(
        parts_, [self = shared_from_this()](const asio::error_code& error, std::size_t more) {
          self->on_written(error, more);
        });
  }
  if (queue_.is_empty() && state_ == State::kClosing) stream_->shutdown_send();
}

void Core::on_written(const asio::error_code& error, std::size_t bytes) {
  is_writing_ = false;
  if (state_ == State::kClosed) return;
  bytes_sent_ += bytes;
  queue_.take(bytes);
  if (error) return state_ == State::kClosing ? shut() : end(status_of(error));
  flush();
  if (is_open() && was_above_low_ && queue_.bytes() < kSendQueueLowBytes) {
    was_above_low_ = false;
    if (callbacks_.on_drained) callbacks_.on_drained();
  }
}

LinkCounters Core::link_counters() const {
  LinkCounters counters;
  if (state_ == State::kOpen) counters = stream_->tcp_counters();
  if (counters.busy.count() == 0) counters.bytes_moved = bytes_sent_;
  counters.queue_bytes = queue_.bytes();
  return counters;
}

void Core::read_more() {
  if (input_begin_ > 0) {
    std::memmove(input_.data(), input_.data() + input_begin_, input_end_ - input_begin_);
    input_end_ -= input_begin_;
    input_begin_ = 0;
  }
  stream_->read_some(std::span(input_).subspan(input_end_),
                     [self = shared_from_this()](const asio::error_code& error, std::size_t bytes) {
                       if (self->state_ == State::kClosed) return;
                       if (self->state_ == State::kClosing)
                         return error ? self->shut() : self->discard_until_end();
                       if (error) return self->end(self->status_of(error));
                       self->on_input(bytes);
                     });
}

void Core::on_input(std::size_t bytes) {
  bytes_received_ += bytes;
  last_received_ = std::chrono::steady_clock::now();
  input_end_ += bytes;
  // Answers to all that came leave in one write.
  is_corked_ = true;
  bool wants_more = false;
  while (is_open() && !wants_more) wants_more = !take_record();
  is_corked_ = false;
  if (is_open()) flush();
  if (state_ == State::kClosing && !wants_more) discard_until_end();
}

// Takes one record from the input buffer, or arranges for more input. Returns: whether to look for
// another.
bool Core::take_record() {
  std::size_t available = input_end_ - input_begin_;
  if (!head_) {
    if (available < kRecordHeadBytes) {
      if (available > 0) arm_deadline(kRecordHeadBytes);
      read_more();
      return false;
    }
    RecordRefusal refusal{};
    const std::span<const std::byte, kRecordHeadBytes> head(input_.data() + input_begin_,
                                                            kRecordHeadBytes);
    head_ = decode_head(head, limits_, refusal);
    if (!head_) {
      end(Status::data_loss(refusal_of(head, refusal)));
      return false;
    }
    has_deadline_ = false;  // that was the head's; the rest has its own
    input_begin_ += kRecordHeadBytes;
    available -= kRecordHeadBytes;
    if (head_->header_bytes > kInputBufferBytes - kRecordHeadBytes) {
      end(Status::data_loss(refusal_text(RecordRefusal::kHeaderTooLong)));
      return false;
    }
  }
  const std::uint64_t rest = std::uint64_t{head_->header_bytes} + head_->payload_bytes;
  if (available < (rest <= kBufferedRecordBytesMax ? rest : head_->header_bytes)) {
    arm_deadline(rest);
    read_more();
    return false;
  }
  const std::byte* const at = input_.data() + input_begin_;
  incoming_.type = head_->type;
  incoming_.header.assign(reinterpret_cast<const char*>(at), head_->header_bytes);
  const std::size_t have =
      std::min<std::size_t>(available - head_->header_bytes, head_->payload_bytes);
  const std::byte* const payload = at + head_->header_bytes;
  incoming_.payload.assign(payload, payload + have);
  input_begin_ += head_->header_bytes + have;
  if (have < head_->payload_bytes) {
    incoming_.payload.resize(head_->payload_bytes);
    read_rest_of_payload(have);
    return false;
  }
  deliver();
  return true;
}

// Reads straight into the record's own buffer.
void Core::read_rest_of_payload(std::size_t have) {
  if (have == 0 || !has_deadline_) arm_deadline(head_->payload_bytes);
  stream_->read_some(
      std::span(incoming_.payload).subspan(have),
      [self = shared_from_this(), have](const asio::error_code& error, std::size_t bytes) {
        if (self->state_ == State::kClosed) return;
        if (self->state_ == State::kClosing)
          return error ? self->shut() : self->discard_until_end();
        if (error) return self->end(self->status_of(error));
        self->bytes_received_ += bytes;
        self->last_received_ = std::chrono::steady_clock::now();
        if (have + bytes < self->incoming_.payload.size())
          return self->read_rest_of_payload(have + bytes);
        self->deliver();
        self->on_input(0);
      });
}

void Core::deliver() {
  has_deadline_ = false;
  const RecordHead head = *std::exchange(head_, std::nullopt);
  ReceivedRecord record = std::exchange(incoming_, {});
  if (stream_->needs_checksum() && checksum_of(record.header, record.payload) != head.checksum) {
    return end(Status::data_loss(refusal_text(RecordRefusal::kChecksum)));
  }
  callbacks_.on_record(std::move(record));
}

// Records come by the thousand and deadlines hardly ever pass. So the timer stays as it is set as
// long as that is early enough, and is set again when it has fired.
void Core::arm_deadline(std::uint64_t bytes) {
  if (has_deadline_) return;
  has_deadline_ = true;
  deadline_ = std::chrono::steady_clock::now() + record_grace_ +
              std::chrono::milliseconds(1000 * bytes / kSlowestBytesPerSecond);
  if (is_deadline_timer_set_ && deadline_timer_.expiry() <= deadline_) return;
  set_deadline_timer();
}

void Core::set_deadline_timer() {
  is_deadline_timer_set_ = true;
  deadline_timer_.expires_at(deadline_);
  deadline_timer_.async_wait([self = shared_from_this()](const asio::error_code& error) {
    if (error) return;  // the timer was set anew, or the connection shut
    self->is_deadline_timer_set_ = false;
    if (!self->has_deadline_ || !self->is_open()) return;
    if (std::chrono::steady_clock::now() < self->deadline_) return self->set_deadline_timer();
    self->end(Status::deadline_exceeded("a started record was not completed in time"));
  });
}

void Core::discard_until_end() {
  input_begin_ = input_end_ = 0;
  read_more();
}

void Core::close(std::chrono::milliseconds grace) {
  if (!is_open()) return;
  flush();
  if (grace.count() == 0) return shut();
  state_ = State::kClosing;
  io_.post([self = shared_from_this()] { self->callbacks_ = {}; });  // a callback may be running
  if (input_.empty()) {  // never started: read to see the peer's end
    input_.resize(kInputBufferBytes);
    read_more();
  }
  if (queue_.is_empty()) stream_->shutdown_send();
  grace_.expires_after(grace);
  grace_.async_wait([self = shared_from_this()](const asio::error_code& error) {
    if (!error) self->shut();
  });
}

void Core::shut() {
  if (state_ == State::kClosed) return;
  state_ = State::kClosed;
  deadline_timer_.cancel();
  grace_.cancel();
  stream_->close();
  io_.post([self = shared_from_this()] { self->callbacks_ = {}; });
}

void Core::end(Status status) {
  if (!is_open()) return;
  const auto on_closed = callbacks_.on_closed;
  shut();
  if (on_closed) on_closed(std::move(status));
}

Status Core::status_of(const asio::error_code& error) const {
  if (const std::string alert = certificate_alert_text(error); !alert.empty())
    return Status::permission_denied("the peer refused our certificate, which " + alert);
  if (error.category() == asio::error::get_ssl_category())
    return Status::data_loss("the encrypted link broke: " + error.message());
  if (error == asio::error::eof || error == asio::ssl::error::stream_truncated ||
      error == asio::error::connection_reset || error == asio::error::broken_pipe) {
    return Status::unavailable("the peer closed the connection");
  }
  return Status::unavailable(error.message());
}

class CoreConnection final : public Connection {
 public:
  explicit CoreConnection(std::shared_ptr<Core> core) : core_(std::move(core)) {}
  ~CoreConnection() override { core_->close(std::chrono::milliseconds(0)); }

  void start(ConnectionCallbacks callbacks, const RecordLimits& limits) override {
    core_->start(std::move(callbacks), limits);
  }
  void set_limits(const RecordLimits& limits) override { core_->set_limits(limits); }
  void set_record_grace(std::chrono::milliseconds grace) override {
    core_->set_record_grace(grace);
  }
  void send(Record record) override { core_->send(std::move(record)); }
  std::uint64_t queue_bytes() const override { return core_->queue_bytes(); }
  void close(std::chrono::milliseconds grace) override { core_->close(grace); }
  const PeerIdentity& peer() const override { return core_->peer(); }
  std::uint64_t bytes_sent() const override { return core_->bytes_sent(); }
  std::uint64_t bytes_received() const override { return core_->bytes_received(); }
  LinkCounters link_counters() const override { return core_->link_counters(); }
  std::chrono::steady_clock::time_point last_received() const override {
    return core_->last_received();
  }
  std::chrono::steady_clock::time_point last_sent() const override { return core_->last_sent(); }
  void end_soon(Status why) override {
    core_->io().post([weak = std::weak_ptr(core_), why = std::move(why)] {
      if (const std::shared_ptr<Core> core = weak.lock()) core->end(why);
    });
  }

 private:
  std::shared_ptr<Core> core_;
};

}  // namespace

ConnectionPtr make_connection(IoThread& io, std::unique_ptr<ByteStream> stream, PeerIdentity peer) {
  return std::make_shared<CoreConnection>(
      std::make_shared<Core>(io, std::move(stream), std::move(peer)));
}

}  // namespace tessera::net
