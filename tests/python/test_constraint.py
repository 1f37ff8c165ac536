# SPDX-License-Identifier: Apache-2.0
"""User constraints with a Python function: the same physics as the built-in ones."""
import numpy as np
import pytest
from conftest import G, chain, cloth, distance, scene_of

import malha


def pairs_of(links):
    return np.array([[i, i + 1] for i in range(links)])


@pytest.mark.parametrize("compliance", [None, 1e-4])
@pytest.mark.parametrize("iterations", [1, 5])
def test_a_rod_swings_as_by_the_built_in_distance(compliance, iterations):
    """One constraint has only one order, so that only rounding differs, which a swing does not amplify."""
    kind = {"type": "distance"} | ({} if compliance is None else {"compliance": compliance})
    built = malha.Simulation(scene_of(chain(1, 0.5, [kind]), iterations=iterations))
    own = malha.Simulation(scene_of(chain(), iterations=iterations),
                           constraints=[malha.Constraint([[0, 1]], distance(0.5), compliance or 0.0, check=True)])
    built.step(100), own.step(100)
    np.testing.assert_allclose(own.positions, built.positions, atol=1e-10)
    assert own.measure()["elastic_energy_j"] == pytest.approx(built.measure()["elastic_energy_j"], abs=1e-10)


def test_a_cloth_hangs_as_by_the_built_in_distance():
    """Colours differ, so each sweep leaves another error; both come to rest at the same sheet."""
    body = cloth(cells=5, constraints=[{"type": "distance", "elements": ["edges"]}])
    built = malha.Simulation(scene_of(body, substeps=20, solver={"levels": "off"}), threads=1)
    faces = built.faces
    edges = np.unique(np.sort(np.concatenate([faces[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1), axis=0)
    own = malha.Simulation(scene_of(body | {"constraints": []}, substeps=20, solver={"levels": "off"}), threads=1,
                           constraints=[malha.Constraint(edges, distance(np.full(len(edges), 0.2)))])
    for _ in range(400):
        for run in (built, own):
            run.step()
            run.velocities = 0.97 * run.velocities
    assert np.abs(own.constraint_values()).max() < 2e-3, "1 % of an edge"
    np.testing.assert_allclose(own.positions, built.positions, atol=0.01)


def test_a_weight_hangs_by_its_compliance():
    body = malha.body([[0, 0, 0], [0, -1, 0]], mass=4, pins=[0])
    run = malha.Simulation(scene_of(body, dt=0.05, substeps=1),
                           constraints=[malha.Constraint([[0, 1]], distance(1.0), 1e-3)])
    run.step(1200)
    assert run.constraint_values(0) == pytest.approx([2 * G * 1e-3], abs=1e-9), "m g alpha"
    assert run.measure()["elastic_energy_j"] == pytest.approx((2 * G) ** 2 * 1e-3 / 2, abs=1e-9)


def test_an_oscillator_keeps_its_period():
    """Two masses of 1 kg on a spring: omega = sqrt(2 k / m). Backward Euler's substeps of 0.05 ms damp it by 1 %."""
    body = malha.body([[0, 0, 0], [1.1, 0, 0]], mass=2)
    run = malha.Simulation(scene_of(body, gravity=(0, 0, 0), substeps=200),
                           constraints=[malha.Constraint([[0, 1]], distance(1.0), 1 / 50)])
    stretch = []
    run.step(63, callback=lambda s: stretch.append(s.constraint_values()[0]))
    period = 2 * np.pi / np.sqrt(2 * 50)
    expected = 0.1 * np.cos(2 * np.pi * 0.01 * np.arange(1, 64) / period)
    np.testing.assert_allclose(stretch, expected, atol=0.003)


def test_a_new_idea_keeps_an_area():
    """k = 3: the area of a triangle, which no built-in constraint has."""

    def area(x, which):
        a, b, c = x[:, 0], x[:, 1], x[:, 2]
        normal = np.cross(b - a, c - a)
        size = np.linalg.norm(normal, axis=1)
        n = normal / size[:, None]
        ga, gb, gc = np.cross(n, c - b) / 2, np.cross(n, a - c) / 2, np.cross(n, b - a) / 2
        return size / 2 - 0.5, np.stack([ga, gb, gc], axis=1)

    body = malha.body([[0, 0, 0], [2, 0, 0], [0, 1, 0]], mass=3)
    run = malha.Simulation(scene_of(body, gravity=(0, 0, 0)), constraints=[malha.Constraint([[0, 1, 2]], area, check=True)])
    run.step(50)
    assert run.constraint_values() == pytest.approx([0], abs=1e-9)
    momentum = run.velocities.sum(axis=0)
    np.testing.assert_allclose(momentum, 0, atol=1e-9)


def test_functions_get_batches_that_share_no_particle():
    seen = []

    def function(x, which):
        assert x.shape == (len(which), 2, 3) and x.dtype == np.float64
        seen.append(which.tolist())
        return distance(0.5)(x, which)

    run = malha.Simulation(scene_of(chain(4), substeps=1), constraints=[malha.Constraint(pairs_of(4), function)])
    run.step()
    assert seen == 2 * [[0, 2], [1, 3]], "where the substep began, then where it went"
    assert run.plan()["constraints"] == [{"type": "user", "name": "user", "count": 4, "particles": 2, "batches": 2}]


@pytest.mark.parametrize("precision", ["float", "double"])
def test_bodies_that_it_does_not_touch_keep_their_bits_or_with_levels_their_places(precision):
    for cells, levels in ((12, "off"), (60, "off"), (60, "auto")):
        scene = scene_of(cloth("left"), cloth("right", cells=cells, x=3.0), precision=precision, solver={"levels": levels})
        alone, run = malha.Simulation(scene, threads=1), malha.Simulation(
            scene, threads=1, constraints=[malha.Constraint([[100, 101]], distance(0.3))])
        alone.step(10), run.step(10)
        if levels == "off":
            assert np.array_equal(run.positions[169:], alone.positions[169:])
        else:
            assert alone.plan()["levels"]
            np.testing.assert_allclose(run.positions[169:], alone.positions[169:], atol=1e-10 if precision == "double" else 1e-3)


def test_threads_give_the_same_bits_and_other_bodies_keep_theirs():
    bodies = cloth("left"), cloth("right", x=3.0)
    hashes = set()
    alone = malha.Simulation(scene_of(*bodies, precision="float"), threads=1)
    alone.step(20)
    for threads in (1, 2):
        run = malha.Simulation(scene_of(*bodies, precision="float"), threads=threads,
                               constraints=[malha.Constraint([[156, 168]], distance(0.3))])
        run.step(20)
        hashes.add(run.state_hash)
        assert np.array_equal(run.positions[169:], alone.positions[169:])
        assert not np.array_equal(run.positions[:169], alone.positions[:169])
    assert len(hashes) == 1


def test_a_wrong_gradient_is_found():
    def wrong(x, which):
        C, gradient = distance(0.5)(x, which)
        gradient[which == 1, 1, 0] *= 1.01
        return C, gradient

    constraint = malha.Constraint(pairs_of(2), wrong, check=True, name="rod")
    said = r"constraint 'rod': gradient of constraint 1 by x of its particle 1: found 1.01; allowed: what finite"
    with pytest.raises(malha.InputError, match=said):
        malha.Simulation(scene_of(chain(2)), constraints=[constraint])
    with pytest.raises(malha.InputError, match=said):
        constraint.check([[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    malha.Constraint(pairs_of(2), distance(0.5)).check(np.arange(9).reshape(3, 3) ** 2)


@pytest.mark.parametrize("result, said", [
    (lambda C, g: C, "found a function that gives no pair; allowed: one that gives (C, gradient)"),
    (lambda C, g: (C[:0], g), "C: found an array of shape (0,); allowed: an array (1,)"),
    (lambda C, g: (C, g[:, :1]), "gradient: found an array of shape (1, 1, 3); allowed: an array (1, 2, 3)"),
    (lambda C, g: (C * np.nan, g), "C: found nan in constraint 0; allowed: finite numbers"),
    (lambda C, g: (C, np.full_like(g, np.inf)), "gradient: found inf in constraint 0; allowed"),
    (lambda C, g: ("no", g), "C: found what is no array of numbers; allowed: an array (1,)"),
])
def test_what_a_function_may_not_give_is_refused(result, said):
    run = malha.Simulation(scene_of(chain()), constraints=[
        malha.Constraint([[0, 1]], lambda x, which: result(*distance(0.5)(x, which)), name="rod")])
    before = run.state_hash
    with pytest.raises(malha.InputError) as caught:
        run.step()
    assert str(caught.value).startswith("constraint 'rod'") and said in str(caught.value)
    assert run.state_hash == before and run.steps == 0


def test_exceptions_of_a_function_come_through():
    def broken(x, which):
        raise LookupError("no such thing")

    run = malha.Simulation(scene_of(chain()), constraints=[malha.Constraint([[0, 1]], broken)])
    with pytest.raises(LookupError, match="no such thing"):
        run.step()
    assert run.steps == 0


def test_a_function_cannot_use_its_simulation():
    runs = []

    def nosy(x, which):
        return runs[0].positions

    runs.append(malha.Simulation(scene_of(chain()), constraints=[malha.Constraint([[0, 1]], nosy)]))
    with pytest.raises(RuntimeError, match="not done yet"):
        runs[0].step()
    runs.clear()


@pytest.mark.parametrize("particles, said", [
    ([[0, 9]], "particle 9 in constraint 0; allowed: 0 to 1"),
    ([[1, 1]], "particle 1 twice in constraint 0; allowed: different ones"),
])
def test_constraints_on_no_particles_are_refused(particles, said):
    with pytest.raises(malha.InputError, match=said):
        malha.Simulation(scene_of(chain()), constraints=[malha.Constraint(particles, distance(1.0))])


def test_arguments_of_another_kind_are_refused():
    with pytest.raises(malha.InputError, match=r"found an array of shape \(2,\); allowed: an array \(M, k\)"):
        malha.Constraint([0, 1], distance(1.0))
    with pytest.raises(malha.InputError, match="whole numbers"):
        malha.Constraint([[0.5, 1]], distance(1.0))
    with pytest.raises(malha.InputError, match="constraints: found \"str\"; allowed"):
        malha.Simulation(scene_of(chain()), constraints=["no"])
    with pytest.raises(IndexError):
        malha.Simulation(scene_of(chain())).constraint_values(0)
    for function in (None, 5):
        with pytest.raises(malha.InputError, match="function: found a value of type"):
            malha.Constraint([[0, 1]], function)
    with pytest.raises(malha.InputError, match="compliance: found -1; allowed: numbers >= 0"):
        malha.Constraint([[0, 1]], distance(1.0), -1)
    assert len(malha.Constraint(pairs_of(3), distance(1.0))) == 3
