// SPDX-License-Identifier: Apache-2.0
// SurfacePoints that get light samples, virtual lights and photons.
#include "lucarium/services/light_at_points/surface_points.cl"

// Behind what it uses.
#include "lucarium/services/light_at_points/photon_density.clh"
