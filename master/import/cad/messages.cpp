// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/messages.h"

#include <fcntl.h>
#include <unistd.h>

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <cstdio>
#include <iostream>
#include <utility>

namespace tessera::import::cad {
namespace {

constexpr std::size_t kLinesMax = 100'000;

class Collector : public Message_Printer {
 public:
  explicit Collector(std::vector<std::string>& lines) : lines_(lines) {}

 private:
  void send(const TCollection_AsciiString& text, const Message_Gravity gravity) const override {
    if (gravity < Message_Warning || lines_.size() >= kLinesMax) return;
    std::string line = text.ToCString();
    for (char& c : line)
      if (static_cast<unsigned char>(c) < ' ') c = ' ';
    line.erase(0, line.find_first_not_of(" *"));
    if (!line.empty()) lines_.push_back(std::move(line));
  }

  std::vector<std::string>& lines_;
};

}  // namespace

Messages::Messages() : printer_(new Collector(lines_)) {
  const Handle(Message_Messenger)& messenger = Message::DefaultMessenger();
  messenger->ChangePrinters().Clear();
  messenger->AddPrinter(printer_);
  std::cout.flush();
  std::fflush(stdout);
  output_ = ::dup(STDOUT_FILENO);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) {
    ::dup2(nowhere, STDOUT_FILENO);
    ::close(nowhere);
  }
}

Messages::~Messages() {
  std::cout.flush();
  std::fflush(stdout);
  if (output_ >= 0) {
    ::dup2(output_, STDOUT_FILENO);
    ::close(output_);
  }
  Message::DefaultMessenger()->RemovePrinter(printer_);
}

std::vector<std::string> Messages::take() { return std::exchange(lines_, {}); }

}  // namespace tessera::import::cad
