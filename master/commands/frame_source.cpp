// SPDX-License-Identifier: Apache-2.0
#include "master/commands/frame_source.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>
#include <utility>

#include "common/base/clock.h"
#include "common/scene/animation.h"
#include "common/scene/pose.h"
#include "common/scene/validate.h"
#include "master/commands/animation_choice.h"
#include "master/look/usual_samples.h"

namespace tessera::master {
namespace {

std::string counted(std::uint64_t count, const char* one, const char* more) {
  return std::to_string(count) + " " + (count == 1 ? one : more);
}

// What is told of a scene that was loaded.
std::string contents_of(const Scene& scene) {
  const std::uint64_t triangles = scene.triangle_count(), patches = scene.patch_count();
  const std::string told = counted(patches, "patch", "patches");
  if (patches > 0 && triangles == 0) return told;
  return counted(triangles, "triangle", "triangles") + (patches > 0 ? ", " + told : "");
}

// The scene at a time, with what stands elsewhere on its way to another, so that a camera that sees
// all of it sees the motion.
Result<Scene> whole_motion(const Scene& scene, double first_seconds, double last_seconds) {
  constexpr int kSteps = 8;
  ScenePoser poser;
  const Result<Scene> first = poser.at(scene, first_seconds);
  Result<Scene> all = first;
  for (int step = 1; first.is_ok() && scene.animation && step <= kSteps; ++step) {
    const double share = static_cast<double>(step) / kSteps;
    Result<Scene> later = poser.at(scene, first_seconds + share * (last_seconds - first_seconds));
    if (!later.is_ok()) return later;
    // Where an object is hidden for a while, numbers do not agree, and the step is left out.
    if (later->instances.size() != first->instances.size()) continue;
    for (std::size_t i = 0; i < later->instances.size(); ++i) {
      Instance instance = later->instances[i];
      if (instance.kind != ObjectKind::kMesh) continue;
      const auto& mesh = later->meshes[instance.mesh];
      const bool is_still = instance == first->instances[i] && mesh == first->meshes[instance.mesh];
      if (is_still) continue;
      instance.mesh = static_cast<std::uint32_t>(all->meshes.size());
      all->meshes.push_back(mesh);
      all->instances.push_back(instance);
    }
  }
  return all;
}

// The part of the motion that the command shows.
Result<Scene> shown_motion(const Scene& scene, const MasterOptions& options) {
  if (!scene.animation) return scene;
  if (options.command == Command::kView)
    return whole_motion(scene, 0, scene.animation->duration_seconds());
  return whole_motion(scene, static_cast<double>(options.frame_first) / options.fps,
                      static_cast<double>(options.frame_last) / options.fps);
}

// Tells what of an animation is not shown as a person may think. `moves`: the chosen camera.
void tell_of_motion(const Scene& scene, const MasterOptions& options, bool moves,
                    Progress& progress) {
  if (!scene.animation) return;
  const double end_seconds = scene.animation->duration_seconds();
  const bool is_longer = static_cast<double>(options.frame_last) / options.fps > end_seconds;
  if (options.command == Command::kRender && is_longer)
    progress.say("tessera-master: the animation ends at " + std::to_string(end_seconds) +
                 " s; later frames show its end");
  if (options.command == Command::kView && moves)
    progress.say(
        "tessera-master: warning: this camera moves with the scene; here it begins where it is at "
        "the first frame, and then goes where it is steered");
}

}  // namespace

Camera turned(const Camera& camera, Vec3f centre, double degrees) {
  if (degrees == 0) return camera;
  const Vec3f axis = normalize(camera.up);
  const double angle = degrees * 3.14159265358979323846 / 180;
  const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
  // Rodrigues' formula.
  const auto turn = [&](Vec3f p) {
    const Vec3f v = p - centre;
    return centre + c * v + s * cross(axis, v) + ((1 - c) * dot(axis, v)) * axis;
  };
  Camera result = camera;
  result.eye = turn(camera.eye);
  result.target = turn(camera.target);
  return result;
}

Result<FrameSource> FrameSource::open(const MasterOptions& options, Progress& progress,
                                      const SignalWatch& signals) {
  FrameSource source;
  source.settings_ = options.frame;
  source.environment_ = options.environment;
  auto camera = CameraChoice::read(options);
  if (!camera.is_ok()) return camera.status();
  source.camera_ = std::move(*camera);
  if (const auto size = source.camera_.size(); size && !options.has_size) {
    source.settings_.width_px = size->width_px;
    source.settings_.height_px = size->height_px;
  }
  const auto report = [&](const std::string& text, double fraction) {
    progress.update(text, fraction);
    return !signals.is_signalled();
  };
  auto loaded = load_scene(options.scene, report, options.import_limits);
  if (!loaded.is_ok()) return loaded.status();
  if (!options.environment_file.empty()) {
    auto sky = load_sky(options.environment_file, report, options.import_limits);
    if (!sky.is_ok()) return sky.status();
    source.environment_ = Vec3f{1, 1, 1};
    source.environment_map_ = std::move(*sky);
  }
  source.loaded_ = std::move(*loaded);
  const auto played = choose_animation(source.loaded_.scene, options.animation);
  if (!played.is_ok()) return played.status();
  for (const std::string& warning : source.loaded_.warnings) {
    progress.say("tessera-master: warning: " + warning);
  }
  const Scene& scene = source.loaded_.scene;
  if (options.frame.patch_method != PatchMethod::kAuto && scene.surfaces.empty())
    progress.say("tessera-master: " + no_patches_line(options.frame.patch_method));
  if (options.has_usual_samples)
    source.settings_.samples_per_pixel = usual_samples(scene, source.settings_.renderer);
  progress.finish("loaded " + options.scene + ": " + contents_of(scene) +
                  (played->empty() ? "" : "; " + *played));
  source.fps_ = options.fps;
  const auto motion = shown_motion(scene, options);
  if (!motion.is_ok()) return motion.status();
  TESSERA_RETURN_IF_ERROR(
      source.camera_.settle(*motion, source.settings_.width_px, source.settings_.height_px));
  if (const auto number = source.camera_.number_in(*motion);
      number && moved_camera(scene, *number, 0))
    source.followed_ = number;
  tell_of_motion(scene, options, source.followed_.has_value(), progress);
  source.orbit_degrees_ = options.orbit_degrees;
  source.frame_first_ = options.frame_first;
  source.frame_last_ = options.frame_last;
  source.orbit_centre_ = source.camera_.orbit_centre(*motion);
  TESSERA_RETURN_IF_ERROR(validate_planes(source.settings_));
  const Status status = validate_frame_settings(source.settings_at(0));
  if (!status.is_ok()) {
    return Status::invalid_argument(
        source.camera_.is_from_viewpoint()
            ? options.scene +
                  ": no camera can show a scene of this size; give one with "
                  "--camera (" +
                  status.message() + ")"
            : (options.camera.empty() ? "" : "--camera " + options.camera + ": ") +
                  status.message());
  }
  return source;
}

void FrameSource::replace(LoadedScene loaded) {
  loaded_ = std::move(loaded);
  if (followed_ && *followed_ >= loaded_.scene.cameras.size()) followed_.reset();
  look_.is_committed = false;
}

double FrameSource::duration_seconds() const {
  if (is_animated()) return std::numeric_limits<double>::infinity();
  return is_timed() ? loaded_.scene.animation->duration_seconds() : 0;
}

Status FrameSource::settle(Session& session, const MasterOptions& options, Progress& progress,
                           const std::function<bool()>& should_stop) {
  const auto first = static_cast<double>(options.frame_first);
  auto look = settle_look(session, scene_at(first / options.fps), settings_at(first), options.look,
                          should_stop);
  if (!look.is_ok()) return look.status();
  look_ = *look;
  settings_.display = look->display;
  if (!look->words.empty()) progress.finish(look->words);
  return Status::ok();
}

// A camera that cannot stand where its node is at that time stays where it was settled.
Camera FrameSource::camera_at(double frame) const {
  std::optional<Camera> moved;
  if (followed_ && is_timed())
    moved = moved_camera(loaded_.scene, *followed_, std::max(0.0, frame / fps_));
  return moved ? *moved : camera_.at(frame);
}

FrameSettings FrameSource::settings_at(double frame) const {
  FrameSettings settings = settings_;
  if (is_timed()) settings.time_seconds = std::max(0.0, frame / fps_);
  settings.camera = camera_at(frame);
  if (frame_last_ > frame_first_) {
    const double share = (frame - static_cast<double>(frame_first_)) /
                         static_cast<double>(frame_last_ - frame_first_);
    settings.camera = turned(settings.camera, orbit_centre_, share * orbit_degrees_);
  }
  return settings;
}

Status wait_for_slaves(Session& session, const MasterOptions& options,
                       const std::function<bool()>& should_stop) {
  const auto wanted = static_cast<std::size_t>(options.session.slaves_min);
  const TimePoint start = Clock::now();
  double next_line_seconds = 5;
  while (true) {
    const std::size_t present = session.status().slaves.size();
    if (present >= wanted) return Status::ok();
    if (should_stop()) return Status::cancelled("interrupted while waiting for slaves");
    const double waited_seconds = seconds(Clock::now() - start);
    if (options.wait_seconds > 0 && waited_seconds >= options.wait_seconds) {
      return Status::deadline_exceeded(
          "only " + std::to_string(present) + " of " + std::to_string(wanted) +
          " slaves came within --wait; start more with 'tessera-slave --master HOST:PORT'");
    }
    if (waited_seconds >= next_line_seconds) {
      if (!options.is_quiet) {
        std::fprintf(stderr, "waiting for slaves: %zu of %zu after %.0f s\n", present, wanted,
                     waited_seconds);
      }
      next_line_seconds += 5;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace tessera::master
