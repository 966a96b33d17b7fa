// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gi_error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "common/base/json.h"
#include "common/frame/tile_grid.h"
#include "master/image/image_error.h"
#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/bench/contender.h"
#include "tests/bench/gi_frame.h"

namespace tessera::bench {
namespace {

using master::ImageError;

struct Row {
  std::string series, setting;
  double seconds = 0;
  ImageError error;
};

// Slope of the least-squares line of log y over log x.
double slope(const std::vector<double>& x, const std::vector<double>& y) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const auto n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double a = std::log(x[i]), b = std::log(y[i]);
    sx += a;
    sy += b;
    sxx += a * a;
    sxy += a * b;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

class ErrorTables {
 public:
  ErrorTables(const core::PreparedScene& scene, const FrameSettings& settings,
              const CoreSuiteOptions& options)
      : scene_(scene), base_(settings), options_(options) {
    base_.width_px = options.is_quick ? 64 : 160;
    base_.height_px = options.is_quick ? 48 : 120;
    base_.samples_per_pixel = 4;
  }

  std::string run() {
    make_reference();
    find_lamps();
    std::printf("  %-12s %-22s %10s %10s %10s %8s %9s\n", "error", "setting", "CPU-s", "RMSE",
                "relMSE", "FLIP", "mean");
    add_vpls("vpls", [](FrameSettings&) {});
    // These have no filter, which has an error of its own, and a compensated clamp, since more VPLs
    // do not take its bias away.
    add_vpls("vpls, raw", [](FrameSettings& s) {
      s.is_filtered = false;
      s.clamp = kClampAuto;
      s.is_compensated = true;
    });
    for (const int k : {1, 3, 5}) {
      for (const bool is_filtered : {false, true}) {
        if (k == 1 && is_filtered) continue;  // there is nothing to average
        add("interleave", std::to_string(k) + (is_filtered ? ", filtered" : ""),
            [&](FrameSettings& s) {
              s.interleave = k;
              s.is_filtered = is_filtered;
            });
      }
    }
    add("clamp", "off", [](FrameSettings&) {});
    for (const bool is_compensated : {false, true}) {
      add("clamp", is_compensated ? "on, compensated" : "on", [&](FrameSettings& s) {
        s.clamp = kClampAuto;
        s.is_compensated = is_compensated;
      });
    }
    for (const int n : {1, 4, 16}) {
      add("samples", std::to_string(n), [&](FrameSettings& s) { s.samples_per_pixel = n; });
    }
    add_passes("passes", true, options_.is_quick ? 4 : 64);
    add_passes("path", false, options_.is_quick ? 8 : 64);
    print_slopes();
    print_equals();
    return json();
  }

 private:
  void make_reference() {
    FrameSettings s = base_;
    s.renderer = Renderer::kPath;
    s.samples_per_pixel = 256;
    const int passes = options_.is_quick ? 2 : 16;
    std::vector<double> sum;
    s.seed = 1000;  // the measured pictures share no samples with it
    for (int pass = 0; pass < passes; ++pass) {
      s.pass = static_cast<std::uint32_t>(pass);
      add_to(sum, render_fast(scene_, s, options_.isa));
    }
    for (const double x : sum) reference_.push_back(static_cast<float>(x / passes));
  }

  static void add_to(std::vector<double>& sum, const std::vector<float>& rgb) {
    sum.resize(rgb.size());
    for (std::size_t i = 0; i < rgb.size(); ++i) sum[i] += static_cast<double>(rgb[i]);
  }

  // Pixels next to a lamp that is seen show how well its edge is sampled, which no setting of VPLs
  // changes, and hide all else: they are left out.
  void find_lamps() {
    float least = INFINITY;
    for (const core::Emitter& e : scene_.impl().lights.emitters)
      least = std::min(least, std::max({e.emission.x, e.emission.y, e.emission.z}));
    is_lamp_.assign(reference_.size() / 3, false);
    for (int y = 0; y < base_.height_px; ++y) {
      for (int x = 0; x < base_.width_px; ++x) {
        for (int k = 0; k < 9; ++k) {
          const int at_x = std::clamp(x + k % 3 - 1, 0, base_.width_px - 1);
          const int at_y = std::clamp(y + k / 3 - 1, 0, base_.height_px - 1);
          const auto from = 3 * static_cast<std::size_t>(at_y * base_.width_px + at_x);
          for (std::size_t c = 0; c < 3; ++c) {
            if (reference_[from + c] > 0.1f * least)
              is_lamp_[static_cast<std::size_t>(y * base_.width_px + x)] = true;
          }
        }
      }
    }
    blacken(reference_);
  }

  void blacken(std::vector<float>& rgb) const {
    for (std::size_t i = 0; i < is_lamp_.size(); ++i) {
      if (is_lamp_[i]) std::fill_n(rgb.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, 0.0f);
    }
  }

  ImageError error_of(std::vector<float> rgb) const {
    blacken(rgb);
    return master::image_error(rgb, reference_, base_.width_px, base_.height_px);
  }

  // Enters the row with the RMSE over all `errors`, as of one picture, and the means of the other
  // measures.
  void enter(Row row, const std::vector<ImageError>& errors) {
    const auto n = static_cast<double>(errors.size());
    for (const ImageError& e : errors) {
      row.error.rmse += e.rmse * e.rmse / n;
      row.error.rel_mse += e.rel_mse / n;
      row.error.flip += e.flip / n;
      row.error.mean_off += e.mean_off / n;
    }
    row.error.rmse = std::sqrt(row.error.rmse);
    std::printf("  %-12s %-22s %10.4f %10.6f %10.6f %8.4f %+8.2f%%\n", row.series.c_str(),
                row.setting.c_str(), row.seconds, row.error.rmse, row.error.rel_mse, row.error.flip,
                100 * row.error.mean_off);
    std::fflush(stdout);
    rows_.push_back(std::move(row));
  }

  template <typename Change>
  void add_vpls(const std::string& series, const Change& change) {
    const int vpls_max = options_.is_quick ? 64 : 4096;
    for (int n = 8; n <= vpls_max; n *= 2) {
      // All seeds together have as many VPLs: pictures of few VPLs vary the most from seed to seed.
      const int seeds = options_.is_quick ? 2 : std::clamp(2048 / n, 2, 8);
      add(
          series, std::to_string(n) + " VPLs",
          [&](FrameSettings& s) {
            change(s);
            s.vpls = n;
          },
          seeds);
    }
  }

  template <typename Change>
  void add(const std::string& series, const std::string& setting, const Change& change,
           int seeds = 0) {
    FrameSettings s = base_;
    change(s);
    if (seeds == 0) seeds = options_.is_quick ? 2 : 8;
    std::vector<double> times;
    std::vector<ImageError> errors;
    for (int i = 0; i < seeds; ++i) {
      s.seed = static_cast<std::uint32_t>(i);
      GiFrame frame = render_gi(scene_, s, options_.isa);
      times.push_back(frame.cpu_seconds);
      errors.push_back(error_of(std::move(frame.rgb)));
    }
    enter({series, setting, median(times), {}}, errors);
  }

  // Adds means of 1, 2, 4... passes, of several seeds, by igi with bias compensation or by path.
  void add_passes(const std::string& series, bool is_igi, int passes) {
    FrameSettings s = base_;
    s.clamp = kClampAuto;
    s.is_compensated = true;
    if (!is_igi) s.renderer = Renderer::kPath;
    constexpr int kSeeds = 4;
    std::vector<double> sum[kSeeds];
    double seconds = 0;
    for (int pass = 0; pass < passes; ++pass) {
      s.pass = static_cast<std::uint32_t>(pass);
      std::vector<ImageError> errors;
      const int count = pass + 1;
      const bool is_row = (count & (count - 1)) == 0;
      for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
        s.seed = seed;
        const double start = thread_cpu_seconds();
        add_to(sum[seed], is_igi ? render_gi(scene_, s, options_.isa).rgb : render_one(s));
        seconds += (thread_cpu_seconds() - start) / kSeeds;
        if (!is_row) continue;
        std::vector<float> mean;
        for (const double x : sum[seed]) mean.push_back(static_cast<float>(x / count));
        errors.push_back(error_of(std::move(mean)));
      }
      if (!is_row) continue;
      const std::string setting = is_igi ? std::to_string(count) + " passes"
                                         : std::to_string(count * s.samples_per_pixel) + " samples";
      enter({series, setting, seconds, {}}, errors);
    }
  }

  std::vector<float> render_one(const FrameSettings& s) const {
    std::vector<float> rgb(static_cast<std::size_t>(3 * s.width_px * s.height_px));
    core::TileRenderer().render(scene_, s, options_.isa, {0, 0, s.width_px, s.height_px}, rgb);
    return rgb;
  }

  void print_slopes() {
    for (const char* series : {"vpls", "vpls, raw", "passes", "path"}) {
      std::vector<double> n, rmse;
      for (const Row& row : rows_) {
        if (row.series != series) continue;
        n.push_back(std::exp2(static_cast<double>(n.size())));
        rmse.push_back(row.error.rmse);
      }
      slopes_.emplace_back(series, slope(n, rmse));
      std::printf("  RMSE over the number (%s): N^%.2f\n", series, slopes_.back().second);
    }
  }

  // Prints the error of path in the time that igi takes, and the time that path takes for igi's
  // error, on straight lines between and beyond the rows of path, in logarithms.
  void print_equals() {
    std::vector<Row> path;
    for (const Row& row : rows_) {
      if (row.series == "path") path.push_back(row);
    }
    const auto along = [&](auto x_of, auto y_of, double x) {
      std::size_t i = 0;
      const bool is_rising = x_of(path[1]) > x_of(path[0]);
      while (i + 2 < path.size() && (x_of(path[i + 1]) < x) == is_rising) ++i;
      const double x0 = std::log(x_of(path[i])), x1 = std::log(x_of(path[i + 1]));
      const double y0 = std::log(y_of(path[i])), y1 = std::log(y_of(path[i + 1]));
      return std::exp(y0 + (y1 - y0) * (std::log(x) - x0) / (x1 - x0));
    };
    const auto seconds = [](const Row& r) { return r.seconds; };
    const auto rmse = [](const Row& r) { return r.error.rmse; };
    std::printf("  %-12s %-22s %14s %14s %14s\n", "igi", "setting", "RMSE", "path's, as long",
                "path's time");
    for (const Row& row : rows_) {
      if (row.series == "path") continue;
      std::printf("  %-12s %-22s %14.6f %14.6f %13.1fx\n", row.series.c_str(), row.setting.c_str(),
                  row.error.rmse, along(seconds, rmse, row.seconds),
                  along(rmse, seconds, row.error.rmse) / row.seconds);
    }
  }

  std::string json() const {
    std::string list = "[";
    for (const Row& row : rows_) {
      JsonObject o;
      o.add("series", row.series).add("setting", row.setting).add("cpu_seconds", row.seconds);
      o.add("rmse", row.error.rmse).add("rel_mse", row.error.rel_mse).add("flip", row.error.flip);
      o.add("mean_off", row.error.mean_off);
      list += (list.size() > 1 ? "," : "") + o.text();
    }
    JsonObject slopes;
    for (const auto& [series, value] : slopes_) slopes.add(series, value);
    JsonObject all;
    all.add("width", base_.width_px).add("height", base_.height_px);
    all.add_raw("rows", list + "]").add_raw("slopes", slopes.text());
    return all.text();
  }

  const core::PreparedScene& scene_;
  FrameSettings base_;
  const CoreSuiteOptions& options_;
  std::vector<float> reference_;
  std::vector<bool> is_lamp_;
  std::vector<Row> rows_;
  std::vector<std::pair<std::string, double>> slopes_;
};

}  // namespace

std::string measure_error(const core::PreparedScene& scene, const FrameSettings& settings,
                          const CoreSuiteOptions& options) {
  return ErrorTables(scene, settings, options).run();
}

}  // namespace tessera::bench
