// SPDX-License-Identifier: Apache-2.0
// A table whose versions share what they have in common: chunks of kChunk entries, each of which
// never changes. A copy costs a pointer for each chunk, and a version that differs in few entries
// makes few chunks anew. What two versions share is found by the chunks' addresses, so a version
// of ten thousand entries costs what differs in it.
//
// Threads. A table never changes. Editor: one owner.
#pragma once

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

namespace tessera {

template <class T>
class SharedTable {
 public:
  static constexpr std::size_t kChunk = 256;

  class Editor;
  class Trace;
  class const_iterator;
  using value_type = T;

  SharedTable() = default;
  SharedTable(std::vector<T> entries) : size_(entries.size()) {
    for (std::size_t i = 0; i < entries.size(); i += kChunk) {
      const auto from = entries.begin() + static_cast<std::ptrdiff_t>(i);
      const auto count = static_cast<std::ptrdiff_t>(std::min(kChunk, entries.size() - i));
      chunks_.push_back(std::make_shared<const std::vector<T>>(
          std::make_move_iterator(from), std::make_move_iterator(from + count)));
    }
  }
  SharedTable(std::initializer_list<T> entries) : SharedTable(std::vector<T>(entries)) {}
  SharedTable(const SharedTable&) = default;
  SharedTable& operator=(const SharedTable&) = default;
  // What is moved from is empty.
  SharedTable(SharedTable&& other) noexcept
      : chunks_(std::move(other.chunks_)), size_(std::exchange(other.size_, 0)) {}
  SharedTable& operator=(SharedTable&& other) noexcept {
    chunks_ = std::exchange(other.chunks_, {});
    size_ = std::exchange(other.size_, 0);
    return *this;
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](std::size_t i) const { return (*chunks_[i / kChunk])[i % kChunk]; }
  const T& at(std::size_t i) const { return chunks_.at(i / kChunk)->at(i % kChunk); }
  const T& back() const { return (*this)[size_ - 1]; }
  const_iterator begin() const { return {*this, 0}; }
  const_iterator end() const { return {*this, size_}; }

  // Puts one entry, for a chunk's price; where there are many, use an Editor.
  void set(std::size_t i, T entry) {
    auto chunk = std::make_shared<std::vector<T>>(*chunks_[i / kChunk]);
    (*chunk)[i % kChunk] = std::move(entry);
    chunks_[i / kChunk] = std::move(chunk);
  }

  // Calls f with the number of each entry whose chunk `other` does not share. Entries that are
  // equal may be among them.
  template <class F>
  void for_each_apart(const SharedTable& other, const F& f) const {
    for_each_where(
        [&](std::size_t k) { return k >= other.chunks_.size() || chunks_[k] != other.chunks_[k]; },
        f);
  }

 private:
  using Chunk = std::vector<T>;

  template <class Is, class F>
  void for_each_where(const Is& is_wanted, const F& f) const {
    for (std::size_t k = 0; k < chunks_.size(); ++k) {
      if (!is_wanted(k)) continue;
      for (std::size_t i = 0; i < chunks_[k]->size(); ++i) f(k * kChunk + i);
    }
  }

  std::vector<std::shared_ptr<const Chunk>> chunks_;  // all of kChunk entries but the last
  std::size_t size_ = 0;
};

template <class T>
class SharedTable<T>::const_iterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = T;
  using difference_type = std::ptrdiff_t;
  using pointer = const T*;
  using reference = const T&;

  const_iterator(const SharedTable& table, std::size_t at) : table_(&table), at_(at) {}
  const T& operator*() const { return (*table_)[at_]; }
  const T* operator->() const { return &(*table_)[at_]; }
  const_iterator& operator++() {
    ++at_;
    return *this;
  }
  const_iterator operator++(int) { return {*table_, at_++}; }
  bool operator==(const const_iterator& other) const { return at_ == other.at_; }

 private:
  const SharedTable* table_;
  std::size_t at_;
};

// Makes a version of a table. A chunk is copied when the first of its entries is changed.
template <class T>
class SharedTable<T>::Editor {
 public:
  Editor() = default;
  explicit Editor(SharedTable of) : table_(std::move(of)), own_(table_.chunks_.size()) {}

  std::size_t size() const { return table_.size(); }
  const T& operator[](std::size_t i) const { return table_[i]; }

  // Holds until the next change of size.
  T& edit(std::size_t i) { return (*own(i / kChunk))[i % kChunk]; }

  // New entries are T().
  void resize(std::size_t size) {
    table_.size_ = size;
    table_.chunks_.resize((size + kChunk - 1) / kChunk);
    own_.resize(table_.chunks_.size());
    for (std::size_t k = 0; k < own_.size(); ++k) {
      const std::size_t wanted = std::min(kChunk, size - k * kChunk);
      if (!table_.chunks_[k]) table_.chunks_[k] = own_[k] = std::make_shared<Chunk>();
      if (table_.chunks_[k]->size() != wanted) own(k)->resize(wanted);
    }
  }

  SharedTable finish() {
    own_.clear();
    return std::exchange(table_, {});
  }

 private:
  Chunk* own(std::size_t k) {
    if (!own_[k]) {
      own_[k] = std::make_shared<Chunk>(*table_.chunks_[k]);
      table_.chunks_[k] = own_[k];
    }
    return own_[k].get();
  }

  SharedTable table_;
  std::vector<std::shared_ptr<Chunk>> own_;  // by chunk; null: shared with other tables
};

// Remembers which chunks a table had, and keeps none of its entries.
template <class T>
class SharedTable<T>::Trace {
 public:
  Trace() = default;
  explicit Trace(const SharedTable& of) : chunks_(of.chunks_.begin(), of.chunks_.end()) {}

  // Calls f with the number of each entry of `table` whose chunk the table of this trace had not.
  template <class F>
  void for_each_apart(const SharedTable& table, const F& f) const {
    table.for_each_where(
        [&](std::size_t k) {
          return k >= chunks_.size() || chunks_[k].owner_before(table.chunks_[k]) ||
                 table.chunks_[k].owner_before(chunks_[k]);
        },
        f);
  }

 private:
  std::vector<std::weak_ptr<const Chunk>> chunks_;  // hold addresses, so that none is used again
};

}  // namespace tessera
