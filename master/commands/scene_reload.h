// SPDX-License-Identifier: Apache-2.0
// Reads the file of the command line again when it changes, beside the frames that show what was
// read before. A built-in scene never changes.
//
// Threads. take(): one at a time; the file is looked at and read by a thread of its own, which the
// destructor ends.
#pragma once

#include <optional>
#include <thread>

#include "common/base/mutex.h"
#include "master/commands/options.h"
#include "master/display/newest_slot.h"
#include "master/loader/file_watch.h"
#include "master/loader/load_scene.h"

namespace tessera::master {

class SceneReload {
 public:
  // first: what a look found before the file was read. `options` outlives the object.
  SceneReload(const MasterOptions& options, const std::optional<FileLook>& first);
  ~SceneReload();

  // Returns: nothing while the file is as it was; else, once for each change, the scene, with the
  // animation chosen that the options name, or one line why it cannot be read.
  std::optional<Result<LoadedScene>> take() { return newest_.take(); }

 private:
  void work();
  bool is_stopped() const;
  Result<LoadedScene> read() const;

  const MasterOptions& options_;
  FileWatch watch_;  // the thread's
  NewestSlot<Result<LoadedScene>> newest_;
  mutable Mutex mutex_;
  CondVar stopped_;
  bool is_stopped_ TESSERA_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: starts when all else is there
};

}  // namespace tessera::master
