// SPDX-License-Identifier: Apache-2.0
#include "common/net/http_page.h"

#include <algorithm>
#include <list>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/log.h"
#include "common/net/io_thread_asio.h"

namespace tessera::net {
namespace {

using Tcp = asio::ip::tcp;

struct Answer {
  const char* status = "200 OK";
  std::string type = "text/plain";
  std::string body;
};

bool is_alike(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

// Whether this machine calls itself so: localhost or a loopback address, with or without a port.
bool is_loopback_name(std::string_view host) {
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    return end != host.npos && host.substr(1, end - 1) == "::1" &&
           (end + 1 == host.size() || host[end + 1] == ':');
  }
  host = host.substr(0, host.find(':'));
  if (is_alike(host, "localhost")) return true;
  asio::error_code error;
  const auto address = asio::ip::make_address_v4(std::string(host), error);
  return !error && address.is_loopback();
}

// A page of the web that a browser here shows may ask for this one under a name of its own, which
// leads to this address; what such a browser sends as Host is that name. Programs of HTTP/1.0 may
// send none.
bool is_host_ours(std::string_view head) {
  for (std::size_t end = head.find('\n'); end != head.npos; end = head.find('\n')) {
    head.remove_prefix(end + 1);
    const std::string_view line = head.substr(0, head.find('\n'));
    const std::size_t colon = line.find(':');
    if (colon == line.npos || !is_alike(trimmed(line.substr(0, colon)), "host")) continue;
    if (!is_loopback_name(trimmed(line.substr(colon + 1)))) return false;
  }
  return true;
}

// `head`: the request up to its empty line. Its first line and its Host matter.
Answer answer_to(std::string_view head, const HttpPage::Content& content) {
  const std::string_view line = head.substr(0, head.find_first_of("\r\n"));
  const std::size_t method_end = line.find(' ');
  const std::size_t target_end =
      method_end == line.npos ? line.npos : line.find(' ', method_end + 1);
  if (target_end == line.npos || !line.substr(target_end + 1).starts_with("HTTP/1."))
    return {"400 Bad Request", "text/plain", "this speaks HTTP/1.0\n"};
  const std::string_view method = line.substr(0, method_end);
  std::string_view path = line.substr(method_end + 1, target_end - method_end - 1);
  path = path.substr(0, path.find('?'));
  if (!is_host_ours(head))
    return {"403 Forbidden", "text/plain", "this page is asked for by the name localhost\n"};
  if (method != "GET" && method != "HEAD")
    return {"405 Method Not Allowed", "text/plain", "GET is all there is\n"};
  if (path != content.path)
    return {"404 Not Found", "text/plain", "the page here is " + content.path + "\n"};
  return {"200 OK", content.type, content.write()};
}

// State of a page; pending operations keep it alive.
class Server : public std::enable_shared_from_this<Server> {
 public:
  Server(IoThread& io, HttpPage::Content content)
      : io_(io), content_(std::move(content)), acceptor_(context_of(io)) {}

  Status open(const Endpoint& endpoint);
  void accept_next();
  void close();
  std::uint16_t port() const { return port_; }

 private:
  struct Exchange {
    explicit Exchange(Tcp::socket s) : socket(std::move(s)), deadline(socket.get_executor()) {}
    Tcp::socket socket;
    asio::steady_timer deadline;
    std::string request, answer;
    bool is_answered = false;
  };
  using ExchangePtr = std::shared_ptr<Exchange>;

  void begin(Tcp::socket socket);
  bool make_room();
  void answer(const ExchangePtr& exchange);
  // Takes its argument by value: a reference into exchanges_ would not outlive the erasure.
  void end(ExchangePtr exchange);

  IoThread& io_;
  const HttpPage::Content content_;
  Tcp::acceptor acceptor_;
  std::uint16_t port_ = 0;
  std::list<ExchangePtr> exchanges_;  // the oldest first
  bool is_closed_ = false;
};

Status Server::open(const Endpoint& endpoint) {
  asio::error_code error;
  Tcp::resolver resolver(context_of(io_));
  const auto results = resolver.resolve(endpoint.host, std::to_string(endpoint.port), error);
  if (error || results.empty()) {
    return Status::unavailable("cannot listen on " + endpoint.text() +
                               ": the name does not resolve to an address");
  }
  const Tcp::endpoint address = results.begin()->endpoint();
  if (!address.address().is_loopback()) {
    return Status::invalid_argument(endpoint.text() +
                                    " is not loopback, and this page has neither keys nor "
                                    "encryption: give 127.0.0.1:" +
                                    std::to_string(endpoint.port) +
                                    ", and let a proxy or an SSH tunnel carry it further");
  }
  acceptor_.open(address.protocol(), error);
  if (!error) acceptor_.set_option(Tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor_.bind(address, error);
  if (!error) acceptor_.listen(static_cast<int>(HttpPage::kConnectionsMax), error);
  if (error) {
    const char* mend = error == asio::error::address_in_use
                           ? "; stop the other program or choose another port"
                           : "";
    return Status::unavailable("cannot listen on " + endpoint.text() + ": " + error.message() +
                               mend);
  }
  port_ = acceptor_.local_endpoint(error).port();
  return Status::ok();
}

void Server::accept_next() {
  acceptor_.async_accept([self = shared_from_this()](const asio::error_code& error,
                                                     Tcp::socket socket) {
    if (self->is_closed_) return;
    if (!error) {
      self->begin(std::move(socket));
      return self->accept_next();
    }
    // This process is out of descriptors, or the peer left already: pause, then go on.
    auto pause =
        std::make_shared<asio::steady_timer>(context_of(self->io_), std::chrono::milliseconds(100));
    pause->async_wait([self, pause](const asio::error_code&) {
      if (!self->is_closed_) self->accept_next();
    });
  });
}

void Server::begin(Tcp::socket socket) {
  if (!make_room()) return;  // closed with the socket
  auto exchange = std::make_shared<Exchange>(std::move(socket));
  exchanges_.push_back(exchange);
  exchange->deadline.expires_after(HttpPage::kDeadline);
  exchange->deadline.async_wait(
      [self = shared_from_this(), exchange](const asio::error_code& error) {
        if (!error) self->end(exchange);
      });
  asio::async_read_until(
      exchange->socket, asio::dynamic_buffer(exchange->request, HttpPage::kRequestBytesMax),
      "\r\n\r\n",
      [self = shared_from_this(), exchange](const asio::error_code& error, std::size_t) {
        if (error || self->is_closed_) return self->end(exchange);
        self->answer(exchange);
      });
}

// Where all places are taken, the one that has said nothing whole for the longest goes first: who
// connects and is silent keeps nobody out. Returns: false when all are being answered.
bool Server::make_room() {
  if (exchanges_.size() < HttpPage::kConnectionsMax) return true;
  const auto idle = std::find_if(exchanges_.begin(), exchanges_.end(),
                                 [](const ExchangePtr& e) { return !e->is_answered; });
  if (idle == exchanges_.end()) return false;
  end(*idle);
  return true;
}

void Server::answer(const ExchangePtr& exchange) {
  exchange->is_answered = true;
  const Answer answer = answer_to(exchange->request, content_);
  exchange->answer = std::string("HTTP/1.0 ") + answer.status + "\r\nContent-Type: " + answer.type +
                     "\r\nContent-Length: " + std::to_string(answer.body.size()) +
                     "\r\nConnection: close\r\n\r\n";
  if (!exchange->request.starts_with("HEAD ")) exchange->answer += answer.body;
  asio::async_write(exchange->socket, asio::buffer(exchange->answer),
                    [self = shared_from_this(), exchange](const asio::error_code&, std::size_t) {
                      self->end(exchange);
                    });
}

void Server::end(ExchangePtr exchange) {
  if (exchanges_.remove(exchange) == 0) return;
  asio::error_code ignored;
  exchange->deadline.cancel();
  exchange->socket.shutdown(Tcp::socket::shutdown_both, ignored);
  exchange->socket.close(ignored);
}

void Server::close() {
  is_closed_ = true;
  asio::error_code ignored;
  acceptor_.close(ignored);
  while (!exchanges_.empty()) end(*exchanges_.begin());
}

class ServedPage final : public HttpPage {
 public:
  explicit ServedPage(std::shared_ptr<Server> server) : server_(std::move(server)) {}
  ~ServedPage() override { server_->close(); }
  std::uint16_t port() const override { return server_->port(); }

 private:
  std::shared_ptr<Server> server_;
};

}  // namespace

Result<std::unique_ptr<HttpPage>> HttpPage::open(IoThread& io, const Endpoint& endpoint,
                                                 Content content) {
  auto server = std::make_shared<Server>(io, std::move(content));
  TESSERA_RETURN_IF_ERROR(server->open(endpoint));
  server->accept_next();
  return std::unique_ptr<HttpPage>(std::make_unique<ServedPage>(std::move(server)));
}

}  // namespace tessera::net
