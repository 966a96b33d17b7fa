// SPDX-License-Identifier: Apache-2.0
#include "master/display/key_map.h"

#include <gtest/gtest.h>

#include <set>

namespace tessera::master {
namespace {

TEST(KeyMap, AKeyHasOneMeaningAndACommandOneKey) {
  std::set<Key> keys;
  std::set<ViewerCommand> commands;
  for (const KeyBinding& binding : key_bindings()) {
    EXPECT_FALSE(binding.label.empty());
    EXPECT_FALSE(binding.meaning.empty()) << binding.label;
    EXPECT_EQ(binding.key == Key::kOther, binding.command == ViewerCommand::kNone) << binding.label;
    if (binding.key == Key::kOther) continue;
    EXPECT_TRUE(keys.insert(binding.key).second) << binding.label;
    EXPECT_TRUE(commands.insert(binding.command).second) << binding.label;
    EXPECT_EQ(command_of(binding.key, false), binding.command) << binding.label;
  }
  for (const Key held : {Key::kW, Key::kA, Key::kS, Key::kD, Key::kQ, Key::kE})
    EXPECT_FALSE(keys.contains(held)) << "it flies";
}

TEST(KeyMap, EveryCommandCanBeGiven) {
  std::set<ViewerCommand> commands{ViewerCommand::kNone};
  for (const KeyBinding& binding : key_bindings()) commands.insert(binding.command);
  EXPECT_EQ(commands.size(), static_cast<std::size_t>(ViewerCommand::kQuit) + 1)
      << "kQuit is the last one";
}

TEST(KeyMap, ControlMeansQuitOrNothing) {
  for (const KeyBinding& binding : key_bindings())
    EXPECT_EQ(command_of(binding.key, true), ViewerCommand::kNone) << binding.label;
  EXPECT_EQ(command_of(Key::kQ, true), ViewerCommand::kQuit);
  EXPECT_EQ(command_of(Key::kOther, false), ViewerCommand::kNone);
}

}  // namespace
}  // namespace tessera::master
