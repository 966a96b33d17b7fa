// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "slave/core/integrate/direct/direct_integrator.h"
#include "slave/core/integrate/igi/gi_tile.h"
#include "slave/core/integrate/integrator.h"
#include "slave/core/integrate/path/path_integrator.h"
#include "slave/core/integrate/primary/primary_integrator.h"

namespace tessera::core {
namespace {

template <class T>
std::unique_ptr<Integrator> made() {
  return std::make_unique<T>();
}

constexpr std::array kIntegrators{
    IntegratorRow{Renderer::kPrimary, made<PrimaryIntegrator>},
    IntegratorRow{Renderer::kDirect, made<DirectIntegrator>},
    IntegratorRow{Renderer::kPath, made<PathIntegrator>},
    IntegratorRow{Renderer::kIgi, made<GiTile>},
};

}  // namespace

std::span<const IntegratorRow> integrators() { return kIntegrators; }

}  // namespace tessera::core
