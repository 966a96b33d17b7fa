// SPDX-License-Identifier: Apache-2.0
#include "master/commands/stats_file.h"

#include <cerrno>
#include <cstring>

#include "common/base/json.h"

namespace tessera::master {

std::string stats_json(const FrameStats& s, int width_px, int height_px, PixelFormat pixels,
                       const PassReport& report) {
  JsonObject json;
  json.add("frame", s.frame)
      .add("seconds", s.seconds)
      .add("completed_at", s.completed_at_seconds)
      .add("width", width_px)
      .add("height", height_px)
      .add("pixels", pixel_format_name(pixels))
      .add("isa", isa_name(s.isa))
      .add("mixed", s.is_mixed)
      .add("slaves", s.slave_count)
      .add("tiles", s.tile_count)
      .add("tile_px", s.tile_edge_px)
      .add("tiles_reissued", s.tiles_reissued)
      .add("tiles_rejected", s.tiles_rejected)
      .add("tiles_duplicated", s.tiles_duplicated)
      .add("tiles_faulty", s.tiles_faulty)
      .add("pixels_faulty", s.pixels_faulty)
      .add("prefetch_min", s.prefetch_min)
      .add("prefetch_max", s.prefetch_max)
      .add("rays_primary", s.rays.primary)
      .add("rays_shadow", s.rays.shadow)
      .add("rays_secondary", s.rays.secondary)
      .add("bytes_to_slaves", s.bytes_to_slaves)
      .add("bytes_from_slaves", s.bytes_from_slaves)
      .add("scene_version", s.scene_version)
      .add("scene_bytes", s.scene_cost.bytes)
      .add("scene_wait_seconds", s.scene_cost.wait_seconds)
      .add("built_primitives", s.scene_cost.built_primitives)
      .add("build_seconds", s.build_seconds)
      .add("utilisation", s.utilisation)
      .add("render_seconds", s.render_seconds)
      .add("digest", s.digest.hex());
  if (report.passes > 1)
    json.add("pass", report.pass).add("passes", report.passes).add("pass_seconds", report.seconds);
  if (report.error) {
    json.add("rmse", report.error->rmse)
        .add("rel_mse", report.error->rel_mse)
        .add("flip", report.error->flip)
        .add("mean_off", report.error->mean_off);
  }
  return json.text();
}

Result<StatsFile> StatsFile::open(const std::string& path) {
  StatsFile stats;
  stats.path_ = path;
  if (path.empty()) return stats;
  stats.file_.reset(std::fopen(path.c_str(), "we"));
  if (!stats.file_) return Status::not_found("--stats " + path + ": " + std::strerror(errno));
  return stats;
}

Status StatsFile::write(const FrameStats& stats, const FrameImage& image,
                        const PassReport& report) {
  if (!file_) return Status::ok();
  const std::string line =
      stats_json(stats, image.width_px, image.height_px, image.format, report) + "\n";
  if (std::fputs(line.c_str(), file_.get()) < 0 || std::fflush(file_.get()) != 0) {
    return Status::resource_exhausted("cannot write " + path_ + ": " + std::strerror(errno));
  }
  return Status::ok();
}

}  // namespace tessera::master
