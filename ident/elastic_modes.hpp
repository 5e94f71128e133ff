#pragma once

#include "fem/harmonic.hpp"
#include "ident/pairing.hpp"

namespace struna::ident {

/// The elastic modes, which alone resonate, and how many rigid ones come before them.
struct ElasticModes {
  fem::Eigenmodes eigenmodes;  ///< of the mesh
  ModelModes modes;            ///< eigenvalues freed of the mesh's error, constants
  int rigid = 0;
};

/// Those of the model's lowest `count` modes.
ElasticModes elastic_modes(const fem::Model& model, const fem::Drive& drive,
                           const fem::Measurement& measurement, int count);

/// Modes to solve for when so many were measured: missing ones, out-of-plane ones that the drive hardly
/// reaches, and room above the band.
int modes_to_solve(std::size_t measured);

/// The eigenvalue that an infinitely fine mesh would have. A mesh of cubic elements of length h is too stiff
/// in bending: f_h/f - 1 = (b h)^4/1440, b^4 = rho A omega^2/(E I); left in, it would read as a modulus that
/// is too low (0.2 % at ten elements per three half waves). It is for bending modes; axial and torsional ones
/// lie above the bands that are measured.
double without_mesh_error(double eigenvalue, const fem::Model& model);

}  // namespace struna::ident
