#pragma once

#include "fem/eigenmodes.hpp"
#include "fem/model.hpp"

namespace struna::fem {

// How much model a task needs: estimates of what a choice costs in accuracy, and the choices by them. docs:
// sizing.md.

/// What is to be within the tolerance: natural frequencies up to the band's end, relative; or outputs of a
/// harmonic response, on the worst line, relative to all outputs there.
enum class SizingTarget { natural_frequencies, response };

struct MeshRequest {
  double lo_hz =
      0.0;  ///< of the band; response only: with viscous damping the lightest damped line may lie anywhere
  double hi_hz = 0.0;
  double tolerance = 1e-3;
  SizingTarget target = SizingTarget::natural_frequencies;
  Damping damping = Damping::structural;  ///< response only
  bool along_axis = false;                ///< response of a straight body: driven or read along its axis
  bool contact = false;  ///< the nodes are possible contact points: eight elements, turns of 10 degrees
};

/// Estimated shares of the target's error.
struct MeshError {
  double bending = 0.0;   ///< falls as h^4
  double stretch = 0.0;   ///< stretch and torsion waves, falls as h^2
  double rounding = 0.0;  ///< grows as 1/h^4
  double total() const { return bending + stretch + rounding; }
};

/// A priori, of a mesh of `elements` equal ones:
///   bending   (b h)^4/1440 of a frequency, b^4 = rho A w^2/(E I), of the cubic elements; a curve adds
///   nothing to
///             it, as its elements are exact in statics;
///   stretch   (k h)^2/24 of a frequency, k = w sqrt(rho/E) or that of torsion, as linear elements; where the
///   band
///             reaches modes of them;
///   rounding  5e-18 n^4 of the first natural frequency, (f_1/f)^2 of it at f.
/// An output changes by |d ln H/d ln f| <= 2/eta + 2 + b L/2 times that (resonance, prescribed motion,
/// phase). Without any damping a resonance is without bound: eta counts as 1e-3 then. Throws Error on a
/// request or body that cannot be.
MeshError estimate_mesh_error(const Body& body, const MeshRequest& request, int elements);

/// Why a mesh is as fine as it is. turn: so that no element turns by more than 45 degrees; least: six
/// elements; limit: the tolerance is out of reach, as finer meshes lose more to rounding than they gain (or
/// more than 1000 elements would be needed); checked: a check on a finer mesh asked for more
/// (sized_response.hpp).
enum class MeshReason { given, bending, stretch, turn, least, limit, checked };

struct MeshChoice {
  int elements = 0;
  MeshReason reason = MeshReason::given;
  MeshError error;
  double tolerance = 0.0;
  bool within() const { return error.total() <= tolerance; }
};

/// The body's elements where it gives them, else the fewest whose estimated error is within the tolerance.
/// Throws Error where 1000 elements are not even nearly enough.
MeshChoice choose_mesh(const Body& body, const MeshRequest& request);

/// Whether the estimate of a response is sure to a factor of two or three: not where a curved body's band
/// reaches its stretch waves, whose share in the outputs only a finer mesh can tell.
bool is_sure(const Body& body, const MeshRequest& request);

/// From the difference of a response on this mesh to the one on twice the elements: a priori the error falls
/// by 16, where it is not sure by 4 at least.
double error_from_difference(double difference, bool sure);

/// Elements after a check that found `error` with `elements`: by the order that the error falls with, and at
/// most four times as many.
int refined_elements(int elements, double error, double tolerance, bool sure);

/// eta(f) or 2 zeta(f), of the damping that acts.
double acting_loss_factor(const Material& material, Damping damping, double f_hz);

/// Half-power bandwidth of the narrowest resonance in the band [Hz]; 0 when there is none, or no damping.
double narrowest_bandwidth_hz(const Body& body, Damping damping, double lo_hz, double hi_hz);

/// By how much the natural frequency at f is too high [-] without shear and rotary inertia, first order
/// (Timoshenko, Phil. Mag. 41 (1921) 744): (b r)^2 (1 + E/(kappa G))/2 with r^2 = I/A, kappa of a circle 6 (1
/// + nu)/(7 + 6 nu) (Cowper, J. Appl. Mech. 33 (1966) 335).
double beam_theory_error(const Body& body, double f_hz);

// Where linear beam theory ends.
inline constexpr double least_slenderness = 10.0;    ///< length over diameter: 3 % of the first frequency
inline constexpr double largest_shear_error = 0.03;  ///< beam_theory_error()
inline constexpr double largest_slope = 0.2;         ///< [rad]
inline constexpr double largest_stretch_stiffening = 0.05;
inline constexpr double largest_bending_strain = 0.01;

}  // namespace struna::fem
