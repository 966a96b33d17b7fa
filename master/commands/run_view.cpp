// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <utility>

#include "common/base/clean_text.h"
#include "common/scene/validate.h"
#include "common/scene_io/camera_file.h"
#include "master/commands/commands.h"
#include "master/commands/frame_source.h"
#include "master/commands/picture_attributes.h"
#include "master/commands/scene_reload.h"
#include "master/commands/snapshot_writer.h"
#include "master/commands/stats_file.h"
#include "master/commands/view_pump.h"
#include "master/display/viewer.h"
#include "master/image/image_file.h"

namespace tessera::master {
namespace {

// Describes what F12 saves, in a few words.
std::string described(const ViewerFrame& frame) {
  std::string text =
      std::to_string(frame.image->width_px) + "x" + std::to_string(frame.image->height_px);
  if (!frame.is_full) return text + ", reduced: the view was not at rest";
  return text + ", " + std::to_string(frame.passes) + (frame.passes == 1 ? " pass" : " passes");
}

// The window with what its keys ask of this program. `viewer` is filled in before it can ask.
ViewerOptions viewer_options(const MasterOptions& options, const FrameSource& source,
                             SnapshotWriter& snapshots, std::unique_ptr<Viewer>& viewer) {
  const FrameSettings settings = source.settings_at(0);
  ViewerOptions o;
  o.title = "Tessera: " + options.scene;
  o.width_px = settings.width_px;
  o.height_px = settings.height_px;
  o.camera = settings.camera;
  o.bounds = scene_bounds(source.loaded().scene);
  o.camera_of_all = camera_of_all(source.loaded().scene);
  o.screenshot_path = options.screenshot_path;
  o.screenshot_after = options.screenshot_after;
  o.save = [](const FrameImage& image, const std::string& path) {
    return write_image(image, path, {});
  };
  o.on_save_picture = [&snapshots, &viewer, scene = options.scene](
                          const ViewerFrame& frame, const DisplayTransform& display) {
    FrameSettings settings = frame.settings;
    settings.display = display;
    const bool is_taken = snapshots.save(
        frame.image, described(frame),
        {false, display, picture_attributes(scene, settings, frame.passes, frame.stats.seconds)});
    viewer->notify(is_taken ? "saving the picture" : "pictures are still being saved: try again");
  };
  // The line names the samples, since render takes more of them than the window by default.
  o.on_copy_camera = [samples = settings.samples_per_pixel](const Camera& camera, PixelSize size) {
    const std::string line = "--camera \"" + camera_text(camera) + "\" --size " +
                             std::to_string(size.width_px) + "x" + std::to_string(size.height_px) +
                             " --aa " + std::to_string(samples);
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
    return line;
  };
  return o;
}

}  // namespace

int run_view(const MasterOptions& options, const SignalWatch& signals) {
  // What can fail at once comes first, since reading a scene may take minutes.
  if (const Status status = Viewer::check_display(); !status.is_ok()) return report_failure(status);
  Progress progress(options.is_quiet);
  auto stats = StatsFile::open(options.stats_path);
  if (!stats.is_ok()) return report_failure(stats.status());
  auto session = Session::open(options.session);
  if (!session.is_ok()) return report_failure(session.status());
  const auto first_look = look_at_file(options.scene);
  auto source = FrameSource::open(options, progress, signals);
  if (!source.is_ok()) {
    progress.clear();
    return report_failure(source.status());
  }
  std::unique_ptr<Viewer> viewer;
  // Declared after the viewer that it tells, so that it ends first.
  SnapshotWriter snapshots(snapshot_stem(options.scene), [&](const std::string& line) {
    if (!options.is_quiet) std::fprintf(stderr, "%s\n", clean_text(line).c_str());
    viewer->notify(line);
  });
  auto opened = Viewer::open(viewer_options(options, *source, snapshots, viewer));
  if (!opened.is_ok()) return report_failure(opened.status());
  viewer = std::move(*opened);
  Status status = wait_for_slaves(**session, options, [&] { return signals.is_signalled(); });
  if (status.is_ok()) {
    SceneReload reload(options, first_look);
    ViewPump pump(**session, *source, options, progress, *viewer, *stats, reload);
    viewer->run([&] { return signals.is_signalled() || pump.has_ended(); });
    (*session)->cancel_frames();
    pump.stop();
    status = pump.failure();
  }
  // Leaving cancels what was in flight; a screenshot that was not taken is a failure all the same.
  if (status.code() == StatusCode::kCancelled) status = Status::ok();
  if (status.is_ok() && !options.screenshot_path.empty()) status = viewer->screenshot_status();
  return status.is_ok() ? 0 : report_failure(status);
}

}  // namespace tessera::master
