# SPDX-License-Identifier: Apache-2.0
"""Objects of the environment that a program moves between steps."""
import numpy as np
import pytest
from conftest import scene_of

import malha

POINTS = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1.0]])


def plate(**more):
    return {"name": "plate", "shape": {"box": {"size": [2, 0.2, 2]}}, "transform": {"translate": [0, -0.1, 0]}} | more


def skin():
    return {"name": "skin", "shape": malha.shape(POINTS, faces=[[0, 3, 2, 1]]), "sides": "one_sided", "thickness": 0.01,
            "animation": {"from_code": True}}


def tied(to):
    """A particle above an object, to which it is attached."""
    return malha.body([[0.5, 0.3, 0.25]], mass=1, attachments=[{"at": {"particles": [0]}, "to": {"environment": to}}])


def run_of(thing):
    return malha.Simulation(scene_of(tied(thing["name"]), gravity=(0, 0, 0), environment=[thing]), threads=1)


def test_a_pose_is_reached_at_the_end_of_the_step():
    run = run_of(plate())
    run.set_pose("plate", translate=[0, 1, 0], axis=[0, 0, 1], degrees=90)
    run.step()
    np.testing.assert_allclose(run.positions, [[-0.3, 1.5, 0.25]], atol=1e-12)
    run.step(3)
    np.testing.assert_allclose(run.positions, [[-0.3, 1.5, 0.25]], atol=1e-12, err_msg="it rests there")


def test_a_matrix_says_the_same():
    matrix = np.array([[0, -1, 0, 0], [1, 0, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]])
    by_matrix, by_axis = run_of(plate()), run_of(plate())
    by_matrix.set_pose("plate", matrix=matrix)
    by_axis.set_pose("plate", [0, 1, 0], [0, 0, 1], 90)
    by_matrix.step(), by_axis.step()
    np.testing.assert_allclose(by_matrix.positions, by_axis.positions, atol=1e-12)


@pytest.mark.parametrize("arguments, said", [
    ({"object": "plat"}, "did you mean 'plate'?"),
    ({"object": "plate", "axis": [0, 0, 0], "degrees": 1}, "an axis of length zero"),
    ({"object": "plate", "translate": [0, np.nan, 0]}, "numbers up to 1e18"),
    ({"object": "plate", "matrix": np.eye(3)}, "found an array of shape (3, 3); allowed: an array (4, 4)"),
    ({"object": "plate", "matrix": 2 * np.eye(4)}, "found a scale, a shear, a mirror"),
    ({"object": "plate", "matrix": np.diag([1, 1, -1, 1])}, "found a scale, a shear, a mirror"),
    ({"object": "plate", "matrix": np.eye(4), "degrees": 3}, "found a matrix beside a translation or a rotation"),
])
def test_other_poses_are_refused(arguments, said):
    run = run_of(plate())
    with pytest.raises(malha.InputError) as caught:
        run.set_pose(**arguments)
    assert said in str(caught.value)


def test_vertices_are_reached_at_the_end_of_the_step():
    run = run_of(skin())
    run.set_vertices("skin", POINTS + [0, 0.25, 0])
    run.step()
    np.testing.assert_allclose(run.positions, [[0.5, 0.55, 0.25]], atol=1e-12)
    np.testing.assert_allclose(run.velocities, [[0, 25, 0]], atol=1e-9)
    run.set_vertices("skin", POINTS[:, [1, 0, 2]])  # it stands upright, and its normal points to -x
    run.step()
    np.testing.assert_allclose(run.positions, [[-0.3, 0.5, 0.25]], atol=1e-12)
    assert run.measure()["max_pinched"] == 0


@pytest.mark.parametrize("name, positions, said", [
    ("skin", POINTS[:3], "found 3 rows; allowed: 4, one a vertex of the object"),
    ("skin", POINTS[:, :2], "found an array of shape (4, 2); allowed: an array (N, 3)"),
    ("skin", np.full((4, 3), np.inf), "numbers up to 1e18"),
    ("plate", POINTS, "whose vertices the scene moves"),
])
def test_other_vertices_are_refused(name, positions, said):
    run = malha.Simulation(scene_of(tied("skin"), environment=[skin(), plate(transform={"translate": [0, -9, 0]})]))
    with pytest.raises(malha.InputError) as caught:
        run.set_vertices(name, positions)
    assert said in str(caught.value)


def test_a_callback_of_a_step_moves_objects_for_the_next():
    run = run_of(plate())
    run.step(5, callback=lambda s: s.set_pose("plate", [0.1 * s.steps, 0, 0]))
    assert run.positions[0, 0] == pytest.approx(0.5 + 0.4)
