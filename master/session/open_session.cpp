// SPDX-License-Identifier: Apache-2.0
#include "master/session/session.h"

#include "common/base/limits.h"
#include "master/session/in_process_session.h"
#include "master/session/remote_session.h"

namespace tessera {

Result<std::unique_ptr<Session>> Session::open(const SessionOptions& options) {
  if (options.frames_in_flight < 1 || options.frames_in_flight > kFramesInFlightMax) {
    return Status::invalid_argument("frames in flight: give 1 or 2");
  }
  return options.connect.empty() ? master::open_in_process_session(options)
                                 : master::open_remote_session(options);
}

}  // namespace tessera
