// SPDX-License-Identifier: Apache-2.0
// What varnish keeps of the light that facets below it reflect, by angle and both roughnesses
// (slave/core/bsdf/layered-inl.h uses it). With A(w) the albedo of varnish of weight 1 seen from w,
// it passes what facets reflect from one direction into another as 1 minus the greater A of both.
// From direction w they then lose, beside A(w) of what they reflect, the mean over all others of
// what they reflect there times max(0, A - A(w)): that is the table's value, for the two terms of
// the facets' albedo. Weights of varnish below 1 take their share of it.
//
// The table is computed at the first use, from the points and with the operations of AlbedoTable,
// so its bits are the same on every machine. It has 32 x 16 x 32 nodes, of the roughness below, of
// that of the varnish and of the root of the cosine, and is linear in all three. Facets of varnish
// and of what is below it have a table as AlbedoTable of 64 x 64 nodes: of a roughness of 0.05 its
// nodes make 1.2 % too much at grazing angles.
//
// Threads. Filled once by whoever asks first (a static), then read by any thread.
#pragma once

#include <array>

#include "slave/core/bsdf/albedo_table.h"

namespace tessera::core {

class CoatTable {
 public:
  static constexpr int kCosines = AlbedoTable::kNodes;
  static constexpr int kBases = 32, kCoats = 16;  // nodes of both roughnesses
  static constexpr int kAlbedoNodes = 64;

  static const CoatTable& shared();
  // A view of a table of zeros, for surfaces without varnish.
  static CoatView none();

  CoatView view() const {
    return {facets(), &regained_[0][0][0].scale, &means_[0][0], kBases, kCoats, kCosines};
  }

  // Of facets; the albedo of varnish is kCoatF0 scale + bias.
  AlbedoView facets() const { return {&facets_[0][0].scale, &facet_means_[0].scale, kAlbedoNodes}; }

 private:
  CoatTable();
  void fill(std::size_t base);

  template <class T>
  using OfCosines = std::array<T, kCosines>;
  template <class T>
  using OfCoats = std::array<T, kCoats>;

  // [roughness][root of cosine]
  std::array<std::array<SpecularAlbedo, kAlbedoNodes>, kAlbedoNodes> facets_;
  std::array<SpecularAlbedo, kAlbedoNodes> facet_means_;
  OfCoats<OfCosines<float>> albedo_;  // of varnish
  std::array<OfCoats<OfCosines<SpecularAlbedo>>, kBases> regained_;
  std::array<OfCoats<CoatMeans>, kBases> means_;
};

}  // namespace tessera::core
