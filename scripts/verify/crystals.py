"""Writes what plates of crystals reflect and let through by pyElli, an independent solver (Berreman's 4 × 4 matrices).

Usage: crystals.py COUNT FILE

A line is a plate between two isotropic media: the indices before and behind it, its three principal indices, the first two
of its axes (the surface's normal, along the way of the light, is z), N_x of the light, the thickness in wavelengths; then
the amplitudes r of the half-space of the crystal, and r and t of the plate, each as ss, sp, ps, pp (from the first to the second)
with real and imaginary part. Amplitudes are in units of power, E_s along y and E_p along y × N.
"""

import sys

import elli
import numpy as np

KINDS = [
    [1.65835, 1.65835, 1.48640],
    [1.925, 1.925, 1.984],
    [1.5442, 1.5442, 1.5533],
    [2.6, 2.6, 2.9],
    [1.654, 1.671, 1.689],
    [1.61, 1.6103, 1.62],
    [1.5, 1.9, 2.4],
    [1.7, 1.70001, 1.700015],
]
NM = 550.0


class Tensor(elli.materials.Material):
    """A crystal by its permittivity."""

    def __init__(self, permittivity):
        self.permittivity = permittivity

    def get_tensor(self, lbda):
        return np.tile(self.permittivity.astype(complex), (np.size(lbda), 1, 1))


class Solver(elli.Solver4x4):
    """pyElli's, with the waves of a half-space sorted by the flow of their energy: its own order follows the rounding of
    imaginary parts, and its r is above 1 in one case of some hundreds."""

    @staticmethod
    def transition_matrix_halfspace(delta):
        _, waves = np.linalg.eig(delta[0])
        flow = (waves[0] * waves[3].conj() - waves[1] * waves[2].conj()).real
        return waves[:, np.argsort(-flow)[[0, 2, 1, 3]]][None]


def isotropic(index):
    return elli.IsotropicMaterial(elli.ConstantRefractiveIndex(index))


def amplitudes(matrix):
    """ss, sp, ps, pp (from, to); pyElli has pp and ps, sp and ss (to, from)."""
    (pp, sp), (ps, ss) = matrix[0]
    return [ss, sp, ps, pp]


def solve(before, layers, behind, angle):
    structure = elli.Structure(isotropic(before), layers, behind)
    propagator = elli.solver4x4.PropagatorEig()
    return structure.evaluate(np.array([NM]), angle, solver=Solver, propagator=propagator)


def case(random):
    kind = KINDS[random.integers(len(KINDS))]
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    permittivity = (axes * np.square(kind)) @ axes.T
    before, behind = [1.0, 1.33, 1.9, 2.7][random.integers(4)], [1.0, 1.5, 2.7][random.integers(3)]
    # All modes propagate, and nothing is grazing; behind the plate reflection may be total.
    limit = 0.97 * min(before, min(kind))
    q = limit * random.uniform()
    if abs(q - behind) < 0.03 * behind:
        return case(random)
    thickness = random.uniform(0.3, 3.0)
    angle = np.degrees(np.arcsin(q / before))
    crystal = Tensor(permittivity)
    half = solve(before, [], crystal, angle)
    plate = solve(before, [elli.Layer(crystal, thickness * NM)], isotropic(behind), angle)
    z = [np.sqrt(complex(n * n - q * q)) for n in (before, behind)]
    power = np.sqrt(z[1].real / z[0].real)
    inputs = [before, behind, *kind, *axes[:, 0], *axes[:, 1], q, thickness]
    outputs = [*amplitudes(half.jones_matrix_r), *amplitudes(plate.jones_matrix_r), *amplitudes(power * plate.jones_matrix_t)]
    return [f"{x:.16g}" for x in inputs] + [f"{y:.11f}" for x in outputs for y in (x.real, x.imag)]


def main():
    count, path = int(sys.argv[1]), sys.argv[2]
    random = np.random.default_rng(1)
    with open(path, "w", encoding="ascii") as file:
        for _ in range(count):
            file.write(" ".join(case(random)) + "\n")


main()
