# SPDX-License-Identifier: Apache-2.0
"""Forces on particles, other scenes between steps, and copies into arrays of the caller."""
import numpy as np
import pytest
from conftest import G, cloth, scene_of

import malha


def test_forces_act_until_others_are_set():
    run = malha.Simulation(scene_of(malha.body([[0, 0, 0], [1, 0, 0]], mass=2), gravity=(0, 0, 0), dt=0.1))
    run.set_forces([[0, 3, 0], [0, 0, 0]])
    run.step(10)
    np.testing.assert_allclose(run.velocities, [[0, 3, 0], [0, 0, 0]], atol=1e-12)
    run.set_forces(None)
    run.step(10)
    np.testing.assert_allclose(run.velocities, [[0, 3, 0], [0, 0, 0]], atol=1e-12)


def test_forces_can_be_the_weight():
    by_gravity, by_forces = malha.Simulation(scene_of(cloth())), malha.Simulation(scene_of(cloth(), gravity=(0, 0, 0)))
    w = by_forces.inverse_masses
    by_forces.set_forces(np.where(w > 0, -G / np.where(w > 0, w, 1), 0)[:, None] * np.array([0, 1, 0]))
    by_gravity.step(30), by_forces.step(30)
    assert by_gravity.positions[:, 1].min() < -0.2
    np.testing.assert_allclose(by_forces.positions, by_gravity.positions, atol=1e-9)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_copies_go_into_arrays_of_the_caller(dtype):
    run = malha.Simulation(scene_of(cloth()))
    run.step(20)
    out = np.zeros((169, 3), dtype)
    assert run.copy_positions(out=out) is out
    np.testing.assert_array_equal(out, run.positions.astype(dtype))
    np.testing.assert_array_equal(run.copy_velocities(out), run.velocities.astype(dtype))
    np.testing.assert_allclose(np.linalg.norm(run.copy_normals(out), axis=1), 1, atol=1e-6)
    vertices = np.full((169, 8), 7, dtype)  # of a renderer: a place, a normal, and two numbers more
    run.copy_positions(vertices[:, :3]), run.copy_normals(vertices[:, 3:6])
    np.testing.assert_array_equal(vertices[:, :3], run.positions.astype(dtype))
    np.testing.assert_array_equal(vertices[:, 3:6], out)
    assert (vertices[:, 6:] == 7).all()


@pytest.mark.parametrize("wrong", [np.zeros((168, 3)), np.zeros((169, 3), np.int32), np.zeros((3, 169)).T,
                                   np.zeros((169, 6))[:, ::2], np.zeros((338, 3))[::-2]])
def test_other_arrays_are_refused(wrong):
    run = malha.Simulation(scene_of(cloth()))
    with pytest.raises(malha.InputError, match=r"copy_positions: out: found an array of shape .* allowed: a writeable "
                                               r"array \(169, 3\) of float32 or float64 in C order, or columns"):
        run.copy_positions(wrong)
    read_only = np.zeros((169, 3))
    read_only.setflags(write=False)
    with pytest.raises(malha.InputError):
        run.copy_normals(read_only)
    with pytest.raises(malha.InputError, match="forces: found 1 row; allowed: 169, one a particle"):
        run.set_forces([[0, 0, 0]])


def test_another_scene_keeps_the_bodies_that_stay():
    run = malha.Simulation(scene_of(cloth("a"), cloth("b", x=2)))
    run.step(20)
    kept, velocities = run.positions[169:], run.velocities[169:]
    run.scene = scene_of(cloth("b", x=2, mass=0.4), cloth("c", x=4))
    np.testing.assert_array_equal(run.positions[:169], kept)
    np.testing.assert_array_equal(run.velocities[:169], velocities)
    assert [body.name for body in run.bodies] == ["b", "c"] and run.steps == 20
    free = run.inverse_masses[:169] > 0
    assert (1 / run.inverse_masses[:169][free]).sum() == pytest.approx(0.4 * free.mean(), rel=0.02)
    run.step()


def test_a_material_changes_between_steps():
    run = malha.Simulation(scene_of(cloth()))
    run.step(20)
    before = run.positions
    scene = run.scene.to_dict()
    scene["bodies"][0]["constraints"][0] = {"type": "distance", "elements": ["edges", "shear"], "compliance": 1e-3}
    run.scene = scene
    np.testing.assert_array_equal(run.positions, before)
    run.step(50)
    assert run.measure()["strain_max"] > 0.01, "it gives way now"
