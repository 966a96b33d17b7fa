// SPDX-License-Identifier: Apache-2.0
// What Open CASCADE says while it reads, caught: its messages, and what it writes to standard
// output, which carries the importer's blocks.
//
// Threads. One object at a time, in the thread that reads.
#pragma once

#include <Message_Printer.hxx>
#include <string>
#include <vector>

namespace tessera::import::cad {

class Messages {
 public:
  Messages();
  ~Messages();
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;

  // The warnings and failures until now, in their order.
  std::vector<std::string> take();

 private:
  std::vector<std::string> lines_;
  Handle(Message_Printer) printer_;
  int output_ = -1;  // standard output, while it leads nowhere
};

}  // namespace tessera::import::cad
