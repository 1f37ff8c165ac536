# SPDX-License-Identifier: Apache-2.0
"""Scenes from files, texts, dicts and arrays; errors have the messages of the command."""
import copy
import json
import pickle

import numpy as np
import pytest
from conftest import ROOT, chain, cloth, said_by_command, scene_of

import malha


def test_a_scene_is_a_file_a_text_or_a_dict(tmp_path):
    given = scene_of(cloth())
    path = tmp_path / "sheet.json"
    path.write_text(json.dumps(given))
    scenes = [malha.Scene(source) for source in (path, str(path), json.dumps(given), given)]
    assert len({scene.to_json() for scene in scenes}) == 1
    assert scenes[0].name == "small" and scenes[0].duration == 1 and scenes[0].dt == 0.01
    assert malha.Scene(scenes[0].to_dict()).to_json() == scenes[0].to_json()
    assert malha.Scene(scenes[0]).name == "small"


def test_arrays_and_numbers_of_numpy_stand_for_lists():
    given = scene_of(cloth(), gravity=np.array([0, -1, 0]))
    given["bodies"][0]["mass"] = np.float32(0.5)
    assert malha.Scene(given).to_dict()["gravity"] == [0, -1, 0]


def test_maps_of_a_constraint_are_arrays_and_may_change_between_steps():
    def hung(factors):
        link = {"type": "distance", "compliance": 1e-3, "map": {"values": np.array([1, 3.0])},
                "rest_scale_map": {"values": factors}}
        return scene_of(chain(constraints=[link]), gravity=[0, -10, 0], wind={"velocity": [0, 0, 0], "drag": 10})

    simulation = malha.Simulation(hung(np.array([1.0, 1.0])))
    simulation.step(1000)
    # 1 kg by a spring of the mean stiffness, 2 / (1e-3 m/N).
    assert np.linalg.norm(simulation.positions[1]) == pytest.approx(0.5 + 10 / 2000, abs=1e-3)
    simulation.scene = hung(np.array([1.0, 0.5]))
    simulation.step(1000)
    assert np.linalg.norm(simulation.positions[1]) == pytest.approx(0.75 * 0.5 + 10 / 2000, abs=1e-3)
    with pytest.raises(malha.InputError, match="the factor 0 at vertex 1"):
        malha.Simulation(hung([1, 0]))


WRONG = [
    lambda s: s["bodies"][0].update(mass=-1),
    lambda s: s["bodies"][0].update(maas=1),
    lambda s: s.pop("solver"),
    lambda s: s["solver"].update(substeps=0.5),
    lambda s: s["bodies"][0]["shape"]["grid"].update(cells=[0, 1]),
    lambda s: s["bodies"][0]["constraints"][0].update(type="distnace"),
    lambda s: s["bodies"][0].update(pins=[{"particles": [400]}]),
]


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_a_refusal_has_the_words_of_the_command(number, tmp_path):
    scene = scene_of(cloth())
    WRONG[number](scene)
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(scene))
    status, said = said_by_command("check", path)
    assert status == 2 and "allowed: " in said
    with pytest.raises(malha.InputError) as caught:
        malha.Simulation(path)
    assert str(caught.value) == said
    with pytest.raises(malha.InputError) as caught:
        malha.Simulation(scene)
    assert str(caught.value) == said.replace(str(path), "scene")
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("gravity", [[0, float("nan"), 0], (0, float("nan"), 0), np.array([0, np.nan, 0])])
def test_a_number_that_json_lacks_is_named_by_its_place(gravity):
    with pytest.raises(malha.InputError, match="^scene: /gravity/1: found nan; allowed: finite numbers$"):
        malha.Scene(scene_of(cloth()) | {"gravity": gravity})
    endless = scene_of(cloth())
    endless["bodies"].append(endless)
    with pytest.raises(ValueError, match="Circular"):
        malha.Scene(endless)


def test_what_is_no_scene_is_refused(tmp_path):
    with pytest.raises(malha.InputError, match="cannot read: No such file"):
        malha.Scene(tmp_path / "none.json")
    with pytest.raises(malha.InputError, match="scene: found a value of type object; allowed: dicts"):
        malha.Scene({"name": object()})
    with pytest.raises(TypeError):
        malha.Scene(7)
    with pytest.raises(malha.InputError, match="folder beside a file"):
        malha.Scene(ROOT / "scenes" / "flag.json", folder="/")


def test_a_scene_too_large_for_the_memory_is_refused():
    given = scene_of(cloth())
    given["bodies"] = [cloth(f"cloth {i}") for i in range(400)]
    for body in given["bodies"]:
        body["shape"]["grid"]["cells"] = [4400, 4400]
    with pytest.raises(malha.OutOfMemory, match="needs at least .*; allowed: one that fits") as caught:
        malha.Simulation(given)
    assert isinstance(caught.value, MemoryError) and isinstance(caught.value, malha.InputError)


def square(**more):
    """A square of which nothing uses vertex 1."""
    points = np.array([[0, 0, 0], [9, 9, 9], [1, 0, 0], [0, 0, 1], [1, 0, 1]], dtype=float)
    return malha.body(points, np.array([[0, 3, 2], [2, 3, 4]]), mass=1, constraints=[{"type": "distance"}], **more)


def test_a_body_from_arrays_keeps_its_numbers_where_a_vertex_is_unused(tmp_path):
    obj = tmp_path / "square.obj"
    obj.write_text("v 0 0 0\nv 9 9 9\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 4 3\nf 3 4 5\n")
    from_file = square(pins=[3]) | {"shape": {"mesh": str(obj)}}
    runs = [malha.Simulation(scene_of(body), threads=1) for body in (square(pins=[3]), from_file)]
    for run in runs:
        run.step(50)
        (body,) = run.bodies
        assert body.vertices.tolist() == [0, -1, 1, 2, 3]
        assert run.positions[body.vertices[3]].tolist() == [0, 0, 1], "the pinned vertex stays"
        assert run.faces.tolist() == [[0, 2, 1, -1], [1, 2, 3, -1]]
        assert run.triangles.tolist() == [[0, 2, 1], [1, 2, 3]]
    assert runs[0].state_hash == runs[1].state_hash
    with pytest.raises(malha.InputError, match="unused|no face|nothing uses"):
        malha.Simulation(scene_of(square(pins=[1])))


def test_numbers_of_a_second_body_begin_behind_the_first():
    second = square(name="second", velocity=[0, 1, 0])
    run = malha.Simulation(scene_of(square(), second))
    assert [body.name for body in run.bodies] == ["body", "second"]
    assert run.bodies[1].particles == slice(4, 8, 1) and run.bodies[1].faces == slice(2, 4, 1)
    assert run.bodies[1].vertices.tolist() == [4, -1, 5, 6, 7]
    assert np.all(run.velocities[run.bodies[1].particles] == [0, 1, 0])


def test_quads_lines_tetrahedra_and_loose_points():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], dtype=float)
    quad = malha.body(corners, [[0, 1, 2, 3], [1, 4, 2]], mass=1)
    assert malha.Simulation(scene_of(quad)).faces.tolist() == [[0, 1, 2, 3], [1, 4, 2, -1]]
    listed = malha.body(corners, [[0, 1, 2, 3], [1, 4, 2, -1]], mass=1)
    assert malha.Scene(scene_of(listed)).to_json() == malha.Scene(scene_of(quad)).to_json()
    padded = malha.body(corners, np.array([[0, 1, 2, 3], [1, 4, 2, -1]]), mass=1)
    assert malha.Scene(scene_of(padded)).to_json() == malha.Scene(scene_of(quad)).to_json()
    line = malha.body(corners, lines=np.array([[0, 1], [1, 2]]), mass=1)
    assert malha.Simulation(scene_of(line)).lines.tolist() == [[0, 1], [1, 2]]
    loose = malha.body(corners, mass=1)
    assert len(malha.Simulation(scene_of(loose)).positions) == 5
    solid = malha.body(np.vstack([np.zeros(3), np.eye(3)]), tetrahedra=[[0, 1, 2, 3]], mass=1)
    assert len(malha.Simulation(scene_of(solid)).triangles) == 4
    obstacle = {"name": "tile", "shape": malha.shape(corners[:4], [[0, 1, 2, 3]]), "sides": "two_sided"}
    assert malha.Simulation(scene_of(cloth(), environment=[obstacle])).step(2) == 2


@pytest.mark.parametrize("points, faces, said", [
    (np.zeros((4, 2)), [[0, 1, 2]], "body: points: found an array of shape (4, 2); allowed: an array (N, 3)"),
    ("no", None, "body: points: found what is no array of numbers; allowed: an array (N, 3)"),
    ([[0, 0, np.nan]], None, "body: points: row 0: found nan; allowed: numbers up to 1e18"),
    (np.eye(3), np.eye(3), "body: faces: found an array of shape (3, 3) that are no whole numbers; allowed: whole numbers "
                           "(N, 3) or (N, 4)"),
    (np.eye(3), np.array([[0, 1]]), "body: faces: found an array of shape (1, 2); allowed: whole numbers (N, 3) or (N, 4)"),
])
def test_arrays_of_another_shape_are_refused(points, faces, said):
    with pytest.raises(malha.InputError) as caught:
        malha.body(points, faces, mass=1)
    assert str(caught.value) == said


def test_arrays_give_the_scene_that_their_lists_give():
    arrays = square()
    assert isinstance(arrays["shape"]["mesh_data"]["points"], np.ndarray)
    lists = arrays | {"shape": {"mesh_data": {k: v.tolist() for k, v in arrays["shape"]["mesh_data"].items()}}}
    assert malha.Scene(scene_of(arrays)).to_json() == malha.Scene(scene_of(lists)).to_json()
    assert isinstance(arrays["shape"]["mesh_data"]["points"], np.ndarray), "the dict is as it was"
    with pytest.raises(malha.InputError, match="density of loose particles"):
        malha.Scene(scene_of(malha.body(np.eye(3), density=1)))


def test_a_corner_that_is_no_point_is_refused():
    with pytest.raises(malha.InputError, match="mesh_data: faces/0: found vertex 3; allowed: 0 to 2"):
        malha.Simulation(scene_of(malha.body(np.eye(3), [[0, 1, 3]], mass=1)))


@pytest.mark.parametrize("use", [
    lambda: malha.Scene('{"name": "\ud800"}'),
    lambda: malha.Scene(scene_of(cloth("\udfff"))),
    lambda: malha.Scene(scene_of(cloth()) | {"\ud800": 1}),
    lambda: malha.Scene(scene_of(cloth()) | {"gravity": [0, float("nan"), 0], "\ud800": float("nan")}),
    lambda: malha.Scene("\ud800.json"),
    lambda: malha.Scene(scene_of(cloth()), folder="\ud800"),
    lambda: malha.Simulation(scene_of(cloth()), backend="\ud800"),
    lambda: malha.Simulation(scene_of(cloth()), **{"\ud800": 1}),
    lambda: malha.Simulation(scene_of(cloth())).report("\ud800"),
    lambda: malha.Simulation(scene_of(cloth())).save_checkpoint("\ud800"),
    lambda: malha.Constraint([[0, 1]], len, name="\ud800"),
    lambda: malha.body(np.eye(3), mass=1, name="\ud800"),
    lambda: malha.run(scene_of(cloth()), "\ud800"),
])
def test_a_text_without_utf8_is_a_value_that_is_refused(use):
    with pytest.raises(ValueError):
        use()


def test_a_path_may_have_bytes_that_are_no_text(tmp_path):
    path = tmp_path / "sheet\udcff.json"  # the byte 255
    path.write_text(json.dumps(scene_of(cloth())))
    assert malha.Scene(path).name == malha.Scene(str(path)).name == "small"


@pytest.mark.parametrize("use, named", [
    (lambda s: malha.Simulation(s, threads="two"), "threads=str"),
    (lambda s: malha.run(s, s), "dict, dict"),
    (lambda s: malha.shape([[0, 0, 0]] * 1000, points=s), "list, points=dict"),
    (lambda s: malha.Simulation(s).step("far", s), "Simulation, str, dict"),
    (lambda s: malha.Simulation.positions.fget(s), "(dict)"),
    (lambda s: malha.Body.particles.fget(s), "(dict)"),
    (lambda s: malha.Constraint([[0, 1]], len, "soft", name=s), "list, builtin_function_or_method, str, name=dict"),
])
def test_arguments_that_do_not_fit_are_named_by_their_types(use, named):
    scene = scene_of(cloth(name="a name that nobody wants to read a thousand times"))
    with pytest.raises(TypeError) as caught:
        use(scene)
    assert named in str(caught.value) and "nobody wants" not in str(caught.value)
    assert "allowed: " in str(caught.value) and len(str(caught.value)) < 500


@pytest.mark.parametrize("use, said", [
    (lambda s: malha.Simulation(s, thread=1), "malha.Simulation: found the keyword 'thread' (did you mean 'threads'?); "
     "allowed: scene, threads, backend, machine, adaptive_threads, timed_passes, interactive, constraints"),
    (lambda s: malha.Scene(s, folders=s), "malha.Scene: found the keyword 'folders' (did you mean 'folder'?); allowed: "
     "source, folder"),
    (lambda s: malha.Simulation(s).report(stat=s), "report: found the keyword 'stat'; allowed: status"),
    (lambda s: malha.Simulation(s).wake(now=True), "wake: found the keyword 'now'; allowed: none"),
    (lambda s: malha.sweep(s, {}, exectuor=1), "sweep: found the keyword 'exectuor' (did you mean 'executor'?); allowed: "
     "scene, parameters, executor, out, steps, threads, backend, progress"),
])
def test_a_keyword_that_a_function_lacks_is_answered_by_the_one_that_is_meant(use, said):
    with pytest.raises(TypeError) as caught:
        use(scene_of(cloth()))
    assert str(caught.value) == said


@pytest.mark.parametrize("copied", [lambda s: pickle.loads(pickle.dumps(s)), copy.deepcopy, copy.copy])
def test_a_copied_scene_has_the_same_bits(copied):
    points = np.random.default_rng(1).random((5, 3))
    given = scene_of(cloth(), malha.body(points, [[0, 1, 2], [1, 2, 3], [2, 3, 4]], name="scraps", mass=1 / 3,
                                         constraints=[{"type": "distance"}], rest={"points": points / 3}))
    scenes = [malha.Scene(given), malha.Scene(ROOT / "scenes" / "dressed.json")]
    for scene in scenes:
        assert copied(scene).to_json() == scene.to_json()
    hashes = set()
    for scene in (scenes[0], copied(scenes[0])):
        simulation = malha.Simulation(scene, threads=1)
        simulation.step(20)
        hashes.add(simulation.state_hash)
    assert len(hashes) == 1


def test_a_scene_that_was_sent_finds_its_mesh_from_another_folder(tmp_path, monkeypatch):
    (tmp_path / "mesh.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")
    body = {"name": "scrap", "shape": {"mesh": "mesh.obj"}, "mass": 1, "constraints": [{"type": "distance"}]}
    monkeypatch.chdir(tmp_path)
    sent = pickle.dumps(malha.Scene(scene_of(body)))
    monkeypatch.chdir("/")
    assert malha.Simulation(pickle.loads(sent)).positions.shape == (3, 3)


def test_rest_points_are_a_list_or_an_array():
    points = np.array([[0, 0, 0], [2, 0, 0], [0, 0, 2]], dtype=float)

    def scene_at_rest(rest):
        return scene_of(malha.body(points, [[0, 1, 2]], mass=1, constraints=[{"type": "distance"}], rest={"points": rest}))

    half = points / 2
    assert malha.Scene(scene_at_rest(half)).to_json() == malha.Scene(scene_at_rest(half.tolist())).to_json()
    assert malha.Scene(scene_at_rest(half)).to_dict()["bodies"][0]["rest"] == {"points": half.tolist()}
    simulation = malha.Simulation(scene_at_rest(half) | {"gravity": [0, 0, 0]})
    simulation.step(60)
    x = simulation.positions
    assert np.linalg.norm(x[1] - x[0]) == pytest.approx(1, abs=1e-3)
    with pytest.raises(malha.InputError, match="/bodies/0/rest/points: found a list of 2; allowed: a place for each of the 3"):
        malha.Simulation(scene_at_rest(half[:2]))
