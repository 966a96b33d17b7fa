// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "common/base/limits.h"
#include "master/commands/options.h"

namespace tessera::master {
namespace {

ParsedCommandLine parse(std::vector<const char*> words) {
  words.insert(words.begin(), "tessera-master");
  return parse_command_line(static_cast<int>(words.size()), words.data());
}

TEST(CommandLine, WrongUsageIsExitCodeTwo) {
  const std::vector<std::vector<const char*>> wrong = {
      {},
      {"dance"},
      {"render", "a.obj"},
      {"render", "a.obj", "-o", "x.png", "--bogus"},
      {"render", "a.obj", "-o", "x.png", "--size", "0x0"},
      {"render", "a.obj", "-o", "x.png", "--size", "99999x10"},
      {"render", "a.obj", "-o", "x.png", "--size", "640"},
      {"render", "a.obj", "-o", "x.png", "--frames", "5:2"},
      {"render", "a.obj", "-o", "x.png", "--tile", "0"},
      {"render", "a.obj", "-o", "x.png", "--tile", "abc"},
      {"render", "a.obj", "-o", "x.png", "--aa", "0"},
      {"render", "a.obj", "-o", "x.png", "--isa", "mmx"},
      {"render", "a.obj", "-o", "x.png", "--renderer", "radiosity"},
      {"render", "a.obj", "-o", "x.png", "--frames-in-flight", "3"},
      {"render", "a.obj", "-o", "x.png", "--slaves", "2"},
      {"render", "a.obj", "-o", "x.png", "--connect", "nowhere"},
      {"render", "a.obj", "-o", "x.png", "--keys", "k", "--plain"},
      {"render", "a.obj", "-o", "x.png", "--metrics", "0.0.0.0:9000"},
      {"render", "a.obj", "-o", "x.png", "--metrics", "9000"},
      {"render", "a.obj", "-o", "x.png", "--trace-seconds", "2"},
      {"render", "a.obj", "-o", "x.png", "--connect", "127.0.0.1:7400", "--plain", "--trace", "t"},
      {"serve", "--log-level", "loud"},
      {"serve", "--plain", "--heartbeat", "19"},
      {"serve", "--plain", "--heartbeats-missed", "101"},
      {"status"},
  };
  for (const auto& words : wrong) {
    std::string text;
    for (const char* word : words) text += std::string(word) + " ";
    EXPECT_EQ(parse(words).exit_code, 2) << text;
  }
}

TEST(CommandLine, DefaultsAreThoseOfTheContract) {
  const auto parsed = parse({"render", "builtin:cornell", "-o", "x.exr"});
  ASSERT_FALSE(parsed.exit_code);
  EXPECT_EQ(parsed.options.session.local_slaves, 1);
  EXPECT_EQ(parsed.options.frame.width_px, 640);
  EXPECT_EQ(parsed.options.frame.height_px, 480);
  EXPECT_EQ(parsed.options.frame.pixel_format, PixelFormat::kFloat);
  EXPECT_EQ(parsed.options.session.frames_in_flight, 2);
  EXPECT_EQ(parsed.options.session.prefetch_per_thread, -1);
  EXPECT_EQ(parsed.options.session.heartbeat_ms, std::uint32_t{kHeartbeatMs});
  EXPECT_EQ(parsed.options.session.heartbeats_missed_max, std::uint32_t{kHeartbeatsMissedMax});
  EXPECT_EQ(parse({"serve", "--plain"}).options.session.listen, "127.0.0.1:7400");
  EXPECT_EQ(
      parse({"serve", "--plain", "--listen", "127.0.0.1:1", "--listen", "127.0.0.2:2,[::1]:3"})
          .options.session.listen,
      "127.0.0.1:1,127.0.0.2:2,[::1]:3");
  EXPECT_EQ(parse({"serve", "--plain", "--listen", "127.0.0.1:1,10.0.0.1:2"}).exit_code, 2);
  EXPECT_EQ(parse({"view", "builtin:cornell"}).options.frame.pixel_format, PixelFormat::kHalf);
  EXPECT_EQ(parse({"render", "s.obj", "-o", "x.exr", "--listen", "127.0.0.1:0", "--plain"})
                .options.session.local_slaves,
            0);
}

std::string refusal(std::vector<const char*> words) {
  testing::internal::CaptureStderr();
  const auto parsed = parse(std::move(words));
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(parsed.exit_code, 2) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  return text;
}

TEST(CommandLine, PlanesNeedAFileThatHoldsThem) {
  const auto render = [](std::vector<const char*> more) {
    more.insert(more.begin(), {"render", "builtin:teapot", "-o"});
    return more;
  };
  const auto all = parse(render({"x.exr", "--aov", "depth,normal", "--background", "transparent"}));
  ASSERT_FALSE(all.exit_code);
  EXPECT_EQ(all.options.frame.planes, (PlaneSet{Plane::kAlpha, Plane::kNormal, Plane::kDepth}));
  const auto png = parse(render({"x.png", "--background", "transparent"}));
  ASSERT_FALSE(png.exit_code);
  EXPECT_EQ(png.options.frame.planes, PlaneSet{Plane::kAlpha});
  EXPECT_EQ(png.options.look.background, BackgroundChoice::kColor);
  EXPECT_TRUE(parse(render({"x.exr"})).options.frame.planes.is_empty());

  const struct {
    std::vector<const char*> words;
    const char* says;
  } refused[] = {
      {render({"x.jpg", "--background", "transparent"}), "give OUT.png or OUT.exr"},
      {render({"x.hdr", "--background", "transparent"}), "give OUT.png or OUT.exr"},
      {render({"x.png", "--background", "transparent", "--pixels", "display8"}), "--pixels float"},
      {{"view", "builtin:teapot", "--background", "transparent"}, "is for render"},
      {render({"x.png", "--aov", "depth"}), "give OUT.exr"},
      {render({"x.jpg", "--aov", "depth"}), "give OUT.exr"},
      {render({"x.exr", "--aov", "dept"}), "did you mean 'depth'"},
      {render({"x.exr", "--aov", "depth,,normal"}), "give albedo, normal"},
      {render({"x.exr", "--aov", "depth,depth"}), "twice"},
      {render({"x.exr", "--aov", "normal", "--size", "16384x16384"}), "fewer planes or pixels"},
      {render({"x.exr", "--aov", "normal,position", "--tile", "256"}), "tile edge"},
      {{"view", "builtin:teapot", "--aov", "depth"}, "--aov"},
  };
  for (const auto& one : refused)
    EXPECT_NE(refusal(one.words).find(one.says), std::string::npos) << one.says;
}

TEST(CommandLine, SamplesAreForTheSceneToSayWhereNobodyDoes) {
  const auto options = [](std::vector<const char*> words) {
    words.insert(words.begin(), {"render", "s.obj", "-o", "x.png"});
    return parse(words).options;
  };
  EXPECT_TRUE(options({}).has_usual_samples);
  EXPECT_TRUE(options({"--aa", "auto"}).has_usual_samples);
  EXPECT_FALSE(options({"--aa", "1"}).has_usual_samples);
  EXPECT_FALSE(options({"--passes", "8"}).has_usual_samples);
  EXPECT_FALSE(parse({"view", "s.obj"}).options.has_usual_samples);
  EXPECT_EQ(parse({"view", "s.obj"}).options.frame.samples_per_pixel, 1);
  EXPECT_EQ(parse({"render", "s.obj", "-o", "x.png", "--aa", "257"}).exit_code, 2);
}

TEST(CommandLine, ConfigFileFillsWhatTheCommandLineLeavesOpen) {
  const std::string path = testing::TempDir() + "tessera_config_test.toml";
  std::ofstream(path) << "size = \"100x50\"\naa = 4\nplain = true\n";
  const auto parsed =
      parse({"render", "s.obj", "-o", "x.exr", "--aa", "2", "--config", path.c_str()});
  ASSERT_FALSE(parsed.exit_code);
  EXPECT_EQ(parsed.options.frame.width_px, 100);
  EXPECT_EQ(parsed.options.frame.samples_per_pixel, 2);  // the command line wins
  EXPECT_TRUE(parsed.options.session.is_plain);
  std::ofstream(path) << "sise = \"100x50\"\n";
  EXPECT_EQ(parse({"render", "s.obj", "-o", "x.exr", "--config", path.c_str()}).exit_code, 2);
  std::ofstream(path) << "size = = 3\n";
  EXPECT_EQ(parse({"render", "s.obj", "-o", "x.exr", "--config", path.c_str()}).exit_code, 2);
}

}  // namespace
}  // namespace tessera::master
