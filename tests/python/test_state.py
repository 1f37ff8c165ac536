# SPDX-License-Identifier: Apache-2.0
"""State of a simulation: arrays, setters between steps, checkpoints, reports."""
import json

import numpy as np
import pytest
from conftest import ROOT, G, chain, cloth, scene_of

import malha


def loose(**more):
    return malha.body([[0, 0, 0], [1, 0, 0]], mass=2, **more)


def test_arrays_have_their_shapes_and_cannot_be_written_to(simulation):
    for array in (simulation.positions, simulation.velocities):
        assert array.shape == (169, 3) and array.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    assert simulation.faces.shape == (144, 4) and simulation.faces.dtype == np.int32
    assert simulation.triangles.shape == (288, 3) and simulation.lines.shape == (0, 2)
    assert simulation.inverse_masses.shape == (169,)
    assert np.flatnonzero(simulation.inverse_masses == 0).tolist() == [0, 12]
    before = simulation.positions
    simulation.step()
    assert not np.array_equal(before, simulation.positions), "an array is of its own moment"


def test_positions_and_velocities_are_set_between_steps():
    run = malha.Simulation(scene_of(loose(), gravity=(0, 0, 0), dt=0.1))
    run.positions = [[1, 2, 3], [4, 5, 6]]
    run.velocities = np.array([[1, 0, 0], [0, 0, -2]], dtype=np.float32)
    assert run.positions.tolist() == [[1, 2, 3], [4, 5, 6]]
    run.step(10)
    np.testing.assert_allclose(run.positions, [[2, 2, 3], [4, 5, 4]], atol=1e-12)
    assert run.time == pytest.approx(1)


@pytest.mark.parametrize("name", ["positions", "velocities"])
@pytest.mark.parametrize("wrong, said", [
    ([[0, 0, 0]], "{}: found 1 row; allowed: 2, one a particle"),
    ([[0, 0], [0, 0]], "{}: found an array of shape (2, 2); allowed: an array (N, 3)"),
    ([[0, 0, 0], [np.inf, 0, 0]], "{}: row 1: found inf; allowed: numbers up to 1e18"),
])
def test_other_arrays_are_refused(name, wrong, said):
    run = malha.Simulation(scene_of(loose()))
    before = run.state_hash
    with pytest.raises(malha.InputError) as caught:
        setattr(run, name, wrong)
    assert str(caught.value) == said.format(name) and run.state_hash == before


def test_gravity_is_set_between_steps():
    run = malha.Simulation(scene_of(loose(), gravity=(0, 0, 0)))
    run.step(10)
    run.gravity = (0, -G, 0)
    assert run.gravity == (0, -G, 0) and run.scene.to_dict()["gravity"] == [0, -G, 0]
    run.step(100)
    np.testing.assert_allclose(run.velocities[:, 1], -G, rtol=1e-12)
    with pytest.raises(malha.InputError, match="gravity: found an array of shape"):
        run.gravity = (1, 2)


def test_wind_is_set_between_steps():
    run = malha.Simulation(scene_of(loose(), gravity=(0, 0, 0), wind={"velocity": [0, 0, 0], "drag": 10}))
    assert run.wind == (0, 0, 0)
    run.step(10)
    assert np.all(run.velocities == 0)
    run.wind = (3, 0, 0)
    run.step(100)
    np.testing.assert_allclose(run.velocities[:, 0], 3, rtol=1e-3)
    still = malha.Simulation(scene_of(loose()))
    assert still.wind is None
    with pytest.raises(malha.InputError, match="set_wind: found a scene without wind"):
        still.wind = (1, 0, 0)


def test_pins_are_set_between_steps(simulation):
    assert simulation.pins.tolist() == [0, 12] and simulation.pins.dtype == np.int32
    simulation.step(5)
    x = simulation.positions
    simulation.pins = [90]
    simulation.step(5)
    assert simulation.pins.tolist() == [90] and simulation.positions[90].tolist() == x[90].tolist()
    assert simulation.positions[0, 1] < x[0, 1], "it falls"
    with pytest.raises(malha.InputError, match="pins: found particle 169; allowed: 0 to 168"):
        simulation.pins = [169]
    with pytest.raises(malha.InputError, match="pins: found what is no array of whole numbers"):
        simulation.pins = [0.5]
    with pytest.raises(malha.InputError, match=r"pins: found an array of shape \(1, 2\); allowed: an array \(N,\)"):
        simulation.pins = [[0, 1]]


@pytest.mark.parametrize("wrong", [
    np.zeros((2, 3), complex), [["0", "0", "0"]] * 2, np.zeros((2, 3), "datetime64[s]"),
    np.ma.masked_array(np.zeros((2, 3)), mask=[[1, 0, 0]] * 2), np.zeros((2, 3), bool), [[None] * 3] * 2,
])
def test_numbers_that_would_change_on_the_way_are_refused(wrong):
    run = malha.Simulation(scene_of(loose(), wind={"velocity": [0, 0, 0], "drag": 1}))
    for name, value in (("positions", wrong), ("velocities", wrong), ("gravity", wrong[0]), ("wind", wrong[0])):
        with pytest.raises(malha.InputError, match=f"{name}: found what is no array of numbers"):
            setattr(run, name, value)
    with pytest.raises(malha.InputError, match="points: found what is no array of numbers"):
        malha.body(wrong, mass=1)
    with pytest.raises(malha.InputError, match="found 18446744073709551615; allowed: whole numbers up to"):
        run.pins = np.array([2**64 - 1], dtype=np.uint64)


def test_pins_are_moved_between_steps(simulation):
    simulation.move_pins([0, 12], [[0, 1, 0], [1, 1, 0]])
    simulation.step(5)
    assert simulation.positions[[0, 12]].tolist() == [[0, 1, 0], [1, 1, 0]]
    with pytest.raises(malha.InputError, match="move_pin: found particle 5, which is not pinned"):
        simulation.move_pins(np.array([5]), [[0, 0, 0]])
    with pytest.raises(malha.InputError, match="positions of pins: found 1 row; allowed: 2, one a pin"):
        simulation.move_pins([0, 12], [[0, 0, 0]])


def test_particles_are_pulled_and_held():
    run = malha.Simulation(scene_of(cloth(), solver={"levels": "off"}), interactive=True)
    run.hold(160)
    run.pull(168, [1, 1, 1], compliance=1e-3)
    assert run.handles() == [{"particle": 160, "to": tuple(run.positions[160])},
                          {"particle": 168, "to": (1, 1, 1), "compliance": 1e-3}]
    run.step(3)
    assert run.inverse_masses[160] == 0
    run.release(160), run.release(168)
    assert run.handles() == []
    with pytest.raises(malha.InputError, match="interactive"):
        malha.Simulation(scene_of(cloth())).hold(3)


def test_a_body_that_names_tear_is_cut():
    run = malha.Simulation(scene_of(cloth(tear={"strain": 5}), solver={"levels": "off"}))
    row = 13 * 6
    assert run.cut([[row + i, row + 13 + i] for i in range(13)]) > 0
    assert len(run.positions) > 169 and run.faces.max() == len(run.positions) - 1
    run.step(2)


def test_checkpoints_and_states_go_on_with_the_same_bits(tmp_path, simulation):
    simulation.step(10)
    state = simulation.save_state()
    simulation.save_checkpoint(tmp_path / "c.malha")
    simulation.step(10)
    end = simulation.state_hash
    simulation.restore_state(state)
    simulation.step(10)
    assert simulation.state_hash == end
    other = malha.Simulation(scene_of(cloth()))
    other.load_checkpoint(str(tmp_path / "c.malha"))
    assert other.steps == 10
    other.step(10)
    assert other.state_hash == end
    with pytest.raises(malha.InputError, match="a checkpoint of another scene"):
        malha.Simulation(scene_of(cloth(cells=5))).load_checkpoint(tmp_path / "c.malha")
    with pytest.raises(malha.InputError):
        simulation.restore_state(b"nothing")


def test_measures_reports_warnings_and_plans_are_dicts(simulation):
    simulation.step(5)
    measures = simulation.measure()
    kinetic = 0.5 * np.sum((simulation.velocities**2).sum(axis=1)[simulation.inverse_masses > 0]
                           / simulation.inverse_masses[simulation.inverse_masses > 0])
    assert measures["kinetic_energy_j"] == pytest.approx(kinetic)
    assert {"strain_rms", "momentum_kg_m_per_s", "energy_j"} <= measures.keys()
    report = simulation.report()
    assert report["status"] == "running" and report["state_hash"] == simulation.state_hash
    assert report["state"] == measures and simulation.report("finished")["status"] == "finished"
    assert simulation.warnings() == []
    plan = simulation.plan()
    assert plan["particles"] == 169 and plan["constraints"][0]["type"] == "distance"
    assert plan["launches_a_step"] and plan["launches_of_first_step"] and not plan["embree"]
    assert "particles: 169" in simulation.plan_text()
    json.dumps([measures, report, plan])


def test_a_traced_step_names_the_kernels_that_it_launches(simulation):
    first = simulation.trace_step()
    assert first == simulation.report()["launches_of_first_step"] and simulation.steps == 1
    assert "SolvePatch<double>" in {launch["kernel"] for launch in simulation.trace_step()}
    assert simulation.report()["launches_of_first_step"] == first


def test_a_setting_beyond_a_boundary_is_warned_of():
    heavy = cloth(cells=60, constraints=[{"type": "distance", "stiffness": 0.01}])
    run = malha.Simulation(scene_of(heavy, substeps=1, solver={"levels": "off"}))
    assert any("body 'cloth'" in line for line in run.warnings())


def test_unmet_expectations_are_lines():
    run = malha.Simulation(scene_of(loose(), expect={"max_speed": 0.1}))
    run.step(10)
    assert len(run.failed_expectations()) == 1 and "speed" in run.failed_expectations()[0]


def test_a_scene_that_diverges_says_where(rushing):
    run = malha.Simulation(rushing)
    with pytest.raises(malha.Diverged, match=r"^diverged at step 1024 \(t = .*particle 0 of body 'rushing'") as caught:
        run.step(2000)
    assert isinstance(caught.value, ArithmeticError)
    assert run.steps == 1023
    report = run.report()
    assert report["status"] == "diverged" and "state" not in report
    with pytest.raises(malha.Diverged):
        run.step()


def test_a_diverged_simulation_can_go_back(rushing):
    run = malha.Simulation(rushing)
    state = run.save_state()
    with pytest.raises(malha.Diverged):
        run.step(2000)
    run.restore_state(state)
    assert run.step(5) == 5 and run.report()["status"] == "running"


def test_a_diverged_simulation_goes_on_from_new_positions(rushing):
    run = malha.Simulation(rushing)
    with pytest.raises(malha.Diverged):
        run.step(2000)
    with pytest.raises(malha.Diverged, match="new positions let it go on"):
        run.step()
    run.positions, run.velocities = [[0, 0, 0]], [[0, 0, 0]]
    assert run.step() == 1 and run.report()["status"] == "running"


def test_a_level_rod_swings_as_a_pendulum_does():
    rod = chain(1, 1.0, [{"type": "distance"}])
    run = malha.Simulation(scene_of(rod, substeps=50), threads=1)
    heights = []
    run.step(100, callback=lambda s: heights.append(s.positions[1, 1]))
    # Released from the horizontal, it is fastest at the bottom: v^2 = 2 g l, less the damping of implicit steps of 0.2 ms.
    lowest = int(np.argmin(heights))
    assert heights[lowest] == pytest.approx(-1, abs=2e-3)
    # A quarter of the period of 90 degrees: K(sin 45) sqrt(l / g).
    assert (lowest + 1) * 0.01 == pytest.approx(1.8540746773 / np.sqrt(G), abs=0.01)
    energy = run.measure()["kinetic_energy_j"] + run.measure()["potential_energy_j"]
    assert abs(energy) < 0.01 * G, "it began with none"


def test_shipped_scenes_have_reprs():
    scene = malha.Scene(ROOT / "scenes" / "pendulum.json")
    assert repr(scene).startswith("<malha.Scene 'pendulum'")
    run = malha.Simulation(scene)
    assert "2 particles" in repr(run) and "'rod of 1 m" in repr(run.bodies[0])


CLASSES = [one for one in vars(malha).values() if isinstance(one, type) and not issubclass(one, Exception)]


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.__name__)
def test_an_object_that_was_not_initialised_is_refused_by_all_that_takes_one(kind):
    """Derived classes may use themselves too early; X.__new__(X) is the shortest example."""
    bare, tried = kind.__new__(kind), 0
    for name, member in vars(kind).items():
        if isinstance(member, property):
            with pytest.raises(TypeError, match="not initialised"):
                getattr(bare, name)
            if member.fset:
                with pytest.raises(TypeError, match="not initialised"):
                    setattr(bare, name, [0, 0, 0])
            tried += 1
        elif callable(member) and name not in ("__init__", "__new__"):
            for count in range(4):
                with pytest.raises(TypeError):
                    getattr(bare, name)(*[0] * count)
            tried += 1
    assert tried >= 3
    for use in (lambda: malha.Simulation(bare), lambda: malha.Scene(bare), lambda: malha.run(bare, "nowhere"),
                lambda: malha.Simulation(scene_of(cloth()), constraints=[bare])):
        with pytest.raises((TypeError, malha.InputError)):
            use()


def test_a_derived_class_that_touches_itself_too_early_is_told():
    class Early(malha.Simulation):
        def __init__(self, scene):
            self.before = self.time
            super().__init__(scene)

    with pytest.raises(TypeError, match="super"):
        Early(scene_of(cloth()))

    class Late(malha.Simulation):
        def __init__(self, scene):
            super().__init__(scene)
            self.before = self.time

    assert Late(scene_of(cloth())).before == 0
