// SPDX-License-Identifier: Apache-2.0
// The page over HTTP gives right answers, and damage, haste and crowds leave it standing.
#include "common/net/http_page.h"
#include "common/net/connector.h"

#include <gtest/gtest.h>

#include <asio.hpp>
#include <memory>
#include <string>
#include <vector>

namespace tessera::net {
namespace {

class HttpPageTest : public ::testing::Test {
 protected:
  HttpPageTest() {
    HttpPage::Content content{"/metrics", "text/plain; version=0.0.4",
                              [this] { return "page " + std::to_string(++written_) + "\n"; }};
    io_.run_and_wait([&] {
      auto page = HttpPage::open(io_, {"127.0.0.1", 0}, std::move(content));
      ASSERT_TRUE(page.is_ok()) << page.status().message();
      page_ = std::move(*page);
      port_ = page_->port();
    });
  }
  ~HttpPageTest() override {
    io_.run_and_wait([&] { page_.reset(); });
  }

  std::unique_ptr<asio::ip::tcp::socket> connect() {
    auto socket = std::make_unique<asio::ip::tcp::socket>(context_);
    socket->connect({asio::ip::make_address("127.0.0.1"), port_});
    return socket;
  }
  static std::string rest_of(asio::ip::tcp::socket& socket) {
    std::string all;
    asio::error_code end;
    asio::read(socket, asio::dynamic_buffer(all), end);
    return all;
  }
  std::string ask(const std::string& request) {
    auto socket = connect();
    asio::error_code ignored;
    asio::write(*socket, asio::buffer(request), ignored);
    return rest_of(*socket);
  }

  IoThread io_{"page"};
  std::unique_ptr<HttpPage> page_;
  std::uint16_t port_ = 0;
  int written_ = 0;  // io thread
  asio::io_context context_;
};

TEST_F(HttpPageTest, GivesTheNewestPage) {
  EXPECT_EQ(ask("GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n"),
            "HTTP/1.0 200 OK\r\nContent-Type: text/plain; version=0.0.4\r\nContent-Length: 7\r\n"
            "Connection: close\r\n\r\npage 1\n");
  EXPECT_TRUE(ask("GET /metrics?x=1 HTTP/1.0\r\n\r\n").ends_with("page 2\n"));
}

TEST_F(HttpPageTest, AnswersTheHeadAlone) {
  const std::string answer = ask("HEAD /metrics HTTP/1.0\r\n\r\n");
  EXPECT_TRUE(answer.starts_with("HTTP/1.0 200 OK"));
  EXPECT_TRUE(answer.ends_with("\r\n\r\n"));
}

TEST_F(HttpPageTest, RefusesWhatItDoesNotHave) {
  EXPECT_TRUE(ask("GET / HTTP/1.0\r\n\r\n").starts_with("HTTP/1.0 404"));
  EXPECT_TRUE(ask("POST /metrics HTTP/1.0\r\n\r\n").starts_with("HTTP/1.0 405"));
  EXPECT_TRUE(ask("TSSR\x01\r\n\r\n").starts_with("HTTP/1.0 400"));
  EXPECT_TRUE(ask("\r\n\r\n").starts_with("HTTP/1.0 400"));
  EXPECT_EQ(written_, 0);
}

TEST_F(HttpPageTest, ClosesOnAnEndlessRequest) {
  auto socket = connect();
  const std::string piece(1024, 'a');
  asio::error_code error;
  for (int i = 0; i < 10'000 && !error; ++i) asio::write(*socket, asio::buffer(piece), error);
  EXPECT_TRUE(error);
  EXPECT_TRUE(ask("GET /metrics HTTP/1.0\r\n\r\n").ends_with("page 1\n"));
}

TEST_F(HttpPageTest, IdleOnesKeepNobodyOutAndTheOldestGoesFirst) {
  std::vector<std::unique_ptr<asio::ip::tcp::socket>> idle;
  for (std::size_t i = 0; i < HttpPage::kConnectionsMax; ++i) idle.push_back(connect());
  asio::write(*idle[1], asio::buffer(std::string("GET /metr")));
  EXPECT_TRUE(ask("GET /metrics HTTP/1.0\r\n\r\n").ends_with("page 1\n"));
  EXPECT_EQ(rest_of(*idle[0]), "") << "closed";
  asio::write(*idle[1], asio::buffer(std::string("ics HTTP/1.0\r\n\r\n")));
  EXPECT_TRUE(rest_of(*idle[1]).ends_with("page 2\n"));
  for (int i = 0; i < 100; ++i) idle.push_back(connect());
  EXPECT_TRUE(ask("GET /metrics HTTP/1.0\r\n\r\n").ends_with("page 3\n"));
}

TEST_F(HttpPageTest, AnswersOnlyForThisMachinesNames) {
  const auto asked_for = [this](const std::string& host) {
    return ask("GET /metrics HTTP/1.1\r\nAccept: */*\r\n" + host + "\r\n\r\n");
  };
  for (const char* host :
       {"Host: localhost", "host:LocalHost:7401", "HOST:  127.0.0.1:7401 ", "Host: 127.9.9.9",
        "Host: [::1]", "Host: [::1]:80", "X-Host: evil.example"})
    EXPECT_TRUE(asked_for(host).starts_with("HTTP/1.0 200")) << host;
  const int written = written_;
  for (const char* host :
       {"Host: evil.example", "Host: evil.example:7401", "Host: localhost.evil.example",
        "Host:", "Host: 10.0.0.1", "Host: 127.0.0.1.evil.example", "Host: [::2]", "Host: [::1",
        "Host: [::1]x", "Host: localhost\r\nHost: evil.example", "Host : evil.example"})
    EXPECT_TRUE(asked_for(host).starts_with("HTTP/1.0 403")) << host;
  EXPECT_EQ(written_, written);
}

TEST_F(HttpPageTest, ListensOnLoopbackAlone) {
  IoThread io("other");
  io.run_and_wait([&] {
    for (const char* host : {"0.0.0.0", "192.0.2.1", "::"}) {
      const auto page = HttpPage::open(io, {host, 0}, {"/", "", [] { return std::string(); }});
      ASSERT_FALSE(page.is_ok()) << host;
      EXPECT_EQ(page.status().code(), StatusCode::kInvalidArgument);
      EXPECT_NE(page.status().message().find("is not loopback"), std::string::npos);
    }
    const auto taken = HttpPage::open(io, {"127.0.0.1", port_}, {"/", "", [] { return ""; }});
    ASSERT_FALSE(taken.is_ok());
    EXPECT_NE(taken.status().message().find("choose another port"), std::string::npos);
  });
}

// Sanitizers and memory checkers look at what the page touches when it goes.
TEST_F(HttpPageTest, GoesWhileOthersAreAsking) {
  std::vector<std::unique_ptr<asio::ip::tcp::socket>> sockets;
  for (int i = 0; i < 3; ++i) {
    sockets.push_back(connect());
    asio::write(*sockets.back(), asio::buffer(std::string("GET /metr")));
  }
  EXPECT_FALSE(ask("GET /metrics HTTP/1.0\r\n\r\n").empty()) << "the others have come before";
  io_.run_and_wait([&] { page_.reset(); });
  for (const auto& socket : sockets) EXPECT_EQ(rest_of(*socket), "");
}

}  // namespace
}  // namespace tessera::net
