// SPDX-License-Identifier: Apache-2.0
// Versions of a table have the entries of plain lists, whatever they share.
#include "common/base/shared_table.h"

#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <random>
#include <set>
#include <vector>

namespace tessera {
namespace {

using Table = SharedTable<int>;

std::vector<int> list_of(const Table& table) { return {table.begin(), table.end()}; }

std::size_t apart(const Table& table, const Table& from) {
  std::size_t count = 0;
  table.for_each_apart(from, [&](std::size_t) { ++count; });
  return count;
}

TEST(SharedTable, VersionsHaveTheEntriesOfListsAfterAnyChanges) {
  std::mt19937 random(5);
  std::deque<std::pair<Table, std::vector<int>>> versions{{}};
  for (int version = 1; version < 400; ++version) {
    auto [table, list] = versions[random() % versions.size()];
    Table::Editor editor(table);
    for (auto changes = random() % 4; changes > 0; --changes) {
      if (random() % 3 == 0) {
        list.resize(random() % (3 * Table::kChunk));
        editor.resize(list.size());
      }
      if (list.empty()) continue;
      const std::size_t at = random() % list.size();
      editor.edit(at) = list[at] = version;
      EXPECT_EQ(editor[at], version);
    }
    versions.push_back({editor.finish(), std::move(list)});
    if (versions.size() > 8) versions.pop_front();
    for (const auto& [held, as_list] : versions) {
      ASSERT_EQ(held.size(), as_list.size());
      ASSERT_EQ(list_of(held), as_list) << "version " << version;
    }
    // What differs is among the entries that are apart.
    const auto& [of, of_list] = versions.back();
    const auto& [from, from_list] = versions.front();
    std::set<std::size_t> named, traced;
    of.for_each_apart(from, [&](std::size_t i) { named.insert(i); });
    Table::Trace(from).for_each_apart(of, [&](std::size_t i) { traced.insert(i); });
    EXPECT_EQ(named, traced);
    for (std::size_t i = 0; i < of_list.size(); ++i) {
      const bool differs = i >= from_list.size() || from_list[i] != of_list[i];
      ASSERT_TRUE(!differs || named.contains(i)) << i;
    }
  }
}

TEST(SharedTable, OneEntryThatDiffersCostsAChunk) {
  const Table table(std::vector<int>(10 * Table::kChunk, 1));
  EXPECT_EQ(apart(table, table), 0u);
  EXPECT_EQ(apart(table, {}), table.size());
  Table other = table;
  other.set(3 * Table::kChunk + 7, 2);
  EXPECT_EQ(apart(other, table), Table::kChunk);
  EXPECT_EQ(table[3 * Table::kChunk + 7], 1);
  EXPECT_EQ(other[3 * Table::kChunk + 7], 2);
}

TEST(SharedTable, ATraceKeepsNothingAlive) {
  auto entry = std::make_shared<int>(1);
  const std::weak_ptr<int> seen = entry;
  SharedTable<std::shared_ptr<int>> table{std::move(entry)};
  const SharedTable<std::shared_ptr<int>>::Trace trace(table);
  table = {};
  EXPECT_TRUE(seen.expired());
  std::size_t count = 0;
  trace.for_each_apart(SharedTable<std::shared_ptr<int>>{nullptr}, [&](std::size_t) { ++count; });
  EXPECT_EQ(count, 1u) << "a new chunk is another one, wherever it lies";
}

}  // namespace
}  // namespace tessera
