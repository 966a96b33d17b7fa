// SPDX-License-Identifier: Apache-2.0
// A trace as the text of a file.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <limits>
#include <vector>

#include "common/base/json.h"
#include "master/frame_loop/trace.h"

namespace tessera::master {
namespace {

constexpr int kMasterProcess = 1;  // "pid" in the file; slaves follow
constexpr int kFirstSlaveProcess = 2;
constexpr double kNs = 1e-9;

std::int64_t ns_between(TimePoint from, TimePoint to) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(to - from).count();
}

// "12.345": microseconds with three digits, which nanoseconds fit exactly.
std::string microseconds(std::int64_t ns) {
  char text[40];
  std::snprintf(text, sizeof(text), "%s%lld.%03lld", ns < 0 ? "-" : "",
                static_cast<long long>(std::llabs(ns) / 1000),
                static_cast<long long>(std::llabs(ns) % 1000));
  return text;
}

struct Span {
  int process = 0;
  std::uint32_t row = 0;
  std::int64_t begin_ns = 0, end_ns = 0;  // after the trace's start
  std::string name, args;
};

class Writer {
 public:
  void name_process(int process, const std::string& name, const std::string& labels) {
    metadata("process_name", process, 0, JsonObject().add("name", name));
    metadata("process_sort_index", process, 0, JsonObject().add("sort_index", process));
    if (!labels.empty()) metadata("process_labels", process, 0, JsonObject().add("labels", labels));
  }
  void name_row(int process, std::uint32_t row, const std::string& name) {
    metadata("thread_name", process, row, JsonObject().add("name", name));
  }

  void span(const Span& s) {
    event(JsonObject()
              .add("ph", "X")
              .add("pid", s.process)
              .add("tid", s.row)
              .add_raw("ts", microseconds(s.begin_ns))
              .add_raw("dur", microseconds(s.end_ns - s.begin_ns))
              .add("name", s.name)
              .add_raw("args", s.args));
  }

  // Writes a span that may overlap others; Perfetto gives it a row of its own where it needs one.
  void overlapping(int process, std::uint64_t id, const std::string& name, std::int64_t begin_ns,
                   std::int64_t end_ns) {
    for (const bool is_begin : {true, false}) {
      event(JsonObject()
                .add("ph", is_begin ? "b" : "e")
                .add("cat", "lease")
                .add("id", id)
                .add("pid", process)
                .add("tid", 0)
                .add_raw("ts", microseconds(is_begin ? begin_ns : end_ns))
                .add("name", name));
    }
  }

  std::string finish(const std::string& other) {
    return "{\"displayTimeUnit\":\"ms\",\"otherData\":" + other + ",\"traceEvents\":[\n" + events_ +
           "\n]}\n";
  }

 private:
  void metadata(const char* kind, int process, std::uint32_t row, const JsonObject& args) {
    event(JsonObject()
              .add("ph", "M")
              .add("pid", process)
              .add("tid", row)
              .add("name", kind)
              .add_raw("args", args.text()));
  }
  void event(const JsonObject& json) {
    if (!events_.empty()) events_ += ",\n";
    events_ += json.text();
  }

  std::string events_;
};

// The first row whose last span is over.
std::uint32_t free_row(std::vector<std::int64_t>& row_ends, std::int64_t begin_ns,
                       std::int64_t end_ns) {
  std::uint32_t row = 0;
  while (row < row_ends.size() && row_ends[row] > begin_ns) ++row;
  if (row == row_ends.size()) row_ends.push_back(0);
  row_ends[row] = end_ns;
  return row;
}

void write_frames(const Trace& trace, Writer& out) {
  std::vector<TracedFrame> frames(trace.frames.begin(), trace.frames.end());
  std::stable_sort(frames.begin(), frames.end(),
                   [](const auto& a, const auto& b) { return a.begin < b.begin; });
  std::vector<std::int64_t> row_ends;
  for (const TracedFrame& f : frames) {
    Span span;
    span.process = kMasterProcess;
    span.begin_ns = ns_between(trace.start, f.begin);
    span.end_ns = ns_between(trace.start, f.end);
    span.row = free_row(row_ends, span.begin_ns, span.end_ns);
    span.name = "frame " + std::to_string(f.frame);
    span.args = JsonObject()
                    .add("frame", f.frame)
                    .add("scene_version", f.version)
                    .add("outcome", f.outcome)
                    .text();
    out.span(span);
  }
  for (std::uint32_t row = 0; row < row_ends.size(); ++row) {
    out.name_row(kMasterProcess, row, row == 0 ? "frames" : "frames, in flight with them");
  }
}

void write_tiles(const Trace& trace, SessionId session, int process, const ClockEstimate& clock,
                 Writer& out) {
  std::vector<Span> spans;
  const std::int64_t start_ns = static_cast<std::int64_t>(nanoseconds(trace.start));
  std::uint64_t lease_id = 0;
  for (const TracedTile& t : trace.tiles) {
    ++lease_id;
    if (t.session != session) continue;
    out.overlapping(kMasterProcess, lease_id, trace.slaves.at(session).name,
                    ns_between(trace.start, t.leased), ns_between(trace.start, t.received));
    Span span;
    span.process = process;
    span.row = t.worker;
    span.begin_ns = static_cast<std::int64_t>(
        t.began_ns - static_cast<std::uint64_t>(clock.offset_ns + start_ns));
    span.end_ns = span.begin_ns + static_cast<std::int64_t>(t.render_seconds / kNs);
    span.name = "frame " + std::to_string(t.frame);
    span.args =
        JsonObject()
            .add("frame", t.frame)
            .add("tile", t.tile)
            .add("attempt", t.attempt)
            .add("accepted", t.is_accepted)
            .add("waited_us",
                 1e-3 * static_cast<double>(span.begin_ns - ns_between(trace.start, t.leased)))
            .add("returned_us",
                 1e-3 * static_cast<double>(ns_between(trace.start, t.received) - span.end_ns))
            .text();
    spans.push_back(std::move(span));
  }
  for (const Span& span : spans) out.span(span);
}

// Builds of one slave do not overlap, though messages may come closer to each other than they were
// sent.
void write_builds(const Trace& trace, SessionId session, int process, std::uint32_t row,
                  Writer& out) {
  std::int64_t last_end_ns = std::numeric_limits<std::int64_t>::min();
  for (const TracedBuild& build : trace.builds) {
    if (build.session != session) continue;
    if (last_end_ns == std::numeric_limits<std::int64_t>::min())
      out.name_row(process, row, "builder");
    Span span;
    span.process = process;
    span.row = row;
    span.end_ns = ns_between(trace.start, build.told);
    span.begin_ns =
        std::max(last_end_ns, span.end_ns - static_cast<std::int64_t>(build.seconds / kNs));
    last_end_ns = span.end_ns;
    span.name = "scene " + std::to_string(build.version);
    span.args = JsonObject()
                    .add("scene_version", build.version)
                    .add("built_primitives", build.built_primitives)
                    .text();
    out.span(span);
  }
}

// The ways of scenes to one slave, each until its build begins. A slave takes one after the other.
void write_transfers(const Trace& trace, SessionId session, int process, std::uint32_t row,
                     Writer& out) {
  std::int64_t last_end_ns = std::numeric_limits<std::int64_t>::min();
  for (const TracedBuild& build : trace.builds) {
    if (build.session != session || !build.offered) continue;
    if (last_end_ns == std::numeric_limits<std::int64_t>::min())
      out.name_row(process, row, "scene transfer");
    Span span;
    span.process = process;
    span.row = row;
    span.begin_ns = std::max(last_end_ns, ns_between(trace.start, *build.offered));
    span.end_ns = std::max(span.begin_ns, ns_between(trace.start, build.told) -
                                              static_cast<std::int64_t>(build.seconds / kNs));
    last_end_ns = span.end_ns;
    span.name = "scene " + std::to_string(build.version);
    span.args = JsonObject().add("scene_version", build.version).text();
    out.span(span);
  }
}

}  // namespace

std::string trace_json(const Trace& trace) {
  Writer out;
  out.name_process(kMasterProcess, "master", "");
  write_frames(trace, out);
  int process = kFirstSlaveProcess;
  std::uint64_t unplaced = 0;
  std::string errors = "{";
  std::vector<std::pair<SessionId, TracedSlave>> slaves(trace.slaves.begin(), trace.slaves.end());
  std::stable_sort(slaves.begin(), slaves.end(),
                   [](const auto& a, const auto& b) { return a.second.name < b.second.name; });
  for (const auto& [session, slave] : slaves) {
    if (!slave.clock) {
      unplaced += static_cast<std::uint64_t>(
          std::count_if(trace.tiles.begin(), trace.tiles.end(),
                        [id = session](const TracedTile& t) { return t.session == id; }));
      continue;
    }
    const std::string error = microseconds(slave.clock->error_ns);
    out.name_process(process, slave.name, "clock within " + error + " us of the master's");
    for (std::uint32_t row = 0; row < slave.threads; ++row)
      out.name_row(process, row, "render thread " + std::to_string(row));
    write_tiles(trace, session, process, *slave.clock, out);
    write_builds(trace, session, process, slave.threads, out);
    write_transfers(trace, session, process, slave.threads + 1, out);
    if (errors.size() > 1) errors += ',';
    append_json_string(errors, std::to_string(process));
    errors += ":" + error;
    ++process;
  }
  return out.finish(JsonObject()
                        .add("product", "Tessera")
                        .add("tiles_dropped", trace.tiles_dropped)
                        .add("frames_dropped", trace.frames_dropped)
                        .add("builds_dropped", trace.builds_dropped)
                        .add("tiles_without_clock", unplaced)
                        .add_raw("clock_error_us", errors + "}")  // by process
                        .text());
}

Status write_trace(const Trace& trace, const std::string& path) {
  const std::string text = trace_json(trace);
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) {
    return Status::unavailable("cannot write the trace " + path + ": " + std::strerror(errno));
  }
  const bool is_written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const bool is_closed = std::fclose(file) == 0;
  if (is_written && is_closed) return Status::ok();
  return Status::unavailable("cannot write the trace " + path + ": " + std::strerror(errno) +
                             "; it is not complete");
}

}  // namespace tessera::master
